// What a hand on a handle means: the pose of the gizmo for each ray of the pointer. All in the arm's base axes, in m.

import { THREE } from "./view.js";

const EDGE = 0.25; // cosine to the eye below which a ring is seen from its edge

// What a drag is rounded to: 10 mm, 5°.
const STEPS = { move: 0.01, free: 0.01, turn: Math.PI / 36 };

export class Motion {
  // `kind` "move" along `axis`, "turn" about it, "free" in the plane of the screen; `frame`: the gizmo's own axes;
  // `pose` {position, quaternion} and `ray` where it begins; `eye` towards the camera; `radius` of the ring.
  constructor({ kind, axis, frame, pose, ray, eye, radius }) {
    this.kind = kind;
    this.axis = axis;
    this.frame = frame;
    this.pose = pose;
    this.eye = eye;
    this.radius = radius;
    this.flat = kind === "turn" && Math.abs(axis.dot(eye)) < EDGE;
    this.plane = new THREE.Plane().setFromNormalAndCoplanarPoint(this.normal(), pose.position);
    this.from = ray.intersectPlane(this.plane, new THREE.Vector3());
  }

  normal() {
    const { kind, axis, eye } = this;
    if (kind === "turn" && !this.flat) return axis.clone();
    if (kind === "move") return eye.clone().addScaledVector(axis, -eye.dot(axis)).normalize();
    return eye.clone();
  }

  // The pose for a ray; null where the ray misses the plane.
  at(ray, snap) {
    const to = ray.intersectPlane(this.plane, new THREE.Vector3());
    if (this.from === null || to === null) return null;
    const step = snap ? STEPS[this.kind] : 0;
    return this.kind === "turn" ? this.turned(rounded(this.angle(to), step)) : this.moved(to.sub(this.from), step);
  }

  // How far the pointer's ray turns [rad] or slides [m] along the axis; null where it misses the plane.
  amount(ray) {
    const to = ray.intersectPlane(this.plane, new THREE.Vector3());
    if (this.from === null || to === null) return null;
    return this.kind === "turn" ? this.angle(to) : to.sub(this.from).dot(this.axis);
  }

  moved(by, step) {
    const { kind, axis, frame, pose } = this;
    const shift = kind === "move" ? axis.clone().multiplyScalar(rounded(by.dot(axis), step)) : inSteps(by, frame, step);
    return { position: shift.add(pose.position), quaternion: pose.quaternion.clone() };
  }

  turned(angle) {
    const turn = new THREE.Quaternion().setFromAxisAngle(this.axis, angle);
    return { position: this.pose.position.clone(), quaternion: turn.multiply(this.pose.quaternion).normalize() };
  }

  // About the axis; where the ring is seen from its edge, its near side follows the pointer.
  angle(to) {
    const { axis, eye, pose, from } = this;
    if (this.flat) return to.clone().sub(from).dot(new THREE.Vector3().crossVectors(axis, eye).normalize()) / this.radius;
    const [before, after] = [from, to].map((point) => point.clone().sub(pose.position));
    return Math.atan2(new THREE.Vector3().crossVectors(before, after).dot(axis), before.dot(after));
  }
}

function inSteps(by, frame, step) {
  const local = by.applyQuaternion(frame.clone().invert());
  return local.set(...local.toArray().map((value) => rounded(value, step))).applyQuaternion(frame);
}

const rounded = (value, step) => step ? step * Math.round(value / step) : value;
