// The panel beside the view: joints, named poses, the tool, switches, the player.

import { shortened, shown, signed } from "./units.js";

const $ = (id) => document.getElementById(id);

function element(tag, className, text) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text !== undefined) made.textContent = text;
  return made;
}

export class Panel {
  // `act` holds what the page does about the panel: joint(name, value), pose(name), visible(what, on), play(),
  // pause(), seek(time), fit().
  constructor(act) {
    this.act = act;
    this.rows = new Map();
    this.names = [];
    this.held = null; // the joint under somebody's hand: its slider is not moved from outside
    this.running = false;
    this.duration = 0; // of the trajectory, s; the scrubber runs from 0 to 1
    for (const what of ["screws", "frames", "path"]) {
      $(`show-${what}`).addEventListener("change", (event) => act.visible(what, event.target.checked));
    }
    $("fit").addEventListener("click", () => act.fit());
    $("play").addEventListener("click", () => (this.running ? act.pause() : act.play()));
    $("scrub").addEventListener("input", (event) => act.seek(Number(event.target.value) * this.duration));
  }

  // `arm` as the process describes it, `notes` on what could not be drawn; without `movable` the sliders only show.
  build(arm, notes, movable) {
    document.title = `${arm.name} · twistarm`;
    $("name").textContent = $("name").title = arm.name;
    $("ends").textContent = `${arm.joints.length} joint${arm.joints.length === 1 ? "" : "s"}, ${arm.base} → ${arm.tip}`;
    $("poses").replaceChildren(...(movable ? arm.poses.map((name) => this.poseButton(name)) : []));
    this.rows.clear();
    const rows = arm.joints.map((joint) => this.row(joint, movable));
    if (arm.others.length) rows.push(element("h2", "", "Other joints"));
    rows.push(...arm.others.map((joint) => this.row(joint, movable)));
    $("joints").replaceChildren(...rows);
    this.names = arm.joints.map((joint) => joint.name);
    $("notes").replaceChildren(...notes.map((note) => element("li", "", note)));
    for (const item of $("legend").children) item.hidden = !arm.screws.includes(item.className);
  }

  poseButton(name) {
    const button = element("button", "", name);
    button.type = "button";
    button.addEventListener("click", () => this.act.pose(name));
    return button;
  }

  row(joint, movable) {
    const row = element("label", "joint");
    const name = element("span", "name", joint.name);
    name.title = joint.name;
    name.append(element("span", "type", joint.type));
    const value = element("output");
    const slider = element("input");
    Object.assign(slider, { type: "range", min: joint.range[0], max: joint.range[1], step: "any", disabled: !movable });
    slider.dataset.joint = joint.name;
    slider.addEventListener("input", () => {
      this.held = joint.name;
      this.tell(slider, value, shown(Number(slider.value), joint.unit));
      this.act.joint(joint.name, Number(slider.value));
    });
    const [low, high] = joint.range.map((end) => element("span", "end", shortened(end, joint.unit)));
    const head = element("span", "head");
    head.append(name, value);
    row.append(head, low, slider, high);
    this.rows.set(joint.name, { joint, row, slider, value });
    return row;
  }

  show(frame) {
    this.names.forEach((name, i) => this.showJoint(name, frame.theta[i]));
    for (const [name, value] of Object.entries(frame.others)) this.showJoint(name, value);
    const { position, rpy } = frame.tool;
    ["x", "y", "z"].forEach((axis, i) => { $(`tool-${axis}`).textContent = `${signed(position[i], 3)} m`; });
    ["roll", "pitch", "yaw"].forEach((angle, i) => { $(`tool-${angle}`).textContent = shown(rpy[i], "rad"); });
    this.showTime(frame.time, frame.running);
  }

  showJoint(name, number) {
    const { joint, row, slider, value } = this.rows.get(name);
    if (this.held === name) return;
    slider.value = number;
    this.tell(slider, value, shown(number, joint.unit));
    const [lower, upper] = joint.limits;
    row.classList.toggle("outside", (lower !== null && number < lower - 1e-6) || (upper !== null && number > upper + 1e-6));
  }

  // The value beside a slider, and the same in words for whoever hears the page.
  tell(slider, value, text) {
    value.textContent = text;
    slider.setAttribute("aria-valuetext", text);
  }

  // The hand is off, and what it asked for has arrived.
  release() {
    this.held = null;
  }

  // While a servo drives, the arm's joints are not for hands; those beside it still are.
  showDriven(driven) {
    for (const name of this.names) this.rows.get(name).slider.disabled = driven;
    for (const button of $("poses").children) button.disabled = driven;
    $("scrub").disabled = driven;
    for (const id of ["poses", "joints"]) $(id).title = driven ? "A servo drives the arm" : "";
    $("panel").classList.toggle("driven", driven);
  }

  showVisible(layers) {
    for (const what of ["screws", "frames", "path"]) $(`show-${what}`).checked = layers[what];
    $("legend").hidden = !layers.screws;
  }

  showPath(there) {
    $("show-path").parentElement.hidden = !there;
  }

  showPlayer(duration) {
    $("player").hidden = duration === null;
    this.duration = duration ?? 0;
  }

  showTime(time, running) {
    this.running = running;
    $("play").textContent = running ? "❚❚" : "▶";
    $("play").setAttribute("aria-label", running ? "Pause" : "Play");
    $("scrub").value = this.duration > 0 ? time / this.duration : 0;
    this.tell($("scrub"), $("time"), `${time.toFixed(2)} / ${this.duration.toFixed(2)} s`);
  }

  showStatus(state) {
    $("status").textContent = state;
    $("status").dataset.state = state;
  }

  showError(message) {
    $("error").textContent = message;
    $("error").hidden = message === "";
  }
}
