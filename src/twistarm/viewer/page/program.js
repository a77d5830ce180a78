// Recorded poses: a list to edit, save and load, and the motion planned through it.

import { $, $$ } from "./element.js";
import { eases } from "./glide.js";
import { PoseList } from "./pose_list.js";
import { read, written } from "./pose_file.js";
import { fileName, save } from "./saving.js";

const OUTDATED = "Another kind of motion was planned: plan again.";

export class Program {
  // `page` holds panel, state and ask(request).
  constructor(page) {
    this.page = page;
    this.poses = [];
    this.planned = false;
    this.kind = null;
    this.stop = false;
    this.note = "";
    this.duration = null;
    this.trying = this.failed = false; // the motion that was asked for last: it may still come, and it did not
    this.driven = false;
    this.list = new PoseList($("pose-list"), {
      go: (id) => page.ask({ type: "go", id, ease: eases() }),
      rename: (id, name) => page.ask({ type: "rename", id, name }),
      reorder: (id, place) => page.ask({ type: "reorder", id, place }),
      remove: (id) => page.ask({ type: "delete", id }),
    });
    this.messages = {
      program: (message) => this.show(message),
      player: (message) => this.load(message),
      servo: ({ driven }) => this.disable(driven),
      error: () => this.fail(),
    };
    this.listen();
  }

  listen() {
    $("record").addEventListener("click", () => this.record());
    $("pose-name").addEventListener("keydown", ({ key }) => key === "Enter" && this.record());
    $("plan").addEventListener("click", () => this.plan());
    for (const id of ["plan-kind", "plan-stop"]) $(id).addEventListener("change", () => this.choose());
    $("save-poses").addEventListener("click", () => this.save());
    $("load-poses").addEventListener("click", () => $("poses-file").click());
    $("poses-file").addEventListener("change", () => this.open());
  }

  show({ poses, planned, kind, stop, note }) {
    const another = kind !== null && (kind !== this.kind || stop !== this.stop);
    this.poses = poses;
    this.planned = planned;
    this.kind = kind;
    this.stop = stop;
    this.note = note;
    this.trying = false;
    this.failed = false;
    if (another) this.follow();
    this.list.show(poses);
    if (this.page.state.frame) this.list.mark(this.page.state.frame.theta);
    $("pose-name").placeholder = `pose ${poses.length + 1}`;
    $("pose-hint").hidden = poses.length > 0;
    $("save-poses").disabled = poses.length === 0;
    this.tell();
  }

  // The boxes say what was planned, by whichever page.
  follow() {
    $("plan-kind").value = this.kind;
    $("plan-stop").checked = this.stop;
    this.choose();
  }

  choose() {
    $("plan-stop").disabled = $("plan-kind").value === "trapezoid"; // which stops anyway
    this.tell();
  }

  // Whether the motion is the one that the boxes ask for.
  get asAsked() {
    const kind = $("plan-kind").value;
    return kind === this.kind && (kind === "trapezoid" || $("plan-stop").checked === this.stop);
  }

  placed({ theta }) {
    this.list.mark(theta);
  }

  load({ duration }) {
    this.duration = duration;
    this.failed = false;
    for (const link of $$("#program a[download]")) {
      if (duration === null) link.removeAttribute("href");
      else link.href = link.dataset.file;
    }
    this.tell();
  }

  disable(driven) {
    this.driven = driven;
    this.list.disable(driven);
    this.tell();
  }

  // What stays loaded is not what was asked for.
  fail() {
    this.failed = this.failed || this.trying;
    this.trying = false;
    this.tell();
  }

  tell() {
    const word = this.failed ? "Not planned anew; still loaded" : "Planned";
    const done = this.planned && this.duration !== null ? `${word}: ${this.duration.toFixed(2)} s` : "";
    const outdated = this.planned && !this.asAsked;
    $("program-note").textContent = outdated ? OUTDATED : [done, this.note].filter(Boolean).join("; ");
    $("program-note").classList.toggle("stale", outdated || !this.planned);
    $("plan").disabled = this.driven || this.poses.length < 2;
    $("plan").title = this.poses.length < 2 ? "Record two poses first" : "Through the poses in their order, within the limits";
  }

  record() {
    if (this.page.ask({ type: "record", name: $("pose-name").value })) $("pose-name").value = "";
  }

  plan() {
    this.trying = this.page.ask({ type: "plan", kind: $("plan-kind").value, stop: $("plan-stop").checked });
  }

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
