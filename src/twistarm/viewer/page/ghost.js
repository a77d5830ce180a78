// The target: the tool's frame there, as far as the target names it, and the arm as it would have to stand without its
// limits, faintly. Where the drawn tool frame stands at the target, the target has no axes of its own.

import { ABOVE, ArmCopy, coloured, faint } from "./arm_copy.js";
import { dispose } from "./disposal.js";
import { COLORS, CONE, RING, rod } from "./gizmo_shapes.js";
import { THREE, beforeRender } from "./view.js";

const SIZE = 0.22; // of the frame, beside the arm's radius
const THIN = 0.018; // of its rods, beside their length
const FRAME = 0.55; // opacities
const ARM = 0.22;
const NEAR = 0.1; // of the frame's length: nearer to each other, tool and target have one frame
const WITHIN = { tool: CONE.from, base: 0.85 * RING.radius }; // px: how long a frame at the handles is, by their axes
const NAMED = { pose: [0, 1, 2], approach: [2], position: [] }; // the axes of which a target speaks

export class Ghost {
  constructor({ view, links, state }) {
    this.view = view;
    this.links = links;
    /** @type {any} */ this.reported = null;
    /** @type {any} what is to be drawn with the next picture, once it is known how large */ this.next = null;
    this.frame = new THREE.Group();
    this.arm = new ArmCopy(view, "--warn", ARM);
    this.axes = [];
    /** @type {any} where the target is */
    this.ball = null;
    beforeRender(view, () => {
      if (this.next && view.radius !== undefined && state.frame) this.draw(this.next);
      this.share();
    });
    view.viewer.scene.add(this.frame, this.arm.group);
    view.onDrawn.push(() => (this.next = this.reported)); // what the ghost is a copy of has changed
    this.messages = { target: (message) => this.show(message) };
  }

  hello() {
    this.reported = this.next = null;
    dispose(this.frame);
    this.arm.clear();
  }

  show(message) {
    this.reported = this.next = message;
    this.view.viewer.set_dirty();
  }

  draw({ given, converged, ghost }) {
    this.next = null;
    if (ghost === null) this.arm.clear();
    else this.arm.stand(this.links(ghost));
    dispose(this.frame);
    if (given !== null) this.drawFrame(given, converged);
    for (const group of [this.frame, this.arm.group]) group.updateMatrixWorld(true); // the scene's are done for this picture
  }

  drawFrame({ kind, position, xyzw }, converged) {
    const length = SIZE * this.view.radius;
    this.frame.position.fromArray(position);
    this.frame.quaternion.fromArray(xyzw);
    this.axes = NAMED[kind].map((axis) => new THREE.Mesh(
      rod(THIN * length, THIN * length, 0, length, axis), faint(new THREE.Color(COLORS[axis]), FRAME, false)));
    this.ball = new THREE.Mesh(new THREE.SphereGeometry(2.2 * THIN * length, 20, 12), faint(coloured(converged ? "--converged" : "--warn"), FRAME, false));
    for (const part of [...this.axes, this.ball]) this.frame.add(Object.assign(part, { renderOrder: ABOVE }));
  }

  // With every picture: tool, target and handles have one frame where they stand together. At the handles it lies within
  // them, and their ball is that of the target.
  share() {
    const { view, frame } = this;
    const { group, unit, axes } = view.handles ?? {};
    const tool = view.node("/frames/tool");
    const length = SIZE * view.radius;
    const together = (a, b) => a.position.distanceTo(b.position) < NEAR * length;
    const scale = (node, long) => (group?.visible && together(node, group) ? (WITHIN[axes] * unit) / long : 1);
    for (const axis of tool.children) resize(axis, scale(tool, longest(axis)));
    if (frame.children.length === 0) return;
    const hidden = view.node("/frames").visible && together(frame, tool);
    for (const axis of this.axes) resize(Object.assign(axis, { visible: !hidden }), scale(frame, length));
    this.ball.visible = !(group?.visible && together(frame, group));
  }
}

function resize(axis, scale) {
  axis.scale.setScalar(scale);
  axis.updateMatrixWorld(true);
}

function longest(axis) {
  let length = 1;
  axis.traverse(({ geometry }) => { length = geometry?.parameters?.height ?? length; });
  return length;
}
