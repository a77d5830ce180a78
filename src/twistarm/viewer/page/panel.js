// The panel beside the view: joints, named poses, the tool, switches.

import { $, button, element } from "./element.js";
import { JointRow } from "./joint_row.js";
import { cut, writeName } from "./names.js";
import { ToolNumbers } from "./tool_numbers.js";
import { inRadians, setRadians } from "./units.js";
import { report } from "./words.js";

const LONGEST = 28; // letters of a frame's name

export class Panel {
  // `act` holds what the page does about the panel: joint(name, value), pose(name), random(), copy(), visible(what, on),
  // fit().
  constructor(act) {
    this.act = act;
    this.rows = new Map();
    this.names = [];
    this.movers = []; // buttons that move the arm
    this.frame = null;
    this.tool = new ToolNumbers();
    this.wrong = null; // the box that the error is about
    this.held = null; // the joint under somebody's hand: its row is not moved from outside
    for (const what of ["screws", "frames", "path"]) {
      $(`show-${what}`).addEventListener("change", (event) => act.visible(what, event.target.checked));
    }
    $("radians").checked = inRadians();
    $("radians").addEventListener("change", (event) => this.switchUnits(event.target.checked));
    $("fit").addEventListener("click", () => act.fit());
  }

  // `arm` as the process describes it, `notes` on what could not be drawn.
  build(arm, notes) {
    document.title = `${arm.name} · twistarm`;
    writeName($("name"), arm.name);
    const [base, tip] = [arm.base, arm.tip].map((name) => cut(name, LONGEST));
    $("base-and-tip").textContent = `${arm.joints.length} joint${arm.joints.length === 1 ? "" : "s"}, ${base} → ${tip}`;
    $("base-and-tip").title = `${arm.base} → ${arm.tip}`;
    this.buildButtons(Object.keys(arm.poses));
    for (const row of this.rows.values()) row.box.restore(); // what is typed is not for the arm that comes
    this.rows.clear();
    const rows = arm.joints.map((joint) => this.row(joint));
    if (arm.others.length) rows.push(element("h2", "", "Other joints"));
    rows.push(...arm.others.map((joint) => this.row({ ...joint, beside: true })));
    $("joints").replaceChildren(...rows);
    this.names = arm.joints.map((joint) => joint.name);
    report($("notes"), notes[0] ?? "", notes.slice(1));
    for (const item of $("legend").children) item.hidden = !arm.screws.includes(item.className);
  }

  buildButtons(poses) {
    this.movers = poses.map((name) => named(name, `Go to the pose ${name}`, () => this.act.pose(name)));
    $("poses").replaceChildren(...this.movers);
    const random = named("random", "A random configuration inside the limits", () => this.act.random());
    this.movers.push(random);
    const copy = named("copy theta", "The arm's joint values as a Python list, in rad and m", () => this.act.copy());
    const extras = element("span", "apart");
    extras.append(random, copy);
    $("poses").append(extras);
  }

  row(joint) {
    const row = new JointRow(joint, this, (value) => {
      this.held = joint.name;
      this.act.joint(joint.name, value);
    });
    this.rows.set(joint.name, row);
    return row.row;
  }

  switchUnits(radians) {
    setRadians(radians);
    for (const row of this.rows.values()) row.label();
    if (this.frame) this.show(this.frame);
  }

  remembered() { return { radians: inRadians(), orientation: this.tool.way }; }

  recall({ radians, orientation }) {
    this.tool.choose(orientation);
    $("radians").checked = radians;
    this.switchUnits(radians);
  }

  show(frame) {
    this.frame = frame;
    this.names.forEach((name, i) => this.showJoint(name, frame.theta[i]));
    for (const [name, value] of Object.entries(frame.others)) this.showJoint(name, value);
    this.tool.show(frame);
  }

  showJoint(name, number) {
    if (this.held !== name) this.rows.get(name).show(number);
  }

  mark(name) {
    for (const [joint, { row }] of this.rows) row.setAttribute("aria-current", String(joint === name));
    this.rows.get(name)?.row.scrollIntoView({ block: "nearest" });
  }

  release() { this.held = null; }

  // While a servo drives, the arm's joints are not for hands; those beside it still are.
  showDriven(driven) {
    for (const name of this.names) this.rows.get(name).disable(driven);
    for (const mover of this.movers) mover.disabled = driven;
    for (const id of ["poses", "joints"]) $(id).title = driven ? "A servo drives the arm" : "";
    $("panel").classList.toggle("driven", driven);
  }

  showVisible(layers) {
    for (const what of ["screws", "frames", "path"]) $(`show-${what}`).checked = layers[what];
    $("legend").hidden = !layers.screws;
  }

  showPath(there) { $("show-path").parentElement.hidden = !there; }

  showStatus(state) {
    $("status").textContent = state;
    $("status").dataset.state = state;
  }

  // What is wrong in a box, and the words about it, go together.
  complain(text, box) {
    if (this.wrong === box) this.wrong = null; // it is still wrong
    this.showError(text);
    this.wrong = box;
  }

  settle(box) {
    if (this.wrong === box) this.showError("");
  }

  showError(message) {
    const { wrong } = this;
    this.wrong = null;
    report($("error"), message);
    $("error").hidden = message === "";
    wrong?.forgive();
  }
}

const named = (name, title, press) => Object.assign(writeName(button("", "", title, press), name, title), { ariaLabel: name });
