// Screw theory drawn, and the numbers behind it. Every number comes from the process.

import { $ } from "./element.js";
import { Ellipsoid } from "./ellipsoids.js";
import { Instant } from "./instant.js";
import { Labels } from "./labels.js";
import { Numbers } from "./numbers.js";
import { Reach } from "./reach.js";
import { ANGULAR, LINEAR, column } from "./solids.js";
import { Switches } from "./theory_switches.js";
import { Trace } from "./trace.js";
import { Twists } from "./twists.js";

export class Theory {
  // `page` holds view, state.hello and layers.
  constructor({ view, state, layers }) {
    this.view = view;
    this.state = state;
    this.read = (on) => layers.want("theory", on);
    this.axes = null;
    this.numbers = null;
    this.visible = layers.on;
    this.looking = false;
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
      labels: this.labels.layer, screw: this.instant.group,
      spatial_columns: this.spatial.group, body_columns: this.body.group,
      linear_ellipsoid: this.linear.group, angular_ellipsoid: this.angular.group,
    };
    this.messages = {
      axes: (message) => this.build(message),
      theory: (message) => this.take(message),
      reach: (message) => this.reach.draw(message),
    };
    addEventListener("panel", () => this.look());
  }

  hello() {
    this.numbers = this.axes = null;
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
    this.view.viewer.set_dirty();
  }

  layered(layers) {
    this.visible = layers;
    for (const [layer, drawn] of Object.entries(this.layers)) {
      if (drawn instanceof HTMLElement) drawn.hidden = !layers[layer];
      else drawn.visible = Boolean(layers[layer]) && this.numbers !== null;
    }
    this.reach.show(Boolean(layers.reach));
    this.switches.show(layers);
    this.look();
    this.view.viewer.set_dirty();
  }

  // The numbers are made only while somebody reads them.
  look() {
    this.looking = !$("theory").hidden;
    this.read(this.looking);
    if (this.looking && this.numbers) this.tables.show(this.numbers, this.chosen());
  }

  remembered() {
    return this.switches.remembered();
  }

  recall(chosen) {
    this.switches.recall(chosen);
    this.draw();
  }

  // Nobody knows the numbers any more.
  forget() {
    if (this.numbers === null) return;
    this.numbers = null;
    this.layered(this.visible);
  }

  take(numbers) {
    this.numbers = numbers;
    this.layered(this.visible);
    this.draw();
  }

  placed() {
    if (!this.axes) return;
    const tool = this.view.node("/frames/tool");
    for (const drawing of [this.body, this.linear, this.angular]) drawing.stand(tool);
    this.trace.follow(tool.position);
    this.reach.follow(tool.position);
    if (this.numbers && this.layers.screw.visible) this.drawScrew();
  }

  // Of which coordinate the screw is shown; null: of the whole motion.
  chosen() {
    const { chosen } = this.switches;
    if (chosen !== null) return chosen;
    return this.numbers.motion ? null : this.numbers.moved;
  }

  draw() {
    if (!this.numbers || !this.axes) return;
    const { numbers } = this;
    const shown = this.switches.all ? this.names.map((_, i) => i) : [this.switches.chosen ?? numbers.moved];
    this.spatial.show(numbers.spatial, shown);
    this.body.show(numbers.body, shown);
    this.linear.show(numbers.linear, this.axes.linear);
    this.angular.show(numbers.angular, this.axes.angular);
    this.switches.say(numbers.motion ? null : this.names[numbers.moved]);
    if (this.looking) this.tables.show(numbers, this.chosen());
    this.placed();
    this.drawScrew();
    this.view.viewer.set_dirty();
  }

  drawScrew() {
    const { motion, columns, hybrid } = this.numbers;
    const i = this.chosen();
    const screw = at(i === null ? motion.screw : columns, i ?? 0);
    const velocity = i === null ? motion.velocity : column(hybrid, i).toArray();
    const counted = i !== null && this.slides[i] ? this.axes.length : 1;
    this.instant.show(screw, velocity, counted, this.view.node("/frames/tool").position);
  }

  traceFrom(on) {
    this.trace.group.visible = on;
    this.trace.follow(this.view.node("/frames/tool").position);
    this.view.viewer.set_dirty();
  }
}

// One of several screws.
function at({ axis, point, pitch, magnitude }, i) {
  return { axis: axis[i], point: point[i], pitch: pitch[i], magnitude: magnitude[i] };
}
