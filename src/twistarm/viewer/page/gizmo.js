// Handles at the tool that a mouse or a finger takes hold of. They keep their size on the screen and shine through.

import { coloured } from "./arm_copy.js";
import { Motion } from "./gizmo_motion.js";
import { REACH, RING, makeHandles, makeTether, stretch } from "./gizmo_shapes.js";
import { THREE, beforeRender, followHand } from "./view.js";

export class Gizmo {
  // `act` holds begin(), move(pose), end(), cancel(), and snap() whether to round; a pose is {position, quaternion}.
  constructor(view, act) {
    this.view = view;
    this.act = act;
    this.axes = "base";
    this.unit = 1;
    this.lit = null;
    this.motion = null;
    this.painted = null;
    this.pose = { position: new THREE.Vector3(), quaternion: new THREE.Quaternion() };
    this.tool = this.pose;
    this.handles = makeHandles();
    this.free = this.handles.filter(({ kind }) => kind === "free")[0];
    this.tether = makeTether();
    this.group = new THREE.Group();
    this.group.visible = false;
    this.group.add(...this.handles.map(({ group }) => group));
    this.caster = new THREE.Raycaster();
    view.viewer.scene.add(this.group, this.tether);
    view.gizmos.push(this);
    this.scale();
    followHand(view, this);
    view.viewer.dom_element.addEventListener("pointerleave", () => this.motion || this.light(null));
  }

  // With every picture, after the camera: whichever camera it is, and wherever it has gone.
  scale() {
    beforeRender(this.view, (renderer, scene, camera) => {
      if (this.group.visible) this.face(camera, renderer.domElement.clientHeight);
      if (this.tether.visible) stretch(this.tether, this.pose.position, this.tool.position, this.unit);
    });
  }

  // How far they reach (world) in a view of this height [px], seen from `eye`; none where they are not visible.
  corners(eye, height) {
    if (!this.group.visible) return [];
    const middle = this.view.viewer.scene.localToWorld(this.pose.position.clone());
    const slope = Math.tan((this.view.viewer.camera.fov * Math.PI) / 360);
    const reach = (2 * REACH * slope * eye.distanceTo(middle)) / height;
    return [0, 1, 2].flatMap((axis) => [-reach, reach].map((by) => new THREE.Vector3().setComponent(axis, by).add(middle)));
  }

  // What its rings take of the picture [px], as a list of one; none where they are not visible.
  square() {
    if (!this.group.visible) return [];
    const { camera, dom_element, scene } = this.view.viewer;
    const { x, y } = scene.localToWorld(this.pose.position.clone()).project(camera);
    const [left, top] = [0.5 * (x + 1) * dom_element.offsetWidth, 0.5 * (1 - y) * dom_element.offsetHeight];
    return [{ left: left - RING.radius, right: left + RING.radius, top: top - RING.radius, bottom: top + RING.radius }];
  }

  face(camera, height) {
    const { scene } = this.view.viewer;
    const here = scene.localToWorld(this.pose.position.clone());
    const above = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 1).normalize().add(here);
    const rise = above.project(camera).y - here.clone().project(camera).y; // of a metre, in half heights of the view
    this.unit = 2 / (Math.max(Math.abs(rise), 1e-6) * height);
    const eye = this.eye(camera).applyQuaternion(this.group.quaternion.clone().invert());
    for (const handle of this.handles) handle.face(eye);
    this.group.scale.setScalar(this.unit);
    this.group.updateMatrixWorld(true);
  }

  eye(camera) {
    const { scene } = this.view.viewer;
    return scene.worldToLocal(camera.getWorldPosition(new THREE.Vector3())).sub(this.pose.position).normalize();
  }

  // Stand at `pose` with its handles along base or tool axes; the tool itself may stand elsewhere.
  place(pose, tool, axes) {
    this.pose = pose;
    this.tool = tool;
    this.axes = axes;
    this.group.position.copy(pose.position);
    this.group.quaternion.copy(this.frame());
    this.view.viewer.set_dirty();
  }

  // `allows(handle, direction)`: which handles, by their direction in base axes; `converged`: whether the tool has reached the target,
  // null where there is none.
  show(on, converged, allows) {
    for (const handle of this.handles) handle.allowed = allows(handle, this.direction(handle));
    const other = on !== this.group.visible;
    this.group.visible = on;
    if (other) this.view.reframe();
    this.tether.visible = on && converged === false;
    if (converged !== this.painted) this.report(converged);
    if (on) return;
    this.drop();
    this.light(null);
  }

  report(converged) {
    this.painted = converged;
    this.tether.material.color.set(coloured("--warn"));
    this.free.paint(converged === null ? null : coloured(converged ? "--converged" : "--warn"));
    this.lit?.light(true);
  }

  frame() { return this.axes === "tool" ? this.pose.quaternion.clone() : new THREE.Quaternion(); }

  direction({ axis }) {
    return axis === null ? null : new THREE.Vector3().setComponent(axis, 1).applyQuaternion(this.frame());
  }

  // by hand ------------------------------------------------------------------------------------------

  grab(event) {
    const free = this.view.viewer.controls.enabled; // no other handles are held
    const handle = event.button === 0 && event.isPrimary && free && !this.motion ? this.hit(event) : null;
    if (!handle) return;
    const { camera, controls } = this.view.viewer;
    this.controls = controls;
    controls.enabled = false;
    this.pointer = event.pointerId;
    event.target.setPointerCapture(event.pointerId);
    this.light(handle);
    this.motion = new Motion({
      kind: handle.kind, axis: this.direction(handle), frame: this.frame(), pose: this.pose,
      ray: this.view.ray(event), eye: this.eye(camera), radius: RING.radius * this.unit,
    });
    this.act.begin();
  }

  follow(event) {
    if (!this.motion) {
      if (event.buttons === 0 && event.pointerType !== "touch") this.light(this.hit(event));
    } else if (event.pointerId === this.pointer) {
      const pose = this.motion.at(this.view.ray(event), this.act.snap() !== event.shiftKey);
      if (pose) this.act.move(pose);
    }
  }

  release(event) {
    if (!this.motion || event.pointerId !== this.pointer) return;
    this.drop();
    this.act.end();
    if (event.pointerType === "touch") this.light(null);
  }

  escape(event) {
    if (!this.motion || event.key !== "Escape") return;
    event.preventDefault();
    event.stopPropagation();
    this.drop();
    this.act.cancel();
  }

  drop() {
    if (!this.motion) return;
    this.motion = null;
    for (const controls of [this.controls, this.view.viewer.controls]) controls.enabled = true;
    this.view.settle();
  }

  light(handle) {
    if (this.lit === handle) return;
    this.lit?.light(false);
    handle?.light(true);
    this.lit = handle;
    this.view.viewer.dom_element.style.cursor = handle ? "grab" : "";
    this.view.viewer.set_dirty();
  }

  // The handle under the pointer: the ball before the others, then whichever is nearest to the eye. Within the rings,
  // where nothing is, the ball is taken too: a grab that just misses a handle must not turn the view.
  hit(event) {
    if (!this.group.visible) return null;
    this.caster.setFromCamera(this.view.onScreen(event), this.view.viewer.camera);
    const visible = this.handles.filter(({ group }) => group.visible);
    const hits = this.caster.intersectObjects(visible.map(({ grip }) => grip));
    const found = hits.map(({ object }) => visible.find(({ grip }) => grip === object));
    const ball = visible.find(({ kind }) => kind === "free");
    return found.includes(ball) ? ball : (found[0] ?? (this.within(this.caster.ray) ? ball : null));
  }

  within(ray) {
    const { scene } = this.view.viewer;
    return ray.distanceToPoint(scene.localToWorld(this.pose.position.clone())) < RING.radius * this.unit;
  }
}
