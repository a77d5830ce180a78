// The tool's pose as numbers to type, over the read-outs of where it is.

import { $, element } from "./element.js";
import { NumberBox } from "./number_box.js";
import { means, read, written, ZERO } from "./orientation.js";
import { THREE } from "./view.js";
import { withUnit } from "./units.js";

export class PoseBoxes {
  /** @type {NumberBox[]} */ boxes = [];
  /** @type {any} as shown: x, y, z and the orientation */ numbers;

  // `panel.tool` holds the read-outs; `ask(pose)` sends one.
  constructor(panel, ask) {
    const { tool } = panel;
    this.panel = panel;
    this.tool = tool;
    this.ask = ask;
    this.disabled = [false, false];
    tool.onBuilt.push(() => this.build());
    this.build();
    $("radians").addEventListener("change", () => this.label());
    $("tool-numbers").addEventListener("focusout", ({ relatedTarget }) => {
      if (!$("tool-numbers").contains(relatedTarget)) this.typed = null;
    });
  }

  build() {
    for (const box of this.boxes) box.restore();
    this.numbers = null;
    this.typed = null; // an orientation as it is being typed, of any length, until the boxes are left
    this.boxes = Object.entries(this.tool.units).map(([name, unit], i) => this.make(name, unit, i));
    this.disable(...this.disabled);
    if (this.pose) this.show(this.pose);
  }

  make(name, unit, i) {
    const box = new NumberBox({ name: `tool ${name}`, unit, limits: [null, null] }, this.panel, (value) => this.send(i, value));
    const entry = element("dd", "entry");
    entry.append(box.input);
    this.tool.cells[i].after(entry);
    return box;
  }

  send(i, value) {
    const { way } = this.tool;
    const numbers = this.typed ? [...this.numbers.slice(0, 3), ...this.typed] : this.numbers;
    const [x, y, z, ...turned] = numbers.with(i, value);
    const quaternion = read(way, turned);
    if (!quaternion) return this.panel.complain(ZERO[way], this.boxes[i]);
    this.numbers = [x, y, z, ...turned];
    this.tool.last = turned;
    if (way !== "rpy" && i >= 3) this.typed = turned;
    return this.ask({ position: new THREE.Vector3(x, y, z), quaternion });
  }

  label() {
    for (const box of this.boxes) box.label();
    this.show(this.pose);
  }

  show(pose) {
    this.pose = pose;
    const { way } = this.tool;
    const held = this.typed && means(way, this.typed, pose.quaternion);
    const turned = held ? this.typed : written(way, pose.quaternion, this.numbers?.slice(3) ?? this.tool.last);
    this.numbers = [...pose.position.toArray(), ...turned];
    this.boxes.forEach((box, i) => box.show(this.numbers[i], withUnit(this.numbers[i], box.joint.unit)));
  }

  // Nothing to type, or no angles where any will do.
  disable(all, angles) {
    this.disabled = [all, angles];
    this.boxes.forEach((box, i) => box.disable(all || (angles && i >= 3)));
  }
}
