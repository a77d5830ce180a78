// Where the tool is, as numbers: its position, and its orientation in the way that somebody chose in this browser.

import { $, element } from "./element.js";
import { WAYS, written } from "./orientation.js";
import { keep, kept } from "./storage.js";
import { poseOf } from "./target_pose.js";
import { withUnit, signed } from "./units.js";

const KEPT = "twistarm orientation";

export class ToolNumbers {
  /** @type {HTMLElement[]} */ cells;

  constructor() {
    this.onBuilt = []; // done once the numbers are others
    this.frame = null;
    this.switch = $("orientation");
    this.switch.addEventListener("change", () => this.choose(this.switch.value));
    this.choose(kept(KEPT));
  }

  choose(way) {
    this.way = way in WAYS ? way : "rpy";
    this.switch.value = this.way;
    keep(KEPT, this.way);
    this.last = undefined; // numbers of the orientation, shown or typed
    this.units = { x: "m", y: "m", z: "m", ...WAYS[this.way] };
    this.cells = Object.keys(this.units).map(() => element("dd"));
    $("tool-numbers").replaceChildren(...Object.keys(this.units).map((name, i) => {
      const group = element("div", name.length > 1 && this.way !== "rpy" ? "narrow" : "");
      group.append(element("dt", "", name), Object.assign(this.cells[i], { id: `tool-${name.replace(" ", "-")}` }));
      return group;
    }));
    for (const act of this.onBuilt) act();
    if (this.frame) this.show(this.frame);
  }

  show(frame) {
    this.frame = frame;
    const { position, rpy } = frame.tool;
    this.last = written(this.way, poseOf(frame.transforms["/frames/tool"]).quaternion, this.last, rpy);
    const units = Object.values(this.units);
    [...position, ...this.last].forEach((value, i) => {
      this.cells[i].textContent = units[i] === "m" ? `${signed(value, 3)} m` : withUnit(value, units[i]);
    });
  }
}
