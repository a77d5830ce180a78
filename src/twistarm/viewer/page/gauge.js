// Two bars: how near the driven arm is to a singularity, and to a position limit. They fill with danger.

import { element } from "./element.js";
import { writeName } from "./names.js";
import { shown } from "./units.js";

const FAR = 5; // an empty bar, in what counts as near
const AT = 0.01; // of that: at the limit

export class Gauge {
  constructor(root) {
    this.singularity = new Bar(root, "Singularity", "Nearness to a singularity");
    this.limit = new Bar(root, "Limit", "Nearness to a limit");
    this.message = null;
  }

  // As the process measured it; null where no servo drives.
  show(message) {
    this.message = message;
    this.showSingularity(message);
    this.showLimit(message);
  }

  refresh() {
    if (this.message) this.show(this.message);
  }

  showSingularity({ sigma, below, lacks }) {
    if (sigma === null) return this.singularity.clear("");
    const near = sigma < below;
    const words = near ? `near: slowed ${lacks ?? ""}`.trim() : "far";
    const spoken = near && lacks ? `near: slowed, the arm hardly moves ${lacks} of the base` : words;
    this.singularity.show(sigma / below, near ? "near" : "", { figure: `σ ${sigma.toFixed(3)}`, words, spoken });
  }

  showLimit({ joint, unit, room, near, end }) {
    if (joint === null) return this.limit.clear(this.message.sigma === null ? "" : "no limits");
    const share = room / near;
    const standing = share < AT ? "at" : share < 1 ? "near" : "";
    const figure = standing === "at" ? `at its ${end}` : `${shown(Math.max(room, 0), unit)} to its ${end}`;
    this.limit.show(share, standing, { figure, words: joint, spoken: `${joint}, ${figure} limit` });
  }
}

class Bar {
  constructor(root, name, label) {
    this.row = element("div", "gauge");
    this.figure = element("span", "figure");
    this.words = element("span", "words");
    this.meter = element("div", "meter");
    this.fill = element("span");
    this.meter.append(this.fill);
    for (const [key, value] of Object.entries({ role: "meter", "aria-label": label, "aria-valuemin": 0, "aria-valuemax": 1 })) {
      this.meter.setAttribute(key, value);
    }
    this.row.append(element("span", "name", name), this.words, this.figure, this.meter);
    root.append(this.row);
    this.clear("");
  }

  // `share` 1: what lies below is near. `spoken`: what `words` and `figure` say, in full.
  show(share, standing, { figure, words, spoken }) {
    const danger = 1 - Math.min(Math.max(share, 0), FAR) / FAR;
    this.row.dataset.standing = standing;
    this.fill.style.width = `${100 * danger}%`;
    this.write(figure, words, spoken);
    this.meter.setAttribute("aria-valuenow", danger.toFixed(2));
  }

  clear(words) {
    this.row.dataset.standing = "";
    this.fill.style.width = "0";
    this.write("", words, words || "no servo drives");
    this.meter.setAttribute("aria-valuenow", "0");
  }

  write(figure, words, spoken) {
    this.figure.textContent = figure;
    if (this.words.textContent !== words) writeName(this.words, words, null);
    this.row.title = spoken;
    this.meter.setAttribute("aria-valuetext", spoken);
  }
}
