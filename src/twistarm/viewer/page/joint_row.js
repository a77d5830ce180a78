// A joint's row in the panel: name, limits, slider, and the number to type.

import { element } from "./element.js";
import { writeName } from "./names.js";
import { NumberBox } from "./number_box.js";
import { withUnit, span, unitShown } from "./units.js";

const NEAR = 0.05; // of the range between two limits
const LEAST = { rad: Math.PI / 36, m: 0.01 }; // near a limit in any case: 5°, 1 cm
const ROUNDING = 1e-6; // rad, m: the process lets a value lie this far beyond

export class JointRow {
  // `panel` as for a NumberBox; `send(value)` in rad or m.
  constructor(joint, panel, send) {
    this.joint = joint;
    this.send = send;
    this.number = 0;
    this.row = element("div", "joint");
    this.row.setAttribute("role", "group");
    this.row.setAttribute("aria-label", joint.name);
    this.nearLimit = element("span", "near-limit");
    this.ends = element("span", "ends");
    this.slider = this.makeSlider();
    this.box = new NumberBox(joint, panel, (value) => this.move(value));
    this.unit = element("span", "unit");
    this.row.append(this.head(), this.slider, this.box.input, this.unit);
    this.label();
  }

  head() {
    const head = element("div", "head");
    const called = element("span", "called");
    called.append(writeName(element("span", "name"), this.joint.name), element("span", "type", this.joint.type));
    head.append(called, this.nearLimit, this.ends);
    return head;
  }

  makeSlider() {
    const { name, range } = this.joint;
    const slider = element("input");
    Object.assign(slider, { type: "range", min: range[0], max: range[1], step: "any" });
    slider.dataset.joint = name;
    slider.setAttribute("aria-label", name);
    slider.title = this.joint.type;
    slider.addEventListener("input", () => this.move(Number(slider.value)));
    return slider;
  }

  move(value) {
    this.show(value);
    this.send(value);
  }

  label() {
    const { limits, range, unit } = this.joint;
    this.ends.textContent = span(range, unit);
    this.ends.title = limits.every((limit) => limit === null) ? "No limits: the slider's range" : "";
    this.unit.textContent = unitShown(unit);
    this.box.label();
    this.show(this.number);
  }

  show(number) {
    const { unit } = this.joint;
    const [state, side] = limitState(this.joint, number);
    const words = state ? `${withUnit(number, unit)}, ${state} its ${side} limit` : withUnit(number, unit);
    this.number = this.slider.value = number;
    this.slider.setAttribute("aria-valuetext", words);
    this.box.show(number, words);
    this.row.dataset.limit = state;
    this.row.title = state ? words : "";
    this.nearLimit.textContent = state ? `${state === "near" ? "▸" : "▲"} ${state} ${side}` : "";
  }

  disable(disabled) {
    this.slider.disabled = disabled;
    this.box.disable(disabled);
  }
}

// "near", "outside" or "", and of which limit. A joint beside the arm stands at its end as a rule: a closed gripper.
function limitState({ limits, unit, beside }, number) {
  const [lower, upper] = [limits[0] ?? -Infinity, limits[1] ?? Infinity];
  const [left, side] = number - lower < upper - number ? [number - lower, "lower"] : [upper - number, "upper"];
  const range = upper - lower;
  const margin = Math.max(Number.isFinite(range) ? NEAR * range : 0, LEAST[unit]);
  if (left < -ROUNDING) return ["outside", side];
  return left < margin && !beside ? ["near", side] : ["", side];
}
