// One plot against time, drawn as SVG: lines of the joints, their limits, and where the motion is.

import { element } from "./element.js";
import { writeName } from "./names.js";
import { decimals, ticks } from "./plot_scale.js";
import { signed } from "./units.js";

const EDGE = { left: 46, right: 10, top: 20, bottom: 17 }; // px around the lines
const DASHES = ["", "7 3", "2 2", "9 3 2 3"]; // lines are told apart without their colours too
const COLOURS = 8; // --plot-0 …
const LETTER = 6.6; // px of a title's letter

export class Plot {
  // `act` holds seek(time) and point(plot, event, time), time null once nothing is pointed at.
  constructor(rate, act) {
    this.rate = rate;
    this.act = act;
    this.span = 0;
    this.time = 0;
    this.svg = svg("svg", { class: "plot", role: "img" });
    this.svg.addEventListener("pointerdown", (event) => this.press(event));
    this.svg.addEventListener("pointermove", (event) => this.move(event));
    this.svg.addEventListener("pointerleave", () => act.point(this, null, null));
  }

  // `times` [s] of all values, and what plot_scale.js made of them.
  draw(times, scale) {
    this.times = times;
    this.scale = scale;
    this.span = times.at(-1);
    this.width = this.svg.clientWidth;
    this.height = this.svg.clientHeight;
    if (this.width < EDGE.left + EDGE.right + 10 || this.height < EDGE.top + EDGE.bottom + 10) return;
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
    this.cursor = this.upright("cursor");
    this.pointer = this.upright("pointer");
    const title = svg("text", { x: 2, y: 13, class: "title" }, fitting(scale.title, this.width));
    this.svg.replaceChildren(title, ...this.clock(), ...scale.marks.flatMap((mark) => this.mark(mark)),
      ...scale.lines.map((line) => this.line(line)), this.pointer, this.cursor);
    this.follow(this.time);
    this.aim(null);
  }

  follow(time) {
    this.time = time;
    if (this.cursor) place(this.cursor, this.x(time));
  }

  // A moment that somebody points at; null: nobody.
  aim(time) {
    if (!this.pointer) return;
    this.pointer.setAttribute("visibility", time === null ? "hidden" : "visible");
    if (time !== null) place(this.pointer, this.x(time));
  }

  press(event) {
    if (event.button !== 0) return;
    this.svg.setPointerCapture(event.pointerId);
    this.act.seek(this.at(event));
  }

  move(event) {
    if (this.svg.hasPointerCapture(event.pointerId)) this.act.seek(this.at(event));
    this.act.point(this, event, this.at(event));
  }

  at({ clientX }) {
    const along = (clientX - this.svg.getBoundingClientRect().left - EDGE.left) / this.inner();
    return this.span * Math.max(0, Math.min(1, along));
  }

  inner() { return Math.max(1, this.width - EDGE.left - EDGE.right); }
  x(time) { return EDGE.left + (this.span > 0 ? time / this.span : 0) * this.inner(); }

  y(value) {
    const { low, high } = this.scale;
    return EDGE.top + ((high - value) / (high - low)) * (this.height - EDGE.top - EDGE.bottom);
  }

  upright(kind) {
    return svg("line", { class: kind, y1: EDGE.top, y2: this.height - EDGE.bottom });
  }

  clock() {
    const digits = decimals(this.span);
    const times = ticks(0, this.span).map((time) => ({ time, text: `${signed(time, digits)} s` }));
    // Every one, or every so many that they do not run into one another.
    const spacing = times.length > 1 ? this.x(times[1].time) - this.x(times[0].time) : 1;
    const every = Math.ceil((LETTER * (times[times.length - 1].text.length + 1)) / spacing);
    return times.filter((_, i) => i % every === 0).map(({ time, text }) =>
      svg("text", { x: this.x(time), y: this.height - 4, class: "tick", "text-anchor": "middle" }, text));
  }

  mark({ at, label, limit }) {
    const y = this.y(at);
    return [
      svg("line", { class: limit ? "limit" : "rule", x1: EDGE.left, x2: this.width - EDGE.right, y1: y, y2: y }),
      svg("text", { x: EDGE.left - 5, y: y + 4, class: limit ? "tick limit" : "tick", "text-anchor": "end" }, label),
    ];
  }

  line({ joint, values }) {
    const points = values.map((value, i) => `${this.x(this.times[i]).toFixed(2)},${this.y(value).toFixed(2)}`);
    return svg("polyline", { ...look(joint), class: "line", points: points.join(" ") });
  }
}

const fitting = (title, width) => LETTER * title.length < width ? title : title.split(/[,·]/)[0].trim();

export function swatch(joint) {
  const box = svg("svg", { class: "swatch", viewBox: "0 0 22 6", width: 22, height: 6, "aria-hidden": "true" });
  box.append(svg("line", { ...look(joint), class: "line", x1: 0, x2: 22, y1: 3, y2: 3 }));
  return box;
}

// Rows of a name and a value beside a swatch, for what somebody points at.
export function reading(rows) {
  return rows.flatMap(({ joint, name, value }) => [swatch(joint), writeName(element("span", "name"), name), element("span", "", value)]);
}

const look = (joint) => ({ style: `stroke: var(--plot-${joint % COLOURS})`, "stroke-dasharray": DASHES[joint % DASHES.length] });

function place(line, x) {
  line.setAttribute("x1", x);
  line.setAttribute("x2", x);
}

function svg(tag, attributes, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  return made;
}
