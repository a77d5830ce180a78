// What was asked and is not met: the tool's frame there, as far as the target names it, and the arm as it would have to
// stand without its limits, faintly.

import { ABOVE, ArmCopy, coloured, faint } from "./arm_copy.js";
import { dispose } from "./disposal.js";
import { COLORS, rod } from "./gizmo_shapes.js";
import { THREE } from "./view.js";

const SIZE = 0.22; // of the frame, beside the arm's radius
const THIN = 0.018; // of its rods, beside their length
const FRAME = 0.55; // opacities
const ARM = 0.22;
const NAMED = { pose: [0, 1, 2], approach: [2], position: [] }; // the axes of which a target speaks

export class Ghost {
  constructor(view) {
    this.view = view;
    this.late = null;
    this.frame = new THREE.Group();
    this.arm = new ArmCopy(view, "--warn", ARM);
    view.viewer.scene.add(this.frame, this.arm.group);
    this.messages = { target: (message) => this.show(message) };
  }

  hello() {
    this.clear();
  }

  // The arm stands, and its size is known.
  placed() {
    if (this.late) this.show(this.late);
  }

  clear() {
    dispose(this.frame);
    this.arm.clear();
  }

  show(message) {
    this.late = this.view.radius === undefined ? message : null;
    if (this.late) return;
    const { given, met, ghost } = message;
    if (ghost === null) this.arm.clear();
    else this.arm.stand(ghost);
    dispose(this.frame);
    if (given !== null && !met) this.drawFrame(given);
    this.view.viewer.set_dirty();
  }

  drawFrame({ kind, position, xyzw }) {
    const length = SIZE * this.view.radius;
    this.frame.position.fromArray(position);
    this.frame.quaternion.fromArray(xyzw);
    const axes = NAMED[kind].map((axis) => new THREE.Mesh(
      rod(THIN * length, THIN * length, 0, length, axis), faint(new THREE.Color(COLORS[axis]), FRAME, false)));
    const ball = new THREE.Mesh(new THREE.SphereGeometry(2.2 * THIN * length, 20, 12), faint(coloured("--warn"), FRAME, false));
    for (const part of [...axes, ball]) this.frame.add(Object.assign(part, { renderOrder: ABOVE }));
  }
}
