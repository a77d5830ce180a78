// Recorded poses: a list to edit, save and load, and the motion planned through it.

import { $, $$ } from "./element.js";
import { eases } from "./glide.js";
import { PoseList } from "./pose_list.js";
import { read, written } from "./pose_file.js";
import { fileName, save } from "./saving.js";
import { typed } from "./units.js";
import { report } from "./words.js";

const OUTDATED = "The motion was planned with other settings: plan again.";
const SETTINGS = ["plan-kind", "plan-corner", "plan-linear-speed", "plan-torques", "plan-payload"];

export class Program {
  // `page` holds panel, state and ask(request).
  constructor(page) {
    this.page = page;
    this.poses = [];
    this.planned = false;
    this.loaded = null; // kind, stop, corner [m], linear_speed [m/s], torques and payload [kg] of the motion that is loaded; null: of no list
    this.note = "";
    this.duration = null;
    this.trying = this.failed = false; // the motion that was asked for last: it may still come, and it did not
    this.driven = false;
    this.list = new PoseList($("pose-list"), {
      go: (id) => page.ask({ type: "go", id, ease: eases() }),
      rename: (id, name) => page.ask({ type: "rename", id, name }),
      moveBy: (id, by) => page.ask({ type: "move", id, by }),
      reorder: (id, place) => page.ask({ type: "reorder", id, place }),
      remove: (id) => page.ask({ type: "delete", id }),
    });
    this.messages = {
      program: (message) => this.show(message),
      player: (message) => this.load(message),
      colliding: ({ poses }) => this.list.collide(poses),
      servo: ({ driven }) => this.disable(driven),
      error: () => this.fail(),
    };
    this.listen();
  }

  listen() {
    $("record").addEventListener("click", () => this.record());
    $("pose-name").addEventListener("keydown", ({ key }) => key === "Enter" && this.record());
    $("plan").addEventListener("click", () => this.plan());
    for (const id of SETTINGS) $(id).addEventListener("change", () => this.report());
    $("save-poses").addEventListener("click", () => this.save());
    $("load-poses").addEventListener("click", () => $("poses-file").click());
    $("poses-file").addEventListener("change", () => this.open());
  }

  show({ poses, planned, kind, stop, corner, linear_speed, torques, payload, note }) {
    const before = this.loaded;
    this.poses = poses;
    this.planned = planned;
    this.loaded = kind === null ? null : { kind, stop, corner, linear_speed, torques, payload };
    this.note = note;
    this.trying = false;
    this.failed = false;
    if (this.loaded && !(before && same(before, this.loaded))) this.follow(this.loaded);
    this.list.show(poses);
    if (this.page.state.frame) this.list.mark(this.page.state.frame.theta);
    $("pose-name").placeholder = `pose ${poses.length + 1}`;
    $("pose-hint").hidden = poses.length > 0;
    $("save-poses").disabled = poses.length === 0;
    this.report();
  }

  // The boxes say what was planned, by whichever page.
  follow(settings) {
    const { kind, stop, corner, linear_speed, torques, payload } = settings;
    $("plan-kind").value = kind;
    $("plan-corner").value = stop ? 0 : corner;
    $("plan-linear-speed").value = linear_speed || "";
    $("plan-torques").checked = torques;
    $("plan-payload").value = payload || "";
    this.report();
  }

  get settings() {
    const [corner, linear_speed] = ["plan-corner", "plan-linear-speed"].map((id) => typed($(id).value.replace(/\/s\s*$/, "") || "0", "m"));
    const torques = $("plan-torques").checked;
    const payload = torques ? typed($("plan-payload").value.replace(/kg\s*$/, "") || "0", "1") : 0;
    return { kind: $("plan-kind").value, stop: corner === 0, corner, linear_speed, torques, payload };
  }

  update({ theta }) { this.list.mark(theta); }

  load({ duration }) {
    this.duration = duration;
    this.failed = false;
    for (const link of $$("#program a[download]")) {
      link.ariaDisabled = String(duration === null);
      if (duration === null) link.removeAttribute("href");
      else link.href = link.dataset.file;
    }
    this.report();
  }

  disable(driven) {
    this.driven = driven;
    this.list.disable(driven);
    this.report();
  }

  // What stays loaded is not what was asked for.
  fail() {
    this.failed = this.failed || this.trying;
    this.trying = false;
    this.report();
  }

  report() {
    const word = this.failed ? "Planning failed; still loaded" : "Planned";
    const done = this.planned && this.duration !== null ? `${word}: ${this.duration.toFixed(2)} s` : "";
    const outdated = this.planned && !same(this.loaded, this.settings);
    if (outdated) report($("program-note"), OUTDATED);
    else report($("program-note"), [done && `${done}.`, this.note].filter(Boolean).join(" "));
    $("program-note").classList.toggle("stale", outdated || !this.planned);
    $("plan-payload").disabled = !$("plan-torques").checked;
    const few = this.poses.length < 2;
    $("plan").disabled = this.driven || few;
    $("plan").title = few ? "Record two poses first" : "Through the poses in their order, within the limits";
  }

  record() {
    if (this.page.ask({ type: "record", name: $("pose-name").value })) $("pose-name").value = "";
  }

  plan() { this.trying = this.page.ask({ type: "plan", ...this.settings }); }

  save() {
    const { name, joints } = this.page.state.hello.arm;
    const text = written(joints.map((joint) => joint.name), this.poses);
    save(new Blob([text], { type: "application/json" }), fileName(name, "_poses.json"));
  }

  async open() {
    const [file] = $("poses-file").files;
    $("poses-file").value = ""; // the same file may be chosen again
    if (!file) return;
    try {
      this.page.ask({ type: "poses", ...(await read(file)) });
    } catch (error) {
      this.page.panel.showError(error.message);
    }
  }
}

// Whether both ask for the same motion: one that stops at each pose rounds no corners.
function same(first, second) {
  const corners = first.stop || first.corner === second.corner;
  return corners && ["kind", "stop", "linear_speed", "torques", "payload"].every((name) => first[name] === second[name]);
}
