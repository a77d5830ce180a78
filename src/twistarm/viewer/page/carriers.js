// Which joint of the panel moves what is drawn, and about or along which screw.

import { THREE } from "./view.js";

const { Matrix4, Vector3 } = THREE;

export class Carriers {
  // `kinematics` as kinematics.py describes it.
  constructor({ arm, kinematics: { base, joints, nodes } }) {
    this.coordinates = [...arm.joints, ...arm.others];
    this.joints = joints;
    this.nodes = nodes;
    this.below = new Set(); // joints that carry the base: their links stand still, seen from it
    for (let i = base; i !== null; i = joints[i].parent) this.below.add(i);
  }

  // The joint, its place among the coordinates, its rad or m for one of the screw (`factor`), whether that turns, and
  // the node to point at; null: nothing moves it.
  of(path) {
    const { joint } = this.nodes[path];
    if (joint === null || this.below.has(joint) || this.joints[joint].terms.length === 0) return null;
    const { screw, terms } = this.joints[joint];
    const [place, ratio] = terms.reduce((most, term) => (Math.abs(term[1]) > Math.abs(most[1]) ? term : most));
    const turn = Math.hypot(...screw.slice(3));
    const node = Object.keys(this.nodes).find((name) => name.startsWith("/screws/") && this.nodes[name].joint === joint) ?? path;
    return { joint: this.coordinates[place], place, factor: 1 / (ratio * (turn || Math.hypot(...screw))), turns: turn > 0, node };
  }

  // Of the joint that moves the node `path`, drawn at the matrix `drawn`: the direction of its axis, and a point of it.
  axis(path, drawn) {
    const { joint, rest } = this.nodes[path];
    const [v, w] = [0, 3].map((from) => new Vector3(...this.joints[joint].screw.slice(from, from + 3)));
    const moved = new Matrix4().fromArray(drawn).multiply(new Matrix4().fromArray(rest).invert());
    const point = w.clone().cross(v).divideScalar(w.lengthSq() || 1); // MLS, section 2.3.2
    return { axis: (w.lengthSq() ? w : v).transformDirection(moved), point: point.applyMatrix4(moved) };
  }
}
