// A joint's number to type: Enter or leaving the box sends it, Escape brings back what stands, arrow keys step.

import { element } from "./element.js";
import { figure, step, stride, typed, unitShown } from "./units.js";

const STRIDES = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 };
const REMEDIES = {
  rad: "is not an angle. Write 45 deg, 0.8 rad or pi/4.",
  m: "is not a length. Write 0.5, 50 cm or 500 mm.",
  1: "is not a number. Write 0.5.",
};
const NAMES = { "°": "degrees", rad: "radians", m: "metres", 1: "" };

export class NumberBox {
  // `panel` holds complain(text, box), and settle(box) once there is nothing to complain of; `send(value)` in rad or m.
  constructor(joint, panel, send) {
    this.joint = joint;
    this.panel = panel;
    this.accept = send;
    this.number = 0;
    this.text = "";
    this.held = false; // under somebody's hand: not written from outside
    this.edited = false; // and not sent
    this.input = element("input", "number");
    Object.assign(this.input, { type: "text", inputMode: "decimal", autocomplete: "off", maxLength: 60 });
    this.input.setAttribute("role", "spinbutton");
    this.listen();
    this.label();
  }

  listen() {
    this.input.addEventListener("focus", () => {
      this.held = true;
      this.input.select();
    });
    this.input.addEventListener("pointerdown", () => { this.held = true; });
    this.input.addEventListener("input", () => {
      this.held = this.edited = true;
      this.mark(typed(this.input.value, this.joint.unit) === null);
    });
    this.input.addEventListener("blur", () => this.leave());
    this.input.addEventListener("keydown", (event) => this.press(event));
  }

  label() {
    const { name, limits, unit } = this.joint;
    const [lower, upper] = limits.map((limit) => (limit === null ? null : figure(limit, unit, 3).replace("−", "-")));
    this.unit = NAMES[unitShown(unit)];
    this.input.setAttribute("aria-label", [name, this.unit].filter(Boolean).join(", "));
    if (lower !== null) this.input.setAttribute("aria-valuemin", lower);
    if (upper !== null) this.input.setAttribute("aria-valuemax", upper);
    this.input.title = `${this.unit && `In ${this.unit}. `}Enter sends, Escape restores, ↑ ↓ step by ${stride(unit)}, with Shift ten times that.`;
  }

  // `words`: the number and what is to be said of it.
  show(number, words) {
    const text = figure(number, this.joint.unit);
    const moved = text !== this.text;
    this.number = number;
    this.text = text;
    this.input.setAttribute("aria-valuenow", text.replace("−", "-"));
    this.input.setAttribute("aria-valuetext", words);
    // What is no number stays in the box it was left in, until there is something new to show.
    if (!this.held && (moved || !this.edited)) this.write();
  }

  write() {
    this.edited = false;
    this.mark(false);
    if (this.input.value !== this.text) this.input.value = this.text;
    if (document.activeElement === this.input) this.input.select(); // the next number replaces this one
  }

  mark(nonsense) {
    if (nonsense) return this.input.setAttribute("aria-invalid", "true");
    this.input.removeAttribute("aria-invalid");
    this.panel.settle(this);
  }

  press(event) {
    const { key, shiftKey } = event;
    if (key === "Enter") this.send();
    else if (key === "Escape") this.restore();
    else if (key in STRIDES) this.step(STRIDES[key] * (shiftKey ? 10 : 1));
    else return;
    event.preventDefault();
    event.stopPropagation(); // Escape here means nothing else on the page
  }

  leave() {
    if (document.activeElement === this.input) return; // the window lost the focus, not the box
    this.held = false;
    if (this.edited) this.send();
    else this.write();
  }

  send() {
    if (!this.edited) return;
    const value = typed(this.input.value, this.joint.unit);
    if (value === null) {
      this.panel.complain(`${this.joint.name}: “${this.input.value}” ${this.remedy()}`, this);
    } else {
      this.held = this.edited = false;
      this.accept(value);
    }
  }

  remedy() {
    const pointed = this.input.value.replace(",", ".");
    const comma = pointed !== this.input.value && typed(pointed, this.joint.unit) !== null;
    return comma ? `has a comma. Write a point: ${pointed.trim()}` : REMEDIES[this.joint.unit];
  }

  restore() {
    this.held = false;
    this.write();
  }

  // The words about what is wrong here are gone: it goes too, unless somebody is at it.
  forgive() {
    if (document.activeElement !== this.input) this.restore();
  }

  step(count) {
    const { limits, unit } = this.joint;
    const [lower, upper] = [limits[0] ?? -Infinity, limits[1] ?? Infinity];
    const from = (this.edited ? typed(this.input.value, unit) : null) ?? this.number;
    this.held = this.edited = false;
    this.accept(Math.max(lower, Math.min(upper, from + count * step(unit))));
  }

  // Not for hands, or again; what was typed and not sent is given up.
  disable(disabled) {
    if (this.input.disabled === disabled) return;
    this.input.disabled = disabled;
    this.restore();
  }
}
