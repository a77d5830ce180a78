// The tool's pose as six numbers to type, over the read-outs of where it is.

import { $, element } from "./element.js";
import { NumberBox } from "./number_box.js";
import { shown } from "./units.js";

const NAMES = ["x", "y", "z", "roll", "pitch", "yaw"];

export class PoseBoxes {
  // `act` holds send(numbers) with the six [m, rad], complain(text, box) and settle(box).
  constructor(act) {
    this.act = act;
    this.numbers = [0, 0, 0, 0, 0, 0];
    this.boxes = NAMES.map((name, i) => this.make(name, i));
    $("radians").addEventListener("change", () => this.label());
  }

  make(name, i) {
    const quantity = { name: `tool ${name}`, unit: i < 3 ? "m" : "rad", limits: [null, null] };
    const box = new NumberBox(quantity, {
      send: (value) => this.act.send(this.numbers.map((number, k) => (k === i ? value : number))),
      complain: (text, wrong) => this.act.complain(text, wrong),
      settle: (wrong) => this.act.settle(wrong),
    });
    const entry = element("dd", "entry");
    entry.append(box.input);
    $(`tool-${name}`).after(entry);
    return box;
  }

  // The unit on the page is another.
  label() {
    for (const box of this.boxes) box.label();
    this.show(this.numbers);
  }

  show(numbers) {
    this.numbers = numbers;
    this.boxes.forEach((box, i) => box.show(numbers[i], shown(numbers[i], box.joint.unit)));
  }

  // Nothing to type, or no angles where any will do.
  disable(all, angles) {
    this.boxes.forEach((box, i) => box.disable(all || (angles && i >= 3)));
  }
}
