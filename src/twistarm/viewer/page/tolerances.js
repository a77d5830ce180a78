// How far off a target is still reached, typed in two boxes: the same on every page, and for the motions planned there.

import { DEFAULTS } from "./core.js";
import { $ } from "./element.js";
import { typed, unitShown } from "./units.js";

const MILLIMETRE = 1e-3;

export class Tolerances {
  // `page` holds ask(request); `changed()` is called once others hold.
  constructor(page, changed) {
    this.page = page;
    this.changed = changed;
    this.position = this.orientation = 0; // [m, rad], 0: the usual ones
    this.boxes = [$("target-position-tol"), $("target-orientation-tol")];
    for (const box of this.boxes) box.addEventListener("change", () => this.send());
    $("radians").addEventListener("change", () => this.write());
  }

  send() {
    const [millimetres, angle] = this.boxes.map((box) => box.value);
    const position = typed(millimetres, "m", 1 / MILLIMETRE) ?? 0;
    const orientation = typed(angle, "rad") ?? 0;
    if (position < 0 || orientation < 0) return this.write();
    this.page.ask({ type: "tolerances", position, orientation });
  }

  show({ position, orientation }) {
    const same = position === this.position && orientation === this.orientation;
    Object.assign(this, { position, orientation });
    this.write();
    if (!same) this.changed();
  }

  write() {
    const turn = 1 / typed("1", "rad");
    const [place, angle] = [this.position / MILLIMETRE, this.orientation * turn];
    [place, angle].forEach((value, i) => (this.boxes[i].value = value ? Number(value.toPrecision(4)) : ""));
    $("target-orientation-unit").textContent = unitShown("rad");
    this.boxes[1].placeholder = Number((DEFAULTS.orientation * turn).toPrecision(2));
  }

  disable(disabled) {
    for (const box of this.boxes) box.disabled = disabled;
  }
}
