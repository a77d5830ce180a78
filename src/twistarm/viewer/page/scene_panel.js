// The panel of the scene: what collides, and the obstacles to add, drag, size, remove and save.

import { matrixOf } from "./collision.js";
import { $, button, element } from "./element.js";
import { Gizmo } from "./gizmo.js";
import { NumberBox } from "./number_box.js";
import { numbersOf, poseOf, turned } from "./target_pose.js";
import { THREE } from "./view.js";
import { report } from "./words.js";

const ADDED = { box: [1, 1, 1], sphere: [0.5], cylinder: [0.5, 1] }; // sizes beside LARGE
const LARGE = 0.25; // of the arm's radius
const ASIDE = 0.4; // of the arm's radius, from the tool to an obstacle that is added
const SIDES = [[1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [-1, 0, 0]]; // of the tool, in the order in which they are tried
const STEP = 0.01; // m, to which both are rounded
const SIZES = { box: ["size x", "size y", "size z"], sphere: ["radius"], cylinder: ["radius", "length"], capsule: ["radius", "length"] };
const PLACE = [["x", "m"], ["y", "m"], ["z", "m"], ["roll", "rad"], ["pitch", "rad"], ["yaw", "rad"]];

export class ScenePanel {
  // `page` holds view, panel, state and ask(request); `collision` draws the obstacles.
  constructor(page, collision) {
    this.page = page;
    this.collision = collision;
    this.obstacles = [];
    this.chosen = null; // a name
    this.boxes = [];
    this.gizmo = new Gizmo(page.view, {
      begin: () => { this.typed = null; this.start = this.pose(); },
      move: (pose) => this.put(pose),
      end: () => {},
      cancel: () => this.put(this.start),
      snap: () => $("target-snap").checked,
    });
    this.messages = {
      obstacles: (message) => this.show(message),
      collision: (message) => this.report(message),
    };
    for (const kind of Object.keys(ADDED)) $(`add-${kind}`).addEventListener("click", () => this.add(kind));
    $("download-scene").href = "scene.toml";
    $("save-scene").addEventListener("click", () => page.ask({ type: "save_scene" }));
    addEventListener("panel", () => this.update());
    $("radians").addEventListener("change", () => this.choose(this.chosen));
  }

  hello() { this.choose(null); }
  offline() { this.gizmo.drop(); }

  show({ obstacles, file, saved }) {
    const list = obstacles.map(({ name }) => name).join("\n");
    const other = this.obstacles.map(({ name }) => name).join("\n") !== list;
    this.obstacles = obstacles;
    if (other) {
      $("obstacle-list").replaceChildren(...obstacles.map((obstacle) => this.row(obstacle)));
      this.choose(this.chosen);
      this.page.view.settle();
    }
    $("save-scene").hidden = file === null;
    $("save-scene").disabled = saved;
    $("save-scene").title = saved ? `${file} is up to date` : `Write ${file}`;
    this.update();
  }

  report({ ready, words, nearest }) {
    this.ready = ready;
    $("scene-hint").hidden = ready;
    for (const kind of Object.keys(ADDED)) $(`add-${kind}`).disabled = !ready;
    $("download-scene").hidden = !ready;
    const calm = nearest === null ? "" : ` Nearest: ${nearest.words}.`;
    const others = words.length > 1 ? `, and ${words.length - 1} more` : "";
    if (words.length > 0) report($("scene-words"), words[0] + others, words.slice(1));
    else report($("scene-words"), ready ? `Nothing collides.${calm}` : "");
    $("scene-words").classList.toggle("collides", words.length > 0);
    this.mark();
  }

  row({ name, kind }) {
    const item = element("li");
    const pick = button("name", name, `${name}: handles to drag it, and its numbers`, () => this.choose(this.chosen === name ? null : name));
    const away = button("", "✕", `Remove ${name}`, () => this.page.ask({ type: "remove_obstacle", name }));
    away.ariaLabel = `Remove ${name}`;
    item.append(pick, element("span", "kind", kind), away);
    return item;
  }

  // Which obstacle has handles and numbers; one that is about to come may be chosen.
  choose(name) {
    this.chosen = name;
    this.last = undefined; // numbers shown
    this.typed = null; // those asked for by hand, until what stands has arrived
    const obstacle = this.find();
    const boxes = obstacle ? [...(SIZES[obstacle.kind] ?? []).map((text) => [text, "m"]), ...this.placing] : [];
    this.boxes = boxes.map(([text, unit], i) => this.box(text, unit, i));
    $("obstacle-numbers").replaceChildren(...this.boxes.map(({ joint, input }) => {
      const label = element("label", joint.label === "x" ? "place" : "", `${joint.label} `);
      label.append(input);
      return label;
    }));
    this.mark();
    this.update();
  }

  // What its pose is told by: the turns of a sphere are not seen.
  get placing() { return this.find().kind === "sphere" ? PLACE.slice(0, 3) : PLACE; }

  box(label, unit, i) {
    const joint = { name: `${this.chosen}, ${label}`, label, limits: [null, null], unit };
    return new NumberBox(joint, this.page.panel, (value) => this.type(i, value));
  }

  find() {
    return this.obstacles.find(({ name }) => name === this.chosen);
  }

  mark() {
    [...$("obstacle-list").children].forEach((item, i) => {
      const { name } = this.obstacles[i];
      item.firstChild.setAttribute("aria-pressed", String(name === this.chosen));
      item.classList.toggle("collides", this.collision.hit.has(name));
    });
  }

  pose() { return poseOf(matrixOf(this.find(), this.page.state.frame).toArray()); }

  numbers() {
    const { kind, size } = this.find();
    return [...(SIZES[kind] ? size : []), ...numbersOf(this.pose(), this.last).slice(0, this.placing.length)];
  }

  // Handles and numbers where the obstacle stands; one that a link holds goes along and is not dragged.
  update() {
    const obstacle = this.find();
    const on = obstacle !== undefined && !obstacle.held && this.ready && !$("scene").hidden;
    if (on) this.gizmo.place(this.pose(), this.pose(), "base");
    this.gizmo.show(on, null, ({ kind }) => kind !== "turn" || obstacle?.kind !== "sphere");
    if (!obstacle) return;
    this.last = this.typed ?? this.numbers();
    this.last.forEach((number, i) => this.boxes[i].show(number, ""));
    for (const box of this.boxes) box.disable(obstacle.held || !this.ready);
  }

  // What was asked for last has arrived, or was refused.
  release() {
    this.typed = null;
    this.update();
  }

  type(i, value) {
    const numbers = this.typed ?? this.numbers();
    numbers[i] = value;
    const sizes = numbers.length - this.placing.length;
    this.typed = numbers;
    const turns = numbersOf(this.pose(), this.last).slice(this.placing.length); // those that have no boxes
    this.put(turned([...numbers.slice(sizes), ...turns]), sizes > 0 ? numbers.slice(0, sizes) : undefined);
  }

  put({ position, quaternion }, size = this.find().size, { name, kind } = this.find()) {
    this.page.ask({ type: "obstacle", name, kind, size, position: position.toArray(), xyzw: quaternion.toArray() });
  }

  // A place beside the tool, in the picture: somebody may have turned the view, which then stays.
  beside(tool, away) {
    const { view } = this.page;
    const spots = SIDES.map((side) => new THREE.Vector3(...side).multiplyScalar(away).add(tool));
    const spot = view.turned ? (spots.find((place) => view.sees(place)) ?? view.middle()) : spots[0];
    return spot.fromArray(spot.toArray().map((value) => STEP * Math.round(value / STEP)));
  }

  add(kind) {
    const { radius } = this.page.view;
    const rounded = (value) => STEP * Math.max(1, Math.round(value / STEP));
    const names = this.obstacles.map(({ name }) => name);
    const free = (count) => (names.includes(`${kind} ${count}`) ? free(count + 1) : `${kind} ${count}`);
    const name = $("obstacle-name").value.trim() || free(1);
    if (names.includes(name)) return this.page.panel.showError(`an obstacle is already called ${name}; choose another name`);
    const position = this.beside(poseOf(this.page.state.frame.transforms["/frames/tool"]).position, ASIDE * radius);
    this.chosen = name;
    $("obstacle-name").value = "";
    const size = ADDED[kind].map((share) => rounded(share * LARGE * radius));
    this.put({ position, quaternion: new THREE.Quaternion() }, size, { name, kind });
  }
}
