// The handles of the gizmo, sized in pixels: three rings, a cone on each axis beyond them, a ball in the middle. Nothing
// of it is like the tool's own frame, which is thin and has no heads. Each handle has a fat shape that is not drawn, to be
// taken hold of.

import { THREE } from "./view.js";

export const COLORS = [0xe0352b, 0x1f9d3a, 0x2f6fe4]; // x, y, z
const FREE = 0xf2f4f7;
const RIM = 0x39424e;
const LIT = 0xffb000;
const AXES = ["x", "y", "z"];
export const CONE = { from: 80, tip: 106, wide: 10, grip: 14 };
export const REACH = CONE.tip; // of the whole
export const RING = { radius: 64, thick: 2.6, grip: 8 };
const BALL = { radius: 9, grip: 17 };
const NEAR_AXIS = 0.97; // cosine beyond which an arrow points at the eye, and cannot be drawn along
const ON_TOP = 20; // drawn after all else

// name: "x" … "z" along, "rx" … "rz" about, "free"; axis: 0 … 2 of the gizmo's own axes.
class Handle {
  constructor(name, kind, axis, color, shapes, grip) {
    this.name = name;
    this.kind = kind;
    this.axis = axis;
    this.color = color;
    this.plain = color;
    this.allowed = true;
    this.material = new THREE.MeshBasicMaterial({ color, transparent: true, opacity: 0.92, depthTest: false, depthWrite: false });
    this.grip = new THREE.Mesh(grip, new THREE.MeshBasicMaterial({ visible: false }));
    this.group = new THREE.Group();
    for (const shape of shapes) {
      this.group.add(Object.assign(new THREE.Mesh(shape, this.material), { renderOrder: ON_TOP + (kind === "free" ? 1 : 0) }));
    }
    this.group.add(this.grip);
  }

  light(on) {
    this.material.color.set(on ? LIT : this.color);
    this.material.opacity = on ? 1 : 0.92;
  }

  // null: its own colour.
  paint(color) {
    this.color = color ?? this.plain;
    this.light(false);
  }

  // `eye`: the direction towards the camera in the gizmo's own axes.
  face(eye) {
    const along = Math.abs(eye.getComponent(this.axis ?? 0));
    this.group.visible = this.allowed && !(this.kind === "move" && along > NEAR_AXIS);
  }
}

export function makeHandles() {
  const handles = AXES.flatMap((name, axis) => [arrow(name, axis), ring(`r${name}`, axis)]);
  const ball = new THREE.SphereGeometry(BALL.radius, 24, 16);
  const free = new Handle("free", "free", null, FREE, [ball], new THREE.SphereGeometry(BALL.grip, 12, 8));
  free.group.add(rim());
  return [...handles, free];
}

// So that the ball is seen before what is as bright.
function rim() {
  const dark = new THREE.MeshBasicMaterial({ color: RIM, transparent: true, depthTest: false, depthWrite: false });
  return Object.assign(new THREE.Mesh(new THREE.SphereGeometry(BALL.radius + 2, 24, 16), dark), { renderOrder: ON_TOP });
}

function arrow(name, axis) {
  const { from, tip, wide, grip } = CONE;
  return new Handle(name, "move", axis, COLORS[axis], [rod(0, wide, from, tip, axis)], rod(grip, grip, from - 4, tip + 6, axis));
}

// From `from` to `to` along an axis, with its radii at `to` and at `from`.
export function rod(top, bottom, from, to, axis) {
  const made = new THREE.CylinderGeometry(top, bottom, to - from, 20).translate(0, (from + to) / 2, 0);
  return turned(made, axis, new THREE.Vector3(0, 1, 0));
}

function ring(name, axis) {
  const about = new THREE.Vector3(0, 0, 1);
  const shape = (thick, sides) => turned(new THREE.TorusGeometry(RING.radius, thick, sides, 72), axis, about);
  return new Handle(name, "turn", axis, COLORS[axis], [shape(RING.thick, 10)], shape(RING.grip, 8));
}

function turned(geometry, axis, from) {
  const to = new THREE.Vector3().setComponent(axis, 1);
  return geometry.applyQuaternion(new THREE.Quaternion().setFromUnitVectors(from, to));
}

export function makeTether() {
  const material = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.9, depthTest: false, depthWrite: false });
  const made = new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 8), material);
  return Object.assign(made, { renderOrder: ON_TOP - 1, visible: false });
}

export function stretch(tether, from, to, unit) {
  const along = new THREE.Vector3().subVectors(to, from);
  tether.scale.set(unit, Math.max(along.length(), 1e-9), unit);
  tether.position.addVectors(from, to).multiplyScalar(0.5);
  tether.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.normalize());
  tether.updateMatrixWorld(true);
}
