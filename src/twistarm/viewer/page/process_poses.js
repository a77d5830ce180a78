// The recorded poses of a saved page: each with a unique number and name; undo and redo of their changes. As pose_list.py.

import { withUnit, span } from "./units.js";

const LONGEST_NAME = 60;
const MOST_STEPS = 100; // that can be undone
const ROUNDING = 1e-6; // rad, m: a value may lie this far beyond a limit
const START = { rad: 0.2, m: 0.02 }; // the first pose, a measured start, this far
const MOVES = ["joint", "line", "screw", "via", "free", "level", "direction", "orientation"];
const STALE = "The list has changed since this motion was planned: plan again.";

// An Error where a joint's value is farther beyond its limits than `spare`.
export function requireInside({ name, unit, range, limits: [lower, upper] }, value, spare = ROUNDING) {
  if (value >= (lower ?? -Infinity) - spare && value <= (upper ?? Infinity) + spare) return;
  throw new Error(`${name} = ${withUnit(value, unit)} is outside its limits ${span(range, unit)}`);
}

export class Poses {
  // `program`: the message as it was saved, perhaps of a planned motion.
  constructor(joints, program) {
    this.joints = joints;
    this.program = program;
    this.through = program.planned ? listed(program.poses) : null; // the list that the motion was planned through
    this.poses = program.poses;
    this.made = Math.max(0, ...this.poses.map(({ id }) => id));
    /** @type {Object<string, any[]>} */
    this.steps = { undo: [], redo: [] }; // {words, poses}: each change, and the list without it
  }

  messages() {
    const { program, poses, steps } = this;
    const planned = this.through === listed(poses);
    const note = planned ? program.note : program.kind === null ? "" : STALE;
    const [undo, redo] = [steps.undo, steps.redo].map((changes) => changes.at(-1)?.words ?? null);
    return [{ ...program, poses, planned, note }, { type: "history", undo, redo }];
  }

  record(name, theta) {
    this.keep("record a pose", [...this.poses, this.pose(name, theta, this.poses)]);
  }

  rename(id, name) {
    this.change("rename a pose", id, (pose) => [{ ...pose, name: free(name, this.poses.filter((other) => other !== pose)) }]);
  }

  moveBy(id, by) {
    this.change("choose a move", id, (pose) => [{ ...pose, by }]);
  }

  delete(id) {
    this.change("delete a pose", id, () => []);
  }

  reorder(id, place) {
    const pose = this.find(id);
    const others = this.poses.filter((other) => other !== pose);
    const poses = [...others.slice(0, place), pose, ...others.slice(place)];
    for (const later of poses.slice(1)) this.require(later);
    this.keep("reorder the poses", poses);
  }

  replace(joints, poses) {
    const order = this.joints.map(({ name }) => joints.indexOf(name));
    if (order.includes(-1) || joints.length !== order.length) {
      throw new Error(`the list is for the joints ${joints.join(", ")}; this arm has ${this.joints.map(({ name }) => name).join(", ")}`);
    }
    const accepted = [];
    for (const { name, theta, by } of poses) {
      if (theta.length !== order.length) throw new Error(`the pose '${name}' has ${theta.length} values, and the list moves ${order.length} joints`);
      accepted.push(this.pose(name, order.map((place) => theta[place]), accepted, by));
    }
    this.keep("load a list", accepted);
  }

  back(kind) {
    const step = this.steps[kind].pop();
    if (!step) throw new Error(`nothing to ${kind} in the list of poses`);
    this.steps[kind === "undo" ? "redo" : "undo"].push({ words: step.words, poses: this.poses });
    this.poses = step.poses;
  }

  find(id) {
    const pose = this.poses.find((other) => other.id === id);
    if (!pose) throw new Error(`no pose number ${id} in the list: it was deleted, or another list was loaded`);
    return pose;
  }

  pose(name, theta, others, by = "joint") {
    if (!MOVES.includes(by)) throw new Error(`a pose is reached by ${MOVES.join(", ")}; '${name}' has ${by}`);
    const made = { id: this.made + 1, name: free(name, others), theta, by };
    this.require(made, others.length === 0);
    this.made += 1;
    return made;
  }

  require({ name, theta }, first = false) {
    try {
      theta.forEach((value, i) => requireInside(this.joints[i], value, first ? START[this.joints[i].unit] : undefined));
    } catch (error) {
      throw new Error(`the pose '${name}': ${error.message}; only the first pose, the start, may be a little outside`);
    }
  }

  change(words, id, made) {
    const pose = this.find(id);
    this.keep(words, this.poses.flatMap((other) => (other === pose ? made(pose) : [other])));
  }

  keep(words, poses) {
    if (JSON.stringify(poses) === JSON.stringify(this.poses)) return;
    this.steps = { undo: [...this.steps.undo.slice(1 - MOST_STEPS), { words, poses: this.poses }], redo: [] };
    this.poses = poses;
  }
}

// What a plan depends on: the poses in order, and the move to each.
const listed = (poses) => JSON.stringify(poses.map(({ id, by }, i) => [id, i > 0 && by]));

// The name, made up if empty, with a number if another pose has it.
function free(name, others) {
  const bare = name.trim().replace(/\s+/g, " ");
  const accepted = others.map((other) => other.name);
  if (bare.length > LONGEST_NAME) throw new Error(`a pose's name has at most ${LONGEST_NAME} characters; got ${bare.length}`);
  if (bare && !accepted.includes(bare)) return bare;
  let number = bare ? 2 : others.length + 1;
  while (accepted.includes(`${bare || "pose"} ${number}`)) number += 1;
  return `${bare || "pose"} ${number}`;
}
