// The program's own controls: sliders, buttons and lines of text, in a section that is absent without any.

import { $, button, element } from "./element.js";
import { report } from "./words.js";

const FINE = 3; // decimals of a slider from 0 to 1

export class Controls {
  constructor(ask) {
    this.ask = ask;
    this.shape = ""; // of what stands there: names, kinds and ends
    this.rows = [];
    this.held = null; // the slider under somebody's hand: it is not moved from outside
    this.latest = [];
    this.messages = { controls: ({ controls }) => this.show(controls) };
  }

  show(controls) {
    const shape = JSON.stringify(controls.map(({ name, ends, value }) => [name, ends, typeof value]));
    if (shape !== this.shape) this.build(controls);
    this.shape = shape;
    this.latest = controls;
    this.write();
  }

  build(controls) {
    this.held = null;
    this.rows = controls.map((control) => this.row(control));
    $("controls").hidden = controls.length === 0;
    $("controls-list").replaceChildren(...this.rows.flatMap(({ row, wrong }) => [row, wrong]));
  }

  // The element, show(value), and the line for an error of the program.
  row(control) {
    const wrong = element("p", "wrong");
    if (control.ends) return { ...this.slider(control), wrong };
    const { name } = control;
    if (control.value === null) return { row: button("", name, "", () => this.ask({ type: "press", name })), show() {}, wrong };
    const row = element("p", "text");
    const text = element("span");
    row.append(element("b", "", name), " ", text);
    return { row, show: (value) => { text.textContent = value; }, wrong };
  }

  slider({ name, ends: [lower, upper] }) {
    const digits = Math.max(0, FINE - Math.floor(Math.log10(upper - lower)));
    const figure = (value) => String(Number(value.toFixed(Math.min(digits, 20))));
    const row = element("div", "joint");
    const [slider, box] = ["range", "number"].map((type) => Object.assign(element("input", type), { type, min: lower, max: upper, step: "any", ariaLabel: name }));
    const head = element("div", "head");
    head.append(element("span", "called", name), element("span", "ends", `${figure(lower)} … ${figure(upper)}`));
    const send = (value) => {
      this.held = name;
      slider.value = value;
      if (this.ask({ type: "slide", name, value })) box.value = figure(value);
    };
    slider.addEventListener("input", () => send(Number(slider.value)));
    const clip = (value) => Math.max(lower, Math.min(upper, value));
    box.addEventListener("change", () => (box.value === "" ? this.write() : send(clip(Number(box.value)))));
    row.dataset.limit = "";
    row.append(head, slider, box);
    const show = (value) => {
      slider.value = value;
      if (document.activeElement !== box) box.value = figure(value);
    };
    return { row, show };
  }

  write() {
    this.latest.forEach(({ name, value, error }, i) => {
      if (name !== this.held) this.rows[i].show(value);
      report(this.rows[i].wrong, error);
    });
  }

  release() {
    this.held = null;
    this.write();
  }
}
