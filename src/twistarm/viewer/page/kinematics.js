// Forward kinematics in the page: products of exponentials, as kinematics.py describes them.

import { THREE } from "./view.js";

const { Matrix4, Vector3 } = THREE;
const GIMBAL_LOCK = 1e-9;

export class Kinematics {
  constructor({ base, joints, nodes }) {
    this.base = base;
    this.joints = joints;
    this.nodes = Object.entries(nodes).map(([path, { joint, rest }]) => [path, joint, new Matrix4().fromArray(rest)]);
  }

  // {path: sixteen numbers, column by column} at the coordinates: theta, and the joints beside the chain.
  transforms(coordinates) {
    const moved = []; // E of each joint; its parent stands before it
    for (const { parent, screw, terms } of this.joints) {
      const value = terms.reduce((sum, [i, factor]) => sum + factor * coordinates[i], 0);
      const step = exp(screw, value);
      moved.push(parent === null ? step : step.premultiply(moved[parent]));
    }
    const back = this.base === null ? new Matrix4() : moved[this.base].clone().invert();
    return Object.fromEntries(this.nodes.map(([path, joint, rest]) => {
      const g = joint === null ? back.clone() : back.clone().multiply(moved[joint]);
      return [path, g.multiply(rest).toArray()];
    }));
  }
}

// The motion of the unit twist ξ = (v, w) by q [rad or m]: MLS, proposition 2.9.
function exp(screw, q) {
  const [v, w] = [new Vector3(...screw.slice(0, 3)), new Vector3(...screw.slice(3))];
  const turn = w.length();
  if (turn === 0) return new Matrix4().makeTranslation(q * v.x, q * v.y, q * v.z);
  const axis = w.clone().divideScalar(turn);
  const g = new Matrix4().makeRotationAxis(axis, turn * q);
  const point = axis.clone().cross(v).divideScalar(turn); // of the axis
  const along = axis.clone().multiplyScalar(q * axis.dot(v));
  const shift = point.clone().sub(point.clone().applyMatrix4(g)).add(along);
  return g.setPosition(shift);
}

// Position [m] and rpy [rad] of a pose by columns, as the process tells them.
export function told(g) {
  const [r00, r10, r20, , r01, r11, , , r02, r12] = g;
  const radius = Math.hypot(r00, r10);
  const yaw = radius <= GIMBAL_LOCK ? 0 : Math.atan2(r10, r00);
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  return { position: g.slice(12, 15), rpy: [Math.atan2(s * r02 - c * r12, c * r11 - s * r01), Math.atan2(-r20, radius), yaw] };
}
