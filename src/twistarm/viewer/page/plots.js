// Position, velocity and acceleration of the trajectory that is loaded, against the limits, and the tool's speed, under
// the view.

import { $, button, element } from "./element.js";
import { between } from "./motion.js";
import { writeName } from "./names.js";
import { Plot, reading, swatch } from "./plot.js";
import { RATES, scaled, share, toolScaled, worded } from "./plot_scale.js";
import { keep, kept } from "./storage.js";
import { figure, unitShown } from "./units.js";

const TOOL = "tool"; // the plot that shows no joint
const KEPT = "twistarm plots";
const NARROW = "(max-width: 720px)"; // there the plots wait to be asked for

export class Plots {
  // `seek(time)` asks for a moment of the motion.
  constructor(seek) {
    this.messages = { plots: (message) => this.show(message) };
    this.data = null;
    this.chosen = null; // a joint's place; null: all
    const act = { seek, point: (plot, event, time) => this.point(plot, event, time) };
    this.plots = [...RATES, TOOL].map((rate) => new Plot(rate, act));
    this.tip = element("div", "tip");
    this.tip.hidden = true;
    $("plots-figures").append(...this.plots.map(({ svg }) => svg), this.tip);
    new ResizeObserver(() => this.draw()).observe($("plots-figures"));
    $("show-plots").checked = (kept(KEPT) ?? String(!matchMedia(NARROW).matches)) === "true";
    $("show-plots").addEventListener("change", () => {
      keep(KEPT, String($("show-plots").checked));
      this.reveal();
    });
    $("radians").addEventListener("change", () => this.draw());
  }

  show(message) {
    const same = message.joints.map(({ name }) => name).join() === this.data?.joints.map(({ name }) => name).join();
    if (!same) this.chosen = null;
    this.data = message;
    this.point(null, null, null);
    this.label();
    this.reveal();
  }

  reveal() {
    const there = this.data !== null && this.data.times.length > 0;
    $("plots").hidden = !there || !$("show-plots").checked;
    $("show-plots").parentElement.hidden = !there;
    this.draw();
  }

  label() {
    const all = chip("All", "Every joint, as a share of its limits", () => this.choose(null));
    const names = shortened(this.data.joints.map(({ name }) => name));
    const joints = this.data.joints.map((joint, i) => {
      const made = chip(names[i], `${joint.name} alone, in its unit. At most ${peaks(joint)}`, () => this.choose(i));
      made.prepend(swatch(i));
      return made;
    });
    $("plots-joints").replaceChildren(all, ...joints);
    this.mark();
  }

  remembered() {
    return { shown: $("show-plots").checked, joint: this.data?.joints[this.chosen]?.name ?? null };
  }

  recall({ shown, joint }) {
    const place = this.data.joints.findIndex(({ name }) => name === joint);
    $("show-plots").checked = shown;
    this.choose(place < 0 ? null : place);
    this.reveal();
  }

  choose(joint) {
    this.chosen = joint;
    this.mark();
    this.draw();
  }

  mark() {
    [...$("plots-joints").children].forEach((made, i) => made.setAttribute("aria-pressed", i - 1 === (this.chosen ?? -1)));
  }

  draw() {
    if ($("plots").hidden) return;
    for (const plot of this.plots) {
      const tool = plot.rate === TOOL;
      plot.draw(this.data.times, tool ? toolScaled(this.data) : scaled(this.data, plot.rate, this.chosen));
      const most = tool ? this.speeds((values) => Math.max(...values)) : this.drawn().map((i) => this.words(i, plot.rate)).join("; ");
      plot.svg.setAttribute("aria-label", `${plot.scale.title}: ${most}`);
    }
  }

  speeds(of) {
    const { linear, angular } = this.data.tool;
    return `${figure(of(linear), "m")} m/s, turning ${figure(of(angular), "rad")} ${unitShown("rad")}/s`;
  }

  words(i, rate) {
    const joint = this.data.joints[i];
    return `${joint.name} at most ${worded(joint.peak[rate], joint, rate)}`;
  }

  drawn() {
    return this.chosen === null ? this.data.joints.map((_, i) => i) : [this.chosen];
  }

  update({ time }) {
    if (time === this.plots[0].time) return; // the arm moves, and not along the motion
    for (const plot of this.plots) plot.follow(time);
  }

  point(plot, event, time) {
    for (const other of this.plots) other.aim(time);
    this.tip.hidden = time === null;
    if (time === null) return;
    this.tip.replaceChildren(element("strong", "", `${time.toFixed(2)} s`), ...this.rowsAt(plot.rate, time));
    const box = $("plots-figures").getBoundingClientRect();
    const left = event.clientX - box.left;
    const beside = left + this.tip.offsetWidth + 24 < box.width ? left + 12 : left - this.tip.offsetWidth - 12;
    this.tip.style.left = `${Math.max(0, beside)}px`;
  }

  rowsAt(rate, time) {
    if (rate !== TOOL) return reading(this.drawn().map((i) => this.row(i, rate, time)));
    return [element("strong", "", this.speeds((values) => interpolated(this.data.times, values, time)))];
  }

  row(i, rate, time) {
    const joint = this.data.joints[i];
    const value = interpolated(this.data.times, this.data[rate][i], time);
    const of = rate === "position" || joint.limits[rate] === null ? "" : ` · ${percent(value / share(joint, rate, this.data.joints).half)}`;
    return { joint: i, name: joint.name, value: worded(value, joint, rate) + of };
  }
}

function peaks(joint) {
  return ["velocity", "acceleration"].map((rate) => {
    const [peak, limit] = [joint.peak[rate], joint.limits[rate]];
    return worded(peak, joint, rate) + (limit === null ? "" : `, ${percent(peak / limit)} of its limit`);
  }).join(" and ");
}

// Names that stand beside one another: without what all of them begin with, up to an underscore.
function shortened(names) {
  const [first = ""] = names;
  const ends = [...first.matchAll(/_/g)].map(({ index }) => index + 1);
  const common = ends.findLast((end) => names.every((name) => name.startsWith(first.slice(0, end)) && name.length > end));
  return names.length > 1 ? names.map((name) => name.slice(common ?? 0)) : names;
}

const percent = (part) => `${Math.round(100 * Math.abs(part))} %`;

function chip(name, title, press) {
  const made = Object.assign(button("", "", title, press), { ariaLabel: name });
  made.append(writeName(element("span", "name"), name, null));
  return made;
}

// The value at `time` of one that is `values[k]` at `times[k]`, linear between them.
function interpolated(times, values, time) {
  if (times.length < 2) return values[0];
  const { k, s } = between(times, time);
  return values[k] + s * (values[k + 1] - values[k]);
}
