// A pose as lines for arm.toml, to copy.

import { copyText } from "./copying.js";
import { $ } from "./element.js";

const ON_SHOW = "on show";

export class Keeping {
  // `page` holds state and ask(request).
  constructor(page) {
    this.page = page;
    this.poses = [];
    this.messages = { program: ({ poses }) => this.list(poses) };
    $("keep-which").addEventListener("change", () => this.choose());
    $("keep-name").addEventListener("input", () => this.show());
    $("keep-copy").addEventListener("click", () => copyText(this.text, "pose", "in rad and m"));
  }

  update() {
    if ($("keep").open) this.show();
  }

  list(poses) {
    this.poses = poses;
    const before = $("keep-which").value;
    $("keep-which").replaceChildren(new Option("the pose on show", ON_SHOW), ...poses.map(({ id, name }) => new Option(name, id)));
    $("keep-which").value = poses.some(({ id }) => String(id) === before) ? before : ON_SHOW;
    this.show();
  }

  choose() {
    $("keep-name").value = this.chosen?.name ?? "";
    this.show();
  }

  get chosen() {
    return this.poses.find(({ id }) => String(id) === $("keep-which").value);
  }

  get name() { return $("keep-name").value.trim() || this.chosen?.name || "kept"; }
  get theta() { return this.chosen?.theta ?? this.page.state.frame.theta; }

  get text() {
    const { joints } = this.page.state.hello.arm;
    return [`[poses.${key(this.name)}]`, ...this.theta.map((value, i) => `${key(joints[i].name)} = ${value}`), ""].join("\n");
  }

  show() {
    if (this.page.state.frame) $("keep-text").textContent = this.text;
  }
}

const key = (name) => /^[\w-]+$/.test(name) ? name : JSON.stringify(name).replaceAll("\u007f", "\\u007f");
