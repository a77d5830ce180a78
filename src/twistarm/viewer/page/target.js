// The tool dragged, or told where to be: a target, and inverse kinematics after it.

import { $ } from "./element.js";
import { Gizmo } from "./gizmo.js";
import { bare } from "./keys.js";
import { PoseBoxes } from "./pose_boxes.js";
import { poseOf, same, standing } from "./target_pose.js";
import { keep, kept } from "./storage.js";
import { Tolerances } from "./tolerances.js";
import { Verdict } from "./verdict.js";
import { THREE } from "./view.js";
import { tell } from "./words.js";

const KINDS = [[6, "pose"], [5, "approach"], [0, "position"]]; // what an arm of at least so many joints begins with
const HINTS = {
  approach: "5 joints: not every pose is in reach, so the axis about which the tool rolls is pointed, and its turn about that is free.",
  position: "Fewer than 5 joints: the tool's position is met, and its orientation is free.",
};
const FIRST = "Drag an arrow or a ring at the tool; G hides them.";
const DRAGGED = "twistarm dragged"; // whether somebody has, on any page
const PARALLEL = 0.999; // cosine from which a ring is about the axis that an approach points
const LATE = 60; // ms that an answer takes at most where nothing is slow
const LOST = 2000; // ms after which no answer is expected any more: the arm was moved by another hand

export class Target {
  // `page` holds view, panel, state and ask(request).
  constructor(page) {
    this.page = page;
    this.given = null;
    this.tool = null;
    this.asked = null;
    /** @type {any} */
    this.start = null;
    this.driven = false;
    this.waiting = 0; // the picture before which nothing more is sent
    this.newer = false; // whether what is asked was not sent yet
    this.gizmo = new Gizmo(page.view, {
      begin: () => this.begin(),
      move: (pose) => this.move(pose),
      end: () => this.end(),
      cancel: () => this.cancel(),
      snap: () => $("target-snap").checked,
    });
    page.view.handles = this.gizmo;
    this.boxes = new PoseBoxes(page.panel.tool, {
      send: (pose) => this.ask(pose),
      complain: (text, box) => page.panel.complain(text, box),
      settle: (box) => page.panel.settle(box),
    });
    this.verdict = new Verdict();
    this.tolerances = new Tolerances(page, () => this.again());
    this.messages = {
      target: (message) => this.show(message),
      tolerances: (message) => this.tolerances.show(message),
      servo: ({ driven }) => this.drive(driven),
      error: () => this.settle(),
    };
    $("drag-tool").checked = matchMedia("(hover: hover) and (pointer: fine)").matches; // with a mouse
    this.listen();
  }

  listen() {
    $("drag-tool").addEventListener("change", () => this.toggle());
    $("target-axes").addEventListener("change", () => this.arrange());
    $("target-kind").addEventListener("change", () => this.choose());
    $("target-release").addEventListener("click", () => this.page.ask({ type: "release" }));
    addEventListener("keydown", (event) => this.press(event));
  }

  get kind() {
    return $("target-kind").value;
  }

  // G takes hold of the tool, or lets it be.
  press(event) {
    if (event.code === "KeyG" && bare(event) && !$("drag-tool").disabled) $("drag-tool").click();
  }

  toggle() {
    this.arrange();
    this.settle();
  }

  // An arm that is new to the page.
  hello({ arm }) {
    $("target-kind").value = KINDS.filter(([least]) => arm.joints.length >= least)[0][1];
    this.given = null;
    this.tool = null;
    this.asked = null;
    this.newer = false;
    this.begun = this.kind;
    this.verdict.show(null);
    this.arrange();
  }

  offline() {
    this.gizmo.drop();
    this.settle();
  }

  drive(driven) {
    this.driven = driven;
    if (driven) this.settle();
    this.arrange();
  }

  placed(frame) {
    this.tool = poseOf(frame.transforms["/frames/tool"]);
    this.arrange();
  }

  // What the process says: the target of whichever page, whether it is met, and why not.
  show(message) {
    this.given = message.given && { ...message.given, met: message.met };
    const answered = !this.given || (this.asked && same(this.given, this.asked));
    this.verdict.show(message);
    if (answered && !this.gizmo.motion) this.asked = null;
    this.arrange();
  }

  // Nothing more comes of what was asked.
  settle() {
    if (this.gizmo.motion) return;
    this.asked = null;
    this.newer = false;
    this.verdict.busy(false);
    this.arrange();
  }

  // by hand ------------------------------------------------------------------------------------------

  begin() {
    this.start = { theta: this.page.state.frame.theta, given: this.given };
    this.verdict.busy(true);
    keep(DRAGGED, "true");
  }

  // At most one request for each picture, at once where none was sent since the last one.
  move(pose) {
    this.asked = { kind: this.kind, ...pose };
    this.newer = this.waiting !== 0;
    if (!this.newer) this.send();
  }

  next() {
    this.waiting = 0;
    if (this.newer) this.send();
  }

  end() {
    this.verdict.busy(false);
    if (this.newer) this.send();
  }

  // Back to where it was.
  cancel() {
    const { given, theta } = this.start;
    const moved = this.asked !== null;
    this.settle();
    if (!moved) return;
    if (given) {
      const { kind, position, xyzw } = given;
      this.page.ask({ type: "target", kind, position, xyzw });
    } else {
      this.page.ask({ type: "theta", theta });
    }
  }

  // What is to be met: the target given, or the tool as it stands.
  wanted() {
    if (this.given) return { kind: this.given.kind, position: this.given.position, xyzw: this.given.xyzw };
    return this.tool && { kind: this.kind, position: this.tool.position.toArray(), xyzw: this.tool.quaternion.toArray() };
  }

  choose() {
    this.again();
    this.arrange();
  }

  // The target that is given, asked for once more.
  again() {
    if (this.given && !this.driven) this.ask(standing(this.given, this.tool));
  }

  ask(pose) {
    this.asked = { kind: this.kind, ...pose };
    this.send();
  }

  // The handles move with the arm: they wait for the answer, unless it is late.
  send() {
    const { kind, position, quaternion } = this.asked;
    this.newer = false;
    const asked = this.page.ask({ type: "target", kind, position: position.toArray(), xyzw: quaternion.toArray() });
    if (!asked) return this.offline();
    cancelAnimationFrame(this.waiting);
    this.waiting = requestAnimationFrame(() => this.next());
    clearTimeout(this.late);
    clearTimeout(this.lost);
    this.late = setTimeout(() => this.arrange(), LATE);
    this.lost = setTimeout(() => this.settle(), LOST);
  }

  // Everything where it belongs, and only what can be used.
  arrange() {
    for (const id of ["drag-tool", "target-kind", "target-axes", "target-snap"]) $(id).disabled = this.driven;
    $("target-release").hidden = !this.given || this.driven;
    const hints = [kept(DRAGGED) ? "" : FIRST, this.kind === this.begun ? HINTS[this.kind] : ""].filter(Boolean);
    const shown = $("drag-tool").checked && !this.driven ? hints : [];
    tell($("target-hint"), shown[0] ?? "", shown.slice(1));
    this.tolerances.disable(this.driven);
    this.boxes.disable(this.driven, this.kind === "position");
    if (this.tool !== null) this.put();
  }

  put() {
    const pose = standing(this.given, this.tool);
    this.boxes.show(pose);
    const { view } = this.page;
    const before = view.wanted;
    view.wanted = this.asked || this.given ? (this.asked ?? pose).position : null;
    if (before !== null && view.wanted === null) view.settle();
    this.gizmo.place(this.asked ?? (this.given?.met ? this.tool : pose), this.tool, $("target-axes").value);
    const on = $("drag-tool").checked && !this.driven;
    this.gizmo.show(on, this.given?.met ?? null, (handle, direction) => this.allows(handle, direction));
  }

  // A position has no turns, and an approach none about the axis that it points.
  allows({ kind }, direction) {
    if (kind !== "turn" || this.kind === "pose") return true;
    const pointed = new THREE.Vector3(...this.page.state.hello.arm.tool_axis).applyQuaternion(this.gizmo.pose.quaternion);
    return this.kind === "approach" && Math.abs(direction.dot(pointed)) < PARALLEL;
  }
}
