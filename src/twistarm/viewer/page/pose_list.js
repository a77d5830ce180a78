// The rows of recorded poses: a name to edit, how the arm moves there, and buttons to go there, to move the row and to
// delete it.

import { button, element } from "./element.js";
import { writeName } from "./names.js";

const LONGEST = 60;
const SAME = 1e-9; // rad, m: the arm stands on a pose
const MOVES = [
  ["joint", "joint", "Joint move: every joint goes straight to its value"],
  ["line", "line", "Straight line of the tool, turning evenly"],
  ["screw", "screw", "Screw motion of the tool: a turn about one axis and a slide along it"],
  ["via", "arc", "Circular arc of the tool through this pose to the next"],
  ["free", "free", "Any path without a collision, around the obstacles of the Scene panel"],
  ["level", "level", "Free, and the tool stays level within 3°, like a full cup"],
  ["direction", "axis", "Free, and the tool axis points the same way within 3°"],
  ["orientation", "rotation", "Free, and the tool does not turn by more than 3°"],
];

export class PoseList {
  // `act` holds go(id), rename(id, name), moveBy(id, by), reorder(id, place), remove(id).
  constructor(list, act) {
    this.list = list;
    this.act = act;
    this.poses = [];
    this.driven = false;
    this.rows = new Map();
  }

  show(poses) {
    const focused = document.activeElement;
    const at = [...this.list.children].indexOf(focused?.closest?.("li"));
    this.poses = poses;
    for (const [id, row] of this.rows) if (!poses.some((pose) => pose.id === id)) this.drop(id, row);
    poses.forEach((pose, place) => this.put(pose, place));
    if (at >= 0 && document.activeElement !== focused) this.focus(focused, at);
  }

  drop(id, row) {
    row.gone = true; // its box is left without a word
    row.item.remove();
    this.rows.delete(id);
  }

  // A row that stands where it belongs is not touched: somebody may be typing in it.
  put(pose, place) {
    if (!this.rows.has(pose.id)) this.rows.set(pose.id, new Row(pose, this));
    const row = this.rows.get(pose.id);
    row.show(pose, place, this.poses.length);
    row.showMove(pose.by, place === 0 ? "start" : place > 1 && this.poses[place - 1].by === "via" ? "arc’s end" : "");
    if (this.list.children[place] === row.item) return;
    row.moving = true;
    this.list.insertBefore(row.item, this.list.children[place] ?? null);
    row.moving = false;
  }

  // The focus stays on what was moved, and goes to the next row from one that was deleted.
  focus(focused, at) {
    if (focused.isConnected && !focused.disabled) return focused.focus();
    const next = focused.isConnected ? focused.closest("li") : this.list.children[Math.min(at, this.list.children.length - 1)];
    next?.querySelector(".go").focus();
  }

  // At once on this page, so that a key pressed twice moves a row two places; the process has the last word.
  move(id, step) {
    const from = this.poses.findIndex((pose) => pose.id === id);
    const place = from + step;
    if (place < 0 || place >= this.poses.length) return;
    const others = this.poses.filter((pose) => pose.id !== id);
    this.show([...others.slice(0, place), this.poses[from], ...others.slice(place)]);
    this.act.reorder(id, place);
  }

  mark(theta) {
    for (const { id, theta: pose } of this.poses) {
      const here = pose.every((value, i) => Math.abs(value - theta[i]) < SAME);
      if (here) this.rows.get(id).item.setAttribute("aria-current", "true");
      else this.rows.get(id).item.removeAttribute("aria-current");
    }
  }

  collide(ids) {
    for (const [id, { item }] of this.rows) {
      item.classList.toggle("collides", ids.includes(id));
      item.title = ids.includes(id) ? "In collision" : "";
    }
  }

  disable(driven) {
    this.driven = driven;
    for (const row of this.rows.values()) row.go.disabled = driven;
  }
}

class Row {
  constructor(pose, owner) {
    const { act } = owner;
    this.id = pose.id;
    this.owner = owner;
    this.name = "";
    this.moving = false;
    this.gone = false;
    this.item = element("li");
    this.box = this.makeBox();
    this.fixed = new Option("", "", false, false); // what the row's place in the list leaves no choice of
    this.fixed.hidden = true;
    this.by = this.makeMove();
    this.go = button("go", "Go", "", () => act.go(this.id));
    this.go.disabled = owner.driven;
    this.up = button("", "↑", "", () => owner.move(this.id, -1));
    this.down = button("", "↓", "", () => owner.move(this.id, 1));
    this.remove = button("", "✕", "", () => act.remove(this.id));
    const field = element("span", "field");
    this.label = element("span"); // over the box, in which a name is cut at its end
    this.label.ariaHidden = "true";
    field.append(this.box, this.label);
    this.item.append(field, this.by, this.go, this.up, this.down, this.remove);
    this.item.addEventListener("keydown", (event) => this.press(event));
  }

  makeBox() {
    const box = element("input", "name");
    Object.assign(box, { type: "text", maxLength: LONGEST, autocomplete: "off", spellcheck: false });
    box.addEventListener("blur", () => this.send());
    box.addEventListener("keydown", (event) => {
      if (event.key === "Escape") box.value = this.name;
      else if (event.key === "Enter") this.send();
    });
    return box;
  }

  makeMove() {
    const select = element("select");
    const options = MOVES.map(([by, text, title]) => Object.assign(new Option(text, by), { title }));
    select.append(this.fixed, ...options);
    select.addEventListener("change", () => this.owner.act.moveBy(this.id, select.value));
    return select;
  }

  // How the arm moves to the pose; `fixed`: in words, where its place in the list says it.
  showMove(by, fixed) {
    this.fixed.text = fixed;
    this.by.disabled = fixed !== "";
    this.by.value = fixed ? "" : by;
    this.by.title = fixed || MOVES.filter(([move]) => move === by)[0][2];
  }

  show({ name }, place, count) {
    const edited = this.box.value !== this.name && document.activeElement === this.box;
    this.name = name;
    if (!edited) this.box.value = name;
    [this.up.disabled, this.down.disabled] = [place === 0, place === count - 1];
    this.box.setAttribute("aria-label", `Name of pose ${place + 1}`);
    this.box.title = name;
    writeName(this.label, name, null);
    const words = [[this.go, "Go to"], [this.up, "Move up"], [this.down, "Move down"], [this.remove, "Delete"]];
    this.by.ariaLabel = `Move to ${name}`;
    for (const [made, word] of words) made.title = made.ariaLabel = `${word} ${name}`;
  }

  send() {
    const left = this.moving || this.gone || this.box.value === this.name;
    if (!left) this.owner.act.rename(this.id, this.box.value);
  }

  // Alt and an arrow move the row, whatever in it has the focus.
  press(event) {
    const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (!step || !event.altKey) return;
    this.owner.move(this.id, step);
    event.preventDefault();
    event.stopPropagation();
  }
}
