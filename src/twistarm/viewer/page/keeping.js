// A pose as lines for arm.toml: shown, copied, or written into the arm's own file by a button.

import { copyText } from "./copying.js";
import { $ } from "./element.js";

const ON_SHOW = "on show";

export class Keeping {
  // `page` holds state and ask(request).
  constructor(page) {
    this.page = page;
    this.file = null;
    this.names = []; // of the poses in the file
    this.poses = [];
    this.messages = {
      program: ({ poses }) => this.list(poses),
      keeping: (message) => this.offer(message),
    };
    $("keep-which").addEventListener("change", () => this.choose());
    $("keep-name").addEventListener("input", () => this.show());
    $("keep-copy").addEventListener("click", () => copyText(this.text, "pose", "in rad and m"));
    $("keep-save").addEventListener("click", () => page.ask({ type: "keep_pose", name: this.name, theta: this.theta, replace: this.names.includes(this.name) }));
  }

  placed() {
    if ($("keep").open) this.show();
  }

  list(poses) {
    this.poses = poses;
    const before = $("keep-which").value;
    $("keep-which").replaceChildren(new Option("the pose on show", ON_SHOW), ...poses.map(({ id, name }) => new Option(name, id)));
    $("keep-which").value = poses.some(({ id }) => String(id) === before) ? before : ON_SHOW;
    this.show();
  }

  offer({ file, names }) {
    Object.assign(this, { file, names });
    this.show();
  }

  choose() {
    $("keep-name").value = this.chosen?.name ?? "";
    this.show();
  }

  get chosen() {
    return this.poses.find(({ id }) => String(id) === $("keep-which").value);
  }

  get name() {
    return $("keep-name").value.trim() || this.chosen?.name || "kept";
  }

  get theta() {
    return this.chosen?.theta ?? this.page.state.frame.theta;
  }

  get text() {
    const { joints } = this.page.state.hello.arm;
    return [`[poses.${key(this.name)}]`, ...this.theta.map((value, i) => `${key(joints[i].name)} = ${value}`), ""].join("\n");
  }

  show() {
    if (!this.page.state.frame) return;
    $("keep-text").textContent = this.text;
    $("keep-save").hidden = this.file === null;
    const file = this.file?.split("/").at(-1);
    $("keep-save").textContent = this.names.includes(this.name) ? `Replace ${this.name} in ${file}` : `Save in ${file}`;
    $("keep-save").title = `Write the pose ${this.name} into ${this.file}; the rest of the file stays`;
  }
}

// A key of TOML: bare where that is allowed.
function key(name) {
  return /^[\w-]+$/.test(name) ? name : JSON.stringify(name).replaceAll("\u007f", "\\u007f");
}
