// The compiled core in the page: kinematics, inverse kinematics, all configurations and the servo of an arm.

import { bytes, unzipped } from "./element.js";

const KINDS = ["pose", "position", "approach"]; // of targets, in the core's order
const TARGET = 23; // numbers of a target of any kind
const FARTHEST = 1e6; // of a target [m]
const LENGTH_TOL = 1e-3; // rounding of a quaternion's length, from decimal text
export const DEFAULTS = { position: 1e-5, orientation: 5e-5 }; // tolerances of solve_ik [m], [rad]
const SEARCHES = 100; // most searches of solve_ik
const EXACT = 1e-9; // errors of a configuration of a closed form, whatever the tolerances are [m], [rad]
const LONGEST_STEP = 0.1; // of a servo [s]
const [MOVING, SINGULARITY, STALE] = [0, 1, 5]; // its causes, in the core's order
const GIMBAL_LOCK = 1e-9; // cosine of the pitch from which on the yaw counts as 0
const unpacked = (text) => new Float64Array(bytes(text).buffer);

// The compiled module, of the saved page or of the server.
export async function loaded() {
  const packed = document.getElementById("core")?.textContent ?? globalThis.twistarmCore;
  if (packed === undefined) return WebAssembly.compileStreaming(fetch("arm.wasm"));
  return new WebAssembly.Module(await unzipped(packed)); // at once: who draws a picture waits for no other thread
}

export class Core {
  // `module`: of loaded(). The rest are fields of `hello`, or of its `beside`.
  constructor(module, { arm, kinematics, core }) {
    /** @type {any} */ const system = {}; // the module asks it for nothing that matters here
    for (const { module: from, name } of WebAssembly.Module.imports(module)) (system[from] ??= {})[name] = () => 0;
    /** @type {any} */ this.core = new WebAssembly.Instance(module, system).exports;
    this.core._initialize();
    this.arm = arm;
    this.numbers = core;
    this.n = arm.joints.length;
    this.nodes = Object.keys(kinematics.nodes);
    this.call("tree", this.tree(kinematics));
    const made = (name, numbers) => typeof numbers === "string" && this.call(name, unpacked(numbers)).made;
    this.solves = made("arm", core?.arm);
    this.driven = this.solves && made("servo", core.servo);
    this.forms = KINDS.filter((kind) => this.solves && made("closed_form", core.forms[kind]));
  }

  // Calls a function of module.cpp with these numbers. The answer is there until the next call.
  call(name, numbers, room = 0) {
    const at = this.core.numbers(Math.max(numbers.length, room));
    new Float64Array(this.core.memory.buffer, at, numbers.length).set(numbers);
    const made = this.core[name]() === 1;
    const answer = new Float64Array(this.core.memory.buffer, this.core.numbers(0));
    return { made, many: (first, count) => Array.from(answer.subarray(first, first + count)) };
  }

  tree({ base, joints, nodes }) {
    const coordinates = Array.from({ length: this.n + this.arm.others.length }, (_, i) => i);
    const row = (terms) => coordinates.map((i) => terms.find(([place]) => place === i)?.[1] ?? 0);
    const moving = joints.flatMap(({ parent, screw, terms }) => [parent ?? -1, ...screw, ...row(terms)]);
    const fixed = this.nodes.flatMap((path) => [nodes[path].joint ?? -1, ...nodes[path].rest]);
    return [coordinates.length, base ?? -1, joints.length, this.nodes.length, ...moving, ...fixed];
  }

  // Where each node stands, {path: sixteen numbers by columns}, and the tool. `others`: {name: value} beside the chain.
  place(theta, others) {
    const x = [...this.checked(theta), ...this.arm.others.map(({ name }) => others[name])];
    const { many } = this.call("poses", x, 16 * this.nodes.length);
    const transforms = Object.fromEntries(this.nodes.map((path, k) => [path, many(16 * k, 16)]));
    return { transforms, tool: toolOf(transforms["/frames/tool"]) };
  }

  links(theta, others) {
    return Object.fromEntries(Object.entries(this.place(theta, others).transforms).filter(([path]) => path.startsWith("/arm/")));
  }

  // g_st (4, 4), J^s and J^b (6, n) by rows, linear part first.
  kinematics(theta) {
    const { many } = this.run("kinematics", this.checked(theta));
    const rows = (first, count, width) => Array.from({ length: count }, (_, i) => many(first + i * width, width));
    return { g: rows(0, 4, 4), spatial: rows(16, 6, this.n), body: rows(16 + 6 * this.n, 6, this.n) };
  }

  // As solve_ik. `target`: kind, position [m] and xyzw, as in the requests; tolerances [m], [rad], 0 for the default.
  solve(target, theta0, { tolerances = {}, searches = SEARCHES, posture = null } = {}) {
    const { position, orientation } = allowed(tolerances);
    const how = [KINDS.indexOf(target.kind), position, orientation, searches, Number(posture !== null)];
    const start = [...this.checked(theta0), ...(posture === null ? [] : this.checked(posture))];
    const { many } = this.run("solve", [...how, ...this.target(target), ...start]);
    const [stop, nearest, otherBranch, certain, free, positionError, orientationError, iterations, restarts] = many(0, 9);
    return {
      converged: stop === 0, stop: Object.keys(this.numbers.reasons)[stop], theta: many(9, this.n),
      unlimited: free ? many(9 + this.n, this.n) : null, positionError, orientationError,
      nearest: nearest === 1, otherBranch: otherBranch === 1, certain: certain === 1, iterations, restarts,
    };
  }

  // Of the rotation error at theta [rad]: what no motion lessens, with its axis in the tool's axes, and what limits do.
  split(target, theta) {
    const { many } = this.run("split", [KINDS.indexOf(target.kind), ...this.target(target), ...this.checked(theta)]);
    const [impossible, prevented, ...axis] = many(0, 5);
    return { impossible, prevented, axis };
  }

  // All configurations by the closed form: first the `inside` ones, nearest to `near` first. Joints that the target
  // leaves free stay where `near` has them. free: the names of joints that may move for themselves.
  configurations(target, near, tolerances = {}) {
    if (!this.forms.includes(target.kind)) return null;
    const { position, orientation } = allowed(tolerances);
    const how = [KINDS.indexOf(target.kind), Math.min(position, EXACT), Math.min(orientation, EXACT)];
    const { many } = this.run("configurations", [...how, ...this.target(target), ...this.checked(near)]);
    const [count, inside, families] = many(0, 3);
    const rows = Array.from({ length: count }, (_, i) => many(3 + 2 * i * this.n, 2 * this.n));
    const free = rows.map((row) => this.arm.joints.filter((_, i) => row[this.n + i] === 1).map(({ name }) => name));
    const [, exact, swept] = unpacked(this.numbers.forms[target.kind]); // as core_numbers.py packs them
    const held = swept < 0 ? null : this.arm.joints[swept].name; // the joint that is searched where Python sweeps it
    return { theta: rows.map((row) => row.slice(0, this.n)), inside, families, free, exact: exact === 1, held };
  }

  // A simulated servo with the usual limits; onUnreachable: "slide" or "stop".
  servo({ onUnreachable = "slide" } = {}) {
    if (!this.driven) throw new Error(`${this.arm.name} has too many joints or motors for the servo of this page`);
    return {
      rest: (theta) => ({ theta: this.checked(theta), thetaDot: theta.map(() => 0), held: null, flags: 0, period: 0 }),
      step: (state, command, dt) => this.step(state, command, dt, onUnreachable === "stop"),
    };
  }

  // As servo_step. `command`: {rates}, {twist, frame, hold: six flags}, {goal: g by rows, velocity, speeds: [m/s, rad/s]}
  // or null to come to rest.
  step(state, command, dt, stops) {
    const [kind, flags, numbers] = commanded(command);
    const held = flags > 1 && state.flags === flags ? state.held : null;
    const time = dt <= LONGEST_STEP ? dt : NaN; // with NaN the arm stands still at once
    const given = [Number(stops), kind, flags, time, state.period, Number(held !== null), ...numbers, ...state.theta, ...state.thetaDot, ...(held ?? [])];
    const { many } = this.run("servo_step", given);
    const [found, row, scale, lostShare, halted, metres, radians, period] = many(0, 8);
    const cause = command ? found : STALE;
    const kept = flags > 1 ? many(14 + 2 * this.n, 16) : null;
    const after = { theta: many(14, this.n), thetaDot: many(14 + this.n, this.n), held: kept, flags, period };
    return { ...this.cause(cause, row), state: after, scale: cause === STALE ? 0 : scale, lost: many(8, 6), lostShare, halted: halted === 1, remaining: [metres, radians] };
  }

  // The name of a cause, its status and words, and the name of the joint or motor that it is about.
  cause(cause, row) {
    const [name, status, words] = this.numbers.causes[cause];
    const joint = row < 0 || cause === MOVING ? null : cause === SINGULARITY ? this.arm.joints[row].name : this.numbers.rows[row];
    return { cause: name, status, words, row, joint };
  }

  run(name, numbers) {
    if (!this.solves) throw new Error(`${this.arm.name} has too many joints for the solver of this page`);
    return this.call(name, numbers);
  }

  checked(theta) {
    if (theta.length === this.n && theta.every(Number.isFinite)) return [...theta];
    throw new Error(`a configuration of ${this.arm.name} is ${this.n} finite numbers; got ${theta}`);
  }

  target({ kind, position, xyzw }) {
    const R = rotation(xyzw);
    if (!KINDS.includes(kind)) throw new Error(`a target is one of ${KINDS.join(", ")}; got ${kind}`);
    if (!position.every((value) => Math.abs(value) <= FARTHEST)) throw new Error(`Give a position at most ${FARTHEST} m away; got ${position}`);
    const axis = R.map((row) => row.reduce((sum, value, i) => sum + value * this.arm.tool_axis[i], 0));
    const pose = R.flatMap((row, i) => [...row, position[i]]);
    const numbers = { pose: [...pose, 0, 0, 0, 1], position, approach: [...position, ...axis, ...this.arm.tool_axis] }[kind];
    return [...numbers, ...new Array(TARGET - numbers.length).fill(0)];
  }
}

const allowed = ({ position = 0, orientation = 0 }) => ({ position: position || DEFAULTS.position, orientation: orientation || DEFAULTS.orientation });

// The rows of R of a unit quaternion.
function rotation(xyzw) {
  const length = Math.hypot(...xyzw);
  if (!(Math.abs(length - 1) <= LENGTH_TOL)) throw new Error(`xyzw is a quaternion of length 1; got ${xyzw}`);
  const [x, y, z, w] = xyzw.map((part) => part / length);
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
  ];
}

function commanded(command) {
  if (!command) return [0, 0, []];
  const { rates, twist, frame = "tool", hold = [], goal, velocity = [0, 0, 0, 0, 0, 0], speeds = [0.25, 1] } = command;
  if (rates) return [1, 0, rates];
  if (goal) return [3, 1, [...goal, ...velocity, ...speeds]];
  return [2, hold.reduce((flags, held, k) => flags + (held ? 2 << k : 0), Number(frame === "base")), twist];
}

// Position [m] and rpy [rad] of a pose by columns.
function toolOf(g) {
  const [r00, r10, r20, , r01, r11, , , r02, r12] = g;
  const radius = Math.hypot(r00, r10);
  const yaw = radius <= GIMBAL_LOCK ? 0 : Math.atan2(r10, r00);
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  return { position: g.slice(12, 15), rpy: [Math.atan2(s * r02 - c * r12, c * r11 - s * r01), Math.atan2(-r20, radius), yaw] };
}
