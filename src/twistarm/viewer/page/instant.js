// The instantaneous screw of the tool: its axis, a helix about it where it has a pitch, and the tool's velocity.

import { dispose } from "./disposal.js";
import { AXIS, Arrow, LINEAR, hidden, rod, solid, vector } from "./solids.js";
import { THREE } from "./view.js";

const UP = new THREE.Vector3(0, 1, 0);
const LONG = 2.4; // of the axis, in sizes of the arm
const THIN = 0.0028;
const COIL = 0.05; // radius of the helix
const MOST_TURNS = 12;
const STEPS = 24; // of a turn

export class Instant {
  /** @type {InstanceType<typeof THREE.Group>} */ line;
  /** @type {InstanceType<typeof THREE.Group>} */ helix;
  /** @type {Arrow} */ velocity;

  constructor(view) {
    this.group = hidden(view);
    this.pitch = NaN;
  }

  build(axes) {
    dispose(this.group);
    this.axes = axes;
    this.line = new THREE.Group();
    this.axis = rod(AXIS);
    this.axis.scale.set(THIN * axes.size, LONG * axes.size, THIN * axes.size);
    this.helix = new THREE.Group();
    this.velocity = new Arrow(LINEAR, 0.008 * axes.size);
    this.line.add(this.axis, this.helix);
    this.group.add(this.line, this.velocity.group);
    this.pitch = NaN;
  }

  // `screw`: axis, point, pitch (null: infinite), magnitude; `velocity` of the tool's origin, per rad/s, at `tool`.
  show(screw, velocity, counted, tool) {
    const axis = vector(screw.axis);
    this.line.visible = screw.magnitude > 0;
    // A slide has no place: its axis is drawn through the tool.
    const point = screw.pitch === null ? tool.clone() : vector(screw.point);
    this.line.position.copy(point).addScaledVector(axis, axis.dot(tool.clone().sub(point)));
    if (this.line.visible) this.line.quaternion.setFromUnitVectors(UP, axis);
    this.coil(screw.pitch);
    this.velocity.set(tool, vector(velocity).multiplyScalar(this.axes.linear * counted));
  }

  // The way of a point beside the axis; `pitch` in m/rad along the axis, which is y here.
  coil(pitch) {
    if (pitch === this.pitch) return;
    this.pitch = pitch;
    dispose(this.helix);
    const { size } = this.axes;
    if (pitch === null || Math.abs(pitch) < 1e-6 * size) return;
    const turns = Math.min(MOST_TURNS, (0.8 * size) / (2 * Math.PI * Math.abs(pitch)));
    const count = Math.max(2, Math.ceil(STEPS * turns));
    const points = Array.from({ length: count + 1 }, (_, k) => {
      const angle = 2 * Math.PI * turns * (k / count - 0.5);
      // About y a positive turn leads from z to x.
      return new THREE.Vector3(COIL * size * Math.sin(angle), pitch * angle, COIL * size * Math.cos(angle));
    });
    const tube = new THREE.TubeGeometry(new THREE.CatmullRomCurve3(points), 2 * count, 1.2 * THIN * size, 6);
    this.helix.add(solid(tube, AXIS));
  }
}
