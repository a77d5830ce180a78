// The tool dragged, or told where to be: a target, and inverse kinematics after it, solved here. The process takes the
// answer, and tells it to every page.

import { $ } from "./element.js";
import { Gizmo } from "./gizmo.js";
import { bare } from "./keys.js";
import { PoseBoxes } from "./pose_boxes.js";
import { poseOf, startPose } from "./target_pose.js";
import { keep, kept } from "./storage.js";
import { Tolerances } from "./tolerances.js";
import { Verdict, inWords } from "./verdict.js";
import { THREE } from "./view.js";
import { report } from "./words.js";

const KINDS = [[6, "pose"], [5, "approach"], [0, "position"]]; // what an arm of at least so many joints begins with
const HINTS = {
  approach: "With 5 joints the target is a position and a direction of the tool. If the last joint rolls the tool, the arm reaches only directions in one plane.",
  position: "With fewer than 5 joints the target is a position. The tool's orientation is free.",
};
const MANY = "This arm has too many joints for the page's solver. Move it with its sliders.";
const FIRST = "Drag an arrow or a ring at the tool; G hides them.";
const DRAGGED = "twistarm dragged"; // whether somebody has, on any page
const PARALLEL = 0.999; // cosine from which a ring is about the axis that an approach points
const DRAGGED_SEARCHES = 1; // from where the arm stands: what is near is reached so, and what is missed costs little
/** @type {any} */
export const NONE = { given: null, converged: null, words: "", ghost: null };

export class Target {
  // `page` holds view, panel, state, core, ask(request) and move(to, target).
  constructor(page) {
    this.page = page;
    this.reported = NONE; // of the target, by whichever page
    this.given = null;
    this.tool = null;
    /** @type {any} the pose that a hand has dragged the tool to */
    this.held = null;
    /** @type {any} */
    this.start = null;
    this.driven = false;
    this.gizmo = new Gizmo(page.view, {
      begin: () => this.begin(),
      move: (pose) => this.move(pose),
      end: () => this.end(),
      cancel: () => this.cancel(),
      snap: () => $("target-snap").checked,
    });
    page.view.handles = this.gizmo;
    this.boxes = new PoseBoxes(page.panel, (pose) => this.solve(pose));
    this.verdict = new Verdict();
    this.tolerances = new Tolerances(page, () => this.again());
    this.messages = {
      target: (message) => this.show(message),
      tolerances: (message) => this.tolerances.show(message),
      servo: ({ driven }) => this.drive(driven),
    };
    $("drag-tool").checked = matchMedia("(hover: hover) and (pointer: fine)").matches; // with a mouse
    this.listen();
  }

  listen() {
    $("drag-tool").addEventListener("change", () => this.arrange());
    $("target-axes").addEventListener("change", () => this.arrange());
    $("target-kind").addEventListener("change", () => this.choose());
    $("target-release").addEventListener("click", () => this.page.ask({ type: "release" }));
    addEventListener("keydown", (event) => this.press(event));
  }

  get kind() { return $("target-kind").value; }

  // G takes hold of the tool, or lets it be.
  press(event) {
    if (event.code === "KeyG" && bare(event) && !$("drag-tool").disabled) $("drag-tool").click();
  }

  hello({ arm }) {
    $("target-kind").value = KINDS.filter(([least]) => arm.joints.length >= least)[0][1];
    this.begun = this.kind;
    this.tool = this.held = null;
    this.gizmo.drop();
    this.show(NONE);
  }

  offline() {
    this.gizmo.drop();
    this.settle();
  }

  drive(driven) {
    this.driven = driven;
    if (driven) this.settle();
    else this.arrange();
  }

  get shut() { return this.driven || !this.page.state.frame || !this.page.core.solves; }

  update(frame) {
    this.tool = poseOf(frame.transforms["/frames/tool"]);
    this.arrange();
  }

  // The target of whichever page, whether it is reached, and why not.
  show(message) {
    this.reported = message;
    this.given = message.given && { ...message.given, converged: message.converged };
    this.verdict.show(message);
    this.arrange();
  }

  // by hand ------------------------------------------------------------------------------------------

  begin() {
    this.start = { theta: this.page.state.frame.theta, reported: this.reported };
    this.verdict.busy(true);
    keep(DRAGGED, "true");
  }

  move(pose) {
    this.held = pose;
    this.solve(pose, DRAGGED_SEARCHES);
  }

  // What was missed in passing is looked for once more.
  end() {
    const { held } = this;
    this.settle();
    if (held && this.given?.converged === false) this.solve(held);
  }

  settle() {
    this.held = null;
    this.verdict.busy(false);
    this.arrange();
  }

  cancel() {
    const moved = this.held !== null;
    const { theta, reported } = this.start;
    this.settle();
    if (moved && reported.given) this.send(theta, reported);
    else if (moved && this.page.ask({ type: "theta", theta })) this.page.move({ theta }, NONE);
  }

  current() {
    if (this.given) return { kind: this.given.kind, position: this.given.position, xyzw: this.given.xyzw };
    return this.tool && { kind: this.kind, position: this.tool.position.toArray(), xyzw: this.tool.quaternion.toArray() };
  }

  choose() {
    this.again();
    this.arrange();
  }

  again() {
    if (this.given && !this.shut) this.solve(startPose(this.given, this.tool));
  }

  // `searches`: at most so many; usually as many as solve_ik takes.
  solve({ position, quaternion }, searches) {
    const { core, state } = this.page;
    const given = { kind: this.kind, position: position.toArray(), xyzw: quaternion.toArray() };
    const { theta } = state.frame;
    let found;
    try {
      found = core.solve(given, theta, { tolerances: this.tolerances, searches, posture: theta });
    } catch (error) {
      return this.page.panel.showError(error.message); // this can be no target
    }
    const words = inWords(state.hello, core, given, found, this.tolerances);
    return this.send(found.theta, { given, converged: found.converged, words, ghost: found.unlimited });
  }

  send(theta, { given, converged, words, ghost }) {
    const stage = this.page.state.hello.number;
    const sent = this.page.ask({ type: "target", stage, ...given, theta, converged, words, ghost: ghost ?? [] });
    if (sent) this.page.move({ theta }, { given, converged, words, ghost });
    else this.gizmo.drop();
  }

  arrange() {
    const { shut } = this;
    for (const id of ["drag-tool", "target-kind", "target-axes", "target-snap"]) $(id).disabled = shut;
    $("target-release").hidden = !this.given || shut;
    const hints = [kept(DRAGGED) ? "" : FIRST, this.kind === this.begun ? HINTS[this.kind] : ""].filter(Boolean);
    const lines = this.page.core?.solves === false ? [MANY] : $("drag-tool").checked && !shut ? hints : [];
    report($("target-hint"), lines[0] ?? "", lines.slice(1));
    this.tolerances.disable(this.driven);
    this.boxes.disable(shut, this.kind === "position");
    if (this.tool !== null) this.put();
  }

  put() {
    const pose = startPose(this.given, this.tool);
    this.boxes.show(pose);
    const { view } = this.page;
    const before = view.target;
    view.target = this.given ? pose.position : null;
    if (before !== null) view.settle();
    this.gizmo.place(this.held ?? (this.given?.converged ? this.tool : pose), this.tool, $("target-axes").value);
    const on = $("drag-tool").checked && !this.shut;
    this.gizmo.show(on, this.given?.converged ?? null, (handle, direction) => this.allows(handle, direction));
  }

  // A position has no turns, and an approach none about the axis that it points.
  allows({ kind }, direction) {
    if (kind !== "turn" || this.kind === "pose") return true;
    const pointed = new THREE.Vector3(...this.page.state.hello.arm.tool_axis).applyQuaternion(this.gizmo.pose.quaternion);
    return this.kind === "approach" && Math.abs(direction.dot(pointed)) < PARALLEL;
  }
}
