// What of screw theory is drawn, for which joint, and at which scale.

import { $, button, element } from "./element.js";
import { short } from "./figures.js";
import { cut } from "./names.js";

const LONGEST = 22; // letters of a joint's name
const SHORT = 11; // behind other words

const LAYERS = {
  labels: ["Labels", "Name and pitch at each joint's axis, S and T at the frames"],
  screw: ["Instantaneous screw", "The tool's motion now, as a turn about a line and a slide along it"],
  spatial_columns: ["Columns of Jˢ", "Each column as v and ω, drawn at the space frame S"],
  body_columns: ["Columns of Jᵇ", "Each column as v and ω, drawn at the tool frame T, in its axes"],
  linear_ellipsoid: ["Linear ellipsoid", "Velocities of the tool's origin for joint rates of 1 rad/s in all"],
  angular_ellipsoid: ["Angular ellipsoid", "Angular velocities of the tool for joint rates of 1 rad/s in all"],
  reach: ["Reach", "Where the tool comes to inside the limits, coloured by the share of directions reached"],
};

export class Switches {
  // `act` holds visible(layer, on), trace(on), clear(), chosen().
  constructor(act) {
    this.boxes = new Map(Object.entries(LAYERS).map(([layer, [name, title]]) => [layer, box(name, title)]));
    this.boxes.get("reach").dataset.python = "reach";
    this.trace = box("Trace", "Where the tool has been on this page");
    const clear = button("", "Clear", "Clear the trace", () => act.clear());
    clear.setAttribute("aria-label", "Clear the trace");
    clear.hidden = true; // until there is one
    const traced = element("span", "traced");
    traced.append(this.trace, clear);
    $("theory-layers").replaceChildren(...this.boxes.values(), traced);
    for (const [layer, label] of this.boxes) {
      label.firstChild.addEventListener("change", (event) => act.visible(layer, event.target.checked));
    }
    this.trace.firstChild.addEventListener("change", ({ target }) => {
      clear.hidden = !target.checked;
      act.trace(target.checked);
    });
    for (const id of ["theory-joint", "theory-all"]) $(id).addEventListener("change", () => act.chosen());
  }

  // The coordinate chosen; null: the one that moved last, or the motion that plays.
  get chosen() {
    const { value } = $("theory-joint");
    return value === "" ? null : Number(value);
  }

  get all() { return $("theory-all").checked; }
  remembered() { return { joint: $("theory-joint").value, all: this.all }; }

  recall({ joint, all }) {
    $("theory-joint").value = joint;
    $("theory-all").checked = all;
  }

  build(axes, names) {
    this.last = element("option", "", "last moved");
    this.last.value = "";
    $("theory-joint").replaceChildren(this.last, ...names.map((name, i) => Object.assign(element("option", "", cut(name, LONGEST)), { value: i, title: name })));
    const { linear, angular, length } = axes;
    $("theory-scale").textContent = `Drawn: 1 m/s is ${short(linear)} m long, 1 rad/s ${short(angular)} m; `
      + `joints at 1 rad/s, slides at ${short(length)} m/s (the reach).`;
  }

  // Which joint is shown where none is chosen, the first while all stand `still`; null: the whole motion is shown.
  say(name, still) {
    const text = name === null ? "the motion on show" : `${still ? "first joint" : "last moved"}: ${cut(name, SHORT)}`;
    if (this.last.textContent !== text) this.last.textContent = text;
  }

  show(layers) {
    for (const [layer, label] of this.boxes) label.firstChild.checked = Boolean(layers[layer]);
    const drawn = Object.keys(LAYERS).filter((layer) => layers[layer]);
    $("theory-legend").hidden = !drawn.some((layer) => !["labels", "reach"].includes(layer));
  }
}

function box(name, title) {
  const label = element("label");
  const input = element("input");
  input.type = "checkbox";
  label.title = title;
  label.append(input, ` ${name}`);
  return label;
}
