// The process of a saved page: it answers the requests of schema.json in place of Python. It keeps where the arm stands,
// its poses, its motion and its servo, and tells the page what has changed.

import { $$, element, unzipped } from "./element.js";
import { Glide } from "./glide.js";
import { Motion } from "./motion.js";
import { Playback } from "./playback.js";
import { Poses, requireInside } from "./process_poses.js";
import { Drive } from "./process_servo.js";
import { keep, kept } from "./storage.js";
import { withUnit } from "./units.js";

const PYTHON = "Needs Python: run twistarm view"; // what a saved page cannot do
const SPEEDS = [0.05, 20];
const MOST_SHOWN = 32; // configurations
const AT_SOLUTION = 1e-3; // rad, m: an arm this near to a configuration is at it
const ON_MOTION = 1e-8; // rad, m: an arm this near to its motion is on it
const FREEDOMS = { pose: 6, approach: 5, position: 3 };
const NO_TARGET = { type: "target", given: null, converged: null, words: "", ghost: null };
const NO_SOLUTIONS = { type: "solutions", requested: false, places: [], words: "", theta: [] };
const DRIVEN = "a servo drives the arm: turn off Drive in the Jog panel first";
const MOVES = ["theta", "pose", "random", "play", "seek", "target", "solutions", "solution", "go"]; // not while a servo drives

export class Process {
  kind = "saved";

  // `saved`: hello, the messages of the stage, the motion and the note about limits; `on` as for a Link.
  constructor(saved, core, on) {
    const byType = Object.fromEntries(saved.messages.map((message) => [message.type, message]));
    const { hello, motion, messages } = saved;
    this.name = `twistarm process ${saved.digest}`;
    /** @type {any} */
    const before = JSON.parse(kept(this.name, { session: true }) ?? "{}"); // this page, until it was loaded again
    const { theta, others, time, running } = before.frame ? { ...before.frame, running: false } : byType.frame;
    this.saved = saved;
    this.on = on;
    this.arm = hello.arm;
    this.joints = hello.arm.joints;
    this.theta = theta;
    this.others = others;
    this.core = core;
    this.poses = Object.assign(new Poses(hello.arm.joints, byType.program), before.poses);
    this.motion = motion && new Motion(motion);
    this.playback = motion && new Playback(this.motion.duration, { ...byType.player, ...before.player, time, running });
    this.again = before.frame !== undefined;
    this.onMotion = motion && near(this.motion.at(time).theta, theta, ON_MOTION) ? theta : null;
    this.tolerances = before.tolerances ?? byType.tolerances;
    this.target = before.target ?? byType.target;
    this.answer = this.target.given && theta; // where the arm stands for it
    /** @type {any} */
    this.choices = null; // {inside, message}
    /** @type {any} */
    this.at = this.current = this.where = null;
    this.glide = new Glide((now) => this.stand(now));
    this.drive = new Drive({ core: this.core, length: byType.axes.length, note: saved.note }, (now) => this.stand(now));
    this.reported = new Map(); // texts by type
    this.next = 0; // picture of a motion
    addEventListener("pagehide", () => this.remember());
    this.routes = this.routed();
    withhold(messages.map(({ type }) => type));
  }

  // Tells all that was saved: the page then stands as it stood.
  async begin() {
    const { hello, messages, objects } = this.saved;
    this.on.status("saved");
    this.on.message(hello);
    for (const object of parts(await unzipped(objects ?? globalThis.twistarmObjects))) this.on.object(object);
    const own = this.messages().map(({ type }) => type);
    for (const message of messages) if (!own.includes(message.type)) this.on.message(message);
    this.reported.clear(); // the answers to requests of the page so far are told again, after the messages they rest on
    this.publish();
    if (this.playback?.running) this.tick();
  }

  // How the page stood when it was saved. After a reload the browser's session has kept tabs and layers.
  remembered(state) {
    return this.again ? { ...state, tabs: undefined, layers: undefined } : state;
  }

  send(request) {
    queueMicrotask(() => this.receive(request));
    return true;
  }

  interrupt = this.send;

  receive({ type, ...fields }) {
    try {
      if (!(type in this.routes)) throw new Error(PYTHON);
      if (MOVES.includes(type)) this.requireFree();
      this.routes[type](fields);
    } catch (error) {
      this.on.message({ type: "error", message: error.message });
    }
    this.publish();
    this.on.idle();
  }

  routed() {
    const { poses, drive } = this;
    return {
      theta: ({ theta }) => this.go(this.checked(theta)),
      joint: ({ name, value }) => this.moveJoint(name, value),
      pose: ({ name, ease }) => this.go(this.named(name), ease),
      random: ({ ease }) => this.go(this.joints.map(({ range: [lower, upper] }) => lower + Math.random() * (upper - lower)), ease),
      needs() {},
      play: () => this.play(),
      pause: () => this.loaded("pause").pause(),
      seek: ({ time }) => this.seek(time),
      pace: ({ speed, loop }) => this.pace(speed, loop),
      target: (fields) => this.take(fields),
      tolerances: (fields) => this.allow(fields),
      release: () => this.release(),
      solutions: (target) => this.find(target),
      solution: ({ place, ease }) => this.step(place, ease),
      solutions_end: () => this.forget(),
      record: ({ name }) => poses.record(name, this.theta),
      rename: ({ id, name }) => poses.rename(id, name),
      move: ({ id, by }) => poses.moveBy(id, by),
      reorder: ({ id, place }) => poses.reorder(id, place),
      delete: ({ id }) => poses.delete(id),
      poses: ({ joints, poses: list }) => poses.replace(joints, list),
      undo: () => poses.back("undo"),
      redo: () => poses.back("redo"),
      go: ({ id, ease }) => this.go(poses.find(id).theta, ease),
      servo: ({ on }) => this.switch(on),
      on_unreachable: ({ what }) => drive.choose(what),
      jog: ({ twist, frame }) => drive.take({ twist, frame }),
      jog_joints: ({ rates }) => drive.take({ rates }),
      stop: () => drive.driven && drive.take(null),
    };
  }

  publish() {
    for (const message of this.messages()) {
      const text = JSON.stringify(message);
      if (this.reported.get(message.type) === text) continue;
      this.reported.set(message.type, text);
      this.on.message(message);
    }
  }

  messages() {
    if (this.answer !== null && this.answer !== this.theta) this.release();
    if (this.choices !== null && this.where !== this.goal) this.forget();
    const { playback, theta, others } = this;
    const { duration = null, speed = 1, loop = false, time = 0, running = false } = playback ?? {};
    const rates = this.onMotion === theta ? this.motion.at(time).rates : null;
    return [
      { type: "player", duration, speed, loop },
      this.tolerances, this.target, ...this.poses.messages(),
      this.choices?.message ?? NO_SOLUTIONS, { type: "solution", at: this.at, current: this.current },
      ...this.drive.messages(),
      { type: "frame", theta, others, time, running, rates },
    ];
  }

  // where the arm stands -----------------------------------------------------------------------------

  get goal() { return this.glide.goal ?? this.theta; }

  stand(theta) {
    this.theta = theta ?? this.theta;
    this.publish();
  }

  stop() {
    this.glide.stop();
    this.playback?.pause();
  }

  go(theta, ease = false) {
    this.stop();
    if (ease && !near(theta, this.theta, 0)) this.glide.go(this.theta, theta);
    else this.theta = theta;
  }

  moveJoint(name, value) {
    const other = this.arm.others.find((joint) => joint.name === name);
    if (!other) this.requireFree();
    const i = this.joints.findIndex((joint) => joint.name === name);
    if (i < 0 && !other) throw new Error(`${this.arm.name} has no joint ${name}`);
    requireInside(other ?? this.joints[i], value);
    if (other) this.others = { ...this.others, [name]: value };
    else this.go(this.theta.with(i, value));
  }

  checked(theta) {
    if (theta.length !== this.joints.length) throw new Error(`theta must be ${this.joints.length} numbers; got ${theta.length}`);
    theta.forEach((value, i) => requireInside(this.joints[i], value));
    return theta;
  }

  named(name) {
    if (Object.hasOwn(this.arm.poses, name)) return this.arm.poses[name];
    throw new Error(`${this.arm.name} has no pose ${name}`);
  }

  requireFree() {
    if (this.drive.driven) throw new Error(DRIVEN);
  }

  switch(on) {
    if (on && !this.core.driven) throw new Error(`${this.arm.name} has more joints than the servo of a page drives. ${PYTHON}`);
    if (on) this.go(this.checked(this.theta));
    this.drive.switch(on, this.theta);
  }

  // the motion ---------------------------------------------------------------------------------------

  loaded(doing) {
    if (this.playback) return this.playback;
    throw new Error(`There is no motion to ${doing}.`);
  }

  play() {
    const playback = this.loaded("play");
    this.stop();
    playback.play();
    this.tick();
  }

  tick() {
    cancelAnimationFrame(this.next); // of a run that was stopped a moment ago
    if (!this.playback.running) return;
    this.playback.advance();
    this.theta = this.onMotion = this.motion.at(this.playback.time).theta;
    this.publish();
    this.next = requestAnimationFrame(() => this.tick());
  }

  seek(time) {
    const playback = this.loaded("seek");
    this.stop();
    playback.seek(time);
    this.theta = this.onMotion = this.motion.at(playback.time).theta;
  }

  pace(speed, loop) {
    const playback = this.loaded("pace");
    const [slowest, fastest] = SPEEDS;
    const usual = speed >= slowest && speed <= fastest;
    if (speed !== playback.speed && !usual) throw new Error(`speed must be ${slowest} … ${fastest} times the motion's own; got ${speed}`);
    Object.assign(playback, { speed, loop });
  }

  // the target ---------------------------------------------------------------------------------------

  take({ stage, theta, converged, words, ghost, ...given }) {
    if (this.core.solves) this.core.target(given); // which refuses what is none
    this.go(this.checked(theta));
    this.answer = this.theta;
    this.target = { type: "target", given, converged, words, ghost: ghost.length > 0 ? ghost : null };
  }

  release() { [this.target, this.answer] = [NO_TARGET, null]; }

  allow(tolerances) {
    if (Math.min(...Object.values(tolerances)) < 0) throw new Error("Give tolerances above 0, or none for the usual ones.");
    this.tolerances = { type: "tolerances", ...tolerances };
  }

  find(target) {
    const where = this.goal;
    const found = this.core.configurations(target, where, this.tolerances);
    if (found === null) throw new Error(`This arm has no closed form for that target. ${PYTHON}`);
    const theta = found.theta.slice(0, MOST_SHOWN);
    const inside = Math.min(found.inside, MOST_SHOWN);
    const places = theta.map((row, i) => ({ free: i < inside ? found.free[i] : [], beyond: i < inside ? [] : this.beyond(row) }));
    const count = `${inside === 0 ? "no" : inside} configuration${inside === 1 ? "" : "s"} inside the limits`;
    const words = ["", `${count}${theta.length > inside ? `, ${theta.length - inside} outside` : ""}: ${this.completeness(target, found)}`].join("\n");
    this.choices = { inside, message: { type: "solutions", requested: true, places, words, theta } };
    this.where = where;
    this.at = this.current = inside > 0 && near(theta[0], where, AT_SOLUTION) ? 0 : null;
  }

  completeness({ kind }, { theta, exact, held, free }) {
    const always = this.joints.map(({ name }) => name).filter((name) => free.length > 0 && free.every((names) => names.includes(name)));
    if (held !== null) return `${held} is free. It stays where it is, and other values of it give more configurations`;
    if (this.joints.length > FREEDOMS[kind]) return "joints that the target leaves free stay where they are";
    if (theta.length > MOST_SHOWN) return `the nearest ${MOST_SHOWN} of ${theta.length}`;
    const which = always.length > 0 ? `each with ${always.join(", ")} free; ` : "";
    return which + (exact ? "all that exist, by the closed form" : "found by the closed form, more may exist");
  }

  beyond(theta) {
    return this.joints.flatMap(({ name, unit, limits }, i) => limits.flatMap((limit, side) => {
      if (limit === null || (side === 0 ? theta[i] >= limit : theta[i] <= limit)) return [];
      return [`${name} ${withUnit(theta[i], unit)} ${"<>"[side]} ${withUnit(limit, unit)}`];
    }));
  }

  // The arm goes to a configuration inside the limits; of another, the ghost shows.
  step(place, ease) {
    const theta = this.choices?.message.theta[place];
    if (!theta) throw new Error("the arm has moved since: press All configurations again");
    this.at = place;
    if (place >= this.choices.inside) return;
    this.current = place;
    this.where = theta;
    this.go(theta, ease);
  }

  forget() { this.choices = this.at = this.current = this.where = null; }

  // What was done here outlasts a reload, as a live view outlasts its pages.
  remember() {
    const { poses, made, steps } = this.poses;
    const byType = Object.fromEntries(this.messages().map((message) => [message.type, message]));
    keep(this.name, JSON.stringify({ ...byType, poses: { poses, made, steps } }), { session: true });
  }
}

// Disable what only Python can do, and say so in words too: a phone shows no titles. Later writes to these properties
// are ignored, as every part enables its own controls. `said`: types of the saved messages, such as a map of the reach.
function withhold(byType) {
  const fixed = (value) => ({ get: () => value, set() {} });
  const properties = { title: fixed(PYTHON), disabled: fixed(true), href: fixed("") };
  for (const area of $$("[data-python]")) {
    if (byType.includes(area.dataset.python)) continue;
    const reason = element(area.matches("fieldset") ? "p" : "small", "reason", area.matches("fieldset") ? `${PYTHON}.` : " (needs Python)");
    if (!area.matches("button")) area[area.matches("fieldset") ? "prepend" : "append"](reason);
    for (const control of [area, ...area.querySelectorAll("button, input, select, a")]) {
      Object.assign(control, { title: PYTHON, disabled: true, ariaDisabled: "true" }).removeAttribute("href");
      Object.defineProperties(control, properties);
    }
  }
}

const near = (a, b, within) => a.every((value, i) => Math.abs(value - b[i]) <= within);

// The objects in one buffer, each after its length.
function parts(buffer) {
  const found = [];
  for (let at = 0; at < buffer.byteLength;) {
    const length = new DataView(buffer).getUint32(at);
    found.push(new Uint8Array(buffer, at + 4, length));
    at += 4 + length;
  }
  return found;
}
