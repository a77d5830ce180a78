// Screw theory drawn, and the numbers behind it, which are made only while somebody looks at them.

import { $ } from "./element.js";
import { Ellipsoid } from "./ellipsoids.js";
import { Instant } from "./instant.js";
import { Labels } from "./labels.js";
import { Numbers } from "./numbers.js";
import { Reach } from "./reach.js";
import { ANGULAR, LINEAR, column } from "./solids.js";
import { numbers } from "./theory_numbers.js";
import { Switches } from "./theory_switches.js";
import { Trace } from "./trace.js";
import { Twists } from "./twists.js";

export class Theory {
  // `page` holds view, state.hello and layers.
  constructor({ view, state, layers }) {
    this.view = view;
    this.state = state;
    this.axes = this.frame = null;
    /** @type {any} */ this.numbers = null;
    this.moved = 0;
    this.visible = layers.on;
    this.still = true; // nothing has moved yet
    this.labels = new Labels(view);
    this.instant = new Instant(view);
    this.spatial = new Twists(view);
    this.body = new Twists(view);
    this.linear = new Ellipsoid(view, LINEAR);
    this.angular = new Ellipsoid(view, ANGULAR);
    this.trace = new Trace(view);
    this.reach = new Reach(view);
    this.switches = new Switches({
      visible: (what, on) => layers.show({ [what]: on }),
      trace: (on) => this.traceFrom(on),
      clear: () => this.trace.clear(),
      chosen: () => this.draw(),
    });
    this.tables = new Numbers();
    this.layers = {
      screw: this.instant.group, spatial_columns: this.spatial.group, body_columns: this.body.group,
      linear_ellipsoid: this.linear.group, angular_ellipsoid: this.angular.group,
    };
    this.messages = {
      axes: (message) => this.build(message),
      reach: (message) => this.reach.draw(message),
    };
    addEventListener("panel", () => this.draw());
  }

  hello() {
    this.axes = this.frame = this.numbers = null;
    [this.moved, this.still] = [0, true];
    this.reach.clear();
  }

  build(axes) {
    this.axes = axes;
    const { arm } = this.state.hello;
    this.names = arm.joints.map(({ name }) => name);
    this.slides = arm.joints.map(({ unit }) => unit === "m");
    this.labels.build(axes);
    for (const twists of [this.spatial, this.body]) twists.build(axes, this.slides);
    for (const drawing of [this.instant, this.linear, this.angular, this.trace]) drawing.build(axes);
    this.switches.build(axes, this.names);
    this.tables.build(axes, this.names, arm);
    this.draw();
  }

  layered(layers) {
    this.visible = layers;
    this.labels.layer.hidden = !layers.labels;
    this.reach.show(Boolean(layers.reach));
    this.switches.show(layers);
    this.draw();
  }

  remembered() { return this.switches.remembered(); }

  recall(chosen) {
    this.switches.recall(chosen);
    this.draw();
  }

  update(frame) {
    if (!this.axes) return;
    const before = this.frame?.theta ?? frame.theta;
    const change = frame.theta.map((value, i) => Math.abs(value - before[i]) / (this.slides[i] ? this.axes.length : 1));
    const most = Math.max(0, ...change);
    if (most > 0) [this.moved, this.still] = [change.indexOf(most), false];
    this.frame = frame;
    const tool = this.view.node("/frames/tool");
    for (const drawing of [this.body, this.linear, this.angular]) drawing.stand(tool);
    this.trace.follow(tool.position);
    this.reach.follow(tool.position);
    this.draw();
  }

  chosen() {
    const { chosen } = this.switches;
    if (chosen !== null) return chosen;
    return this.numbers.motion ? null : this.moved;
  }

  draw() {
    const looking = !$("theory").hidden;
    const layers = Object.entries(this.layers);
    for (const [layer, group] of layers) group.visible = Boolean(this.visible[layer]) && this.frame !== null;
    this.view.viewer.set_dirty();
    if (!this.frame || !(looking || layers.some(([, group]) => group.visible))) return;
    const found = numbers(this.state.hello, this.axes, this.frame);
    this.numbers = found;
    const columns = this.switches.all ? this.names.map((_, i) => i) : [this.switches.chosen ?? this.moved];
    this.spatial.show(found.spatial, columns);
    this.body.show(found.body, columns);
    this.linear.show(found.linear, this.axes.linear);
    this.angular.show(found.angular, this.axes.angular);
    this.switches.say(found.motion ? null : this.names[this.moved], this.still);
    if (looking) this.tables.show(found, this.chosen());
    this.drawScrew();
  }

  drawScrew() {
    const { motion, columns, hybrid } = this.numbers;
    const i = this.chosen();
    const velocity = i === null ? motion.velocity : column(hybrid, i).toArray();
    const counted = i !== null && this.slides[i] ? this.axes.length : 1;
    this.instant.show(i === null ? motion.screw : columns[i], velocity, counted, this.view.node("/frames/tool").position);
  }

  traceFrom(on) {
    this.trace.group.visible = on;
    this.trace.follow(this.view.node("/frames/tool").position);
    this.view.viewer.set_dirty();
  }
}
