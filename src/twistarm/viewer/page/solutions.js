// All configurations that meet the target: counted, stepped through, and each drawn faintly.

import { ArmCopy } from "./arm_copy.js";
import { $, element } from "./element.js";
import { eases } from "./glide.js";
import { takesKeys } from "./keys.js";

const KEYS = { KeyN: 1, KeyP: -1 }; // next and previous
const INSIDE = { colour: "--accent", opacity: 0.16 };
const BEYOND = { colour: "--warn", opacity: 0.16 };
const CHOSEN = 0.45; // opacity of one beyond the limits, where the arm does not go

export class Solutions {
  // `page` holds view and ask(request); `wanted()` says what is to be met.
  constructor(page, wanted) {
    this.page = page;
    this.wanted = wanted;
    this.places = [];
    this.ghosts = [];
    this.arms = [];
    this.at = null;
    this.asked = false;
    this.messages = {
      solutions: (message) => this.show(message),
      solution: ({ at }) => this.choose(at),
      servo: ({ driven }) => ($("solutions-all").disabled = driven),
    };
    page.view.onDrawn.push(() => this.draw()); // what they are copies of has changed
    $("solutions-all").addEventListener("click", () => this.ask());
    $("solution-next").addEventListener("click", () => this.step(1));
    $("solution-previous").addEventListener("click", () => this.step(-1));
    $("solutions-end").addEventListener("click", () => page.ask({ type: "solutions_end" }));
    $("solution-ghosts").addEventListener("change", () => this.draw());
    addEventListener("keydown", (event) => this.press(event));
  }

  hello() {
    this.show({ asked: false, places: [], words: "", ghosts: [] });
  }

  press({ code, repeat, ctrlKey, metaKey, altKey }) {
    if (!(code in KEYS) || repeat || ctrlKey || metaKey || altKey || takesKeys(document.activeElement)) return;
    if ($("solutions-all").disabled) return;
    if (this.asked) this.step(KEYS[code]);
    else this.ask();
  }

  ask() {
    const wanted = this.wanted();
    if (wanted) this.page.ask({ type: "solutions", ...wanted });
  }

  step(by) {
    const { length } = this.places;
    if (length === 0) return;
    const place = this.at === null ? (by > 0 ? 0 : length - 1) : (this.at + by + length) % length;
    this.page.ask({ type: "solution", place, ease: eases() });
  }

  show({ asked, places, words, ghosts }) {
    this.asked = asked;
    this.places = places;
    this.ghosts = ghosts;
    $("solutions").hidden = !asked;
    const [, ...lines] = words.split("\n"); // the first says what is asked
    $("solutions-words").replaceChildren(...lines.map((line) => element("p", line.startsWith(" ") ? "why" : "", line.trim())));
    this.choose(null);
  }

  // Which of them is on show, or beyond the limits, so that the arm does not go there.
  choose(at) {
    this.at = at;
    const { length } = this.places;
    const { free, beyond } = this.places[at] ?? { free: [], beyond: [] };
    $("solution-place").textContent = length === 0 ? "none" : `${at === null ? "–" : at + 1} of ${length}`;
    for (const id of ["solution-next", "solution-previous"]) $(id).disabled = length === 0 || (length === 1 && at === 0);
    $("solutions").dataset.beyond = beyond.length > 0;
    $("solution-words").textContent = beyond.length > 0 ? `outside the limits: ${beyond.join(", ")}; the arm stays`
      : free.length > 0 ? `one of a family: ${free.join(", ")} may go on moving` : "";
    this.draw();
  }

  draw() {
    for (const arm of this.arms) {
      arm.clear();
      arm.group.removeFromParent();
    }
    this.arms = [];
    const shown = $("solution-ghosts").checked ? this.ghosts : [];
    for (const [i, transforms] of shown.entries()) {
      const beyond = this.places[i].beyond.length > 0;
      if (i === this.at && !beyond) continue; // the arm itself
      const { colour, opacity } = beyond ? BEYOND : INSIDE;
      const arm = new ArmCopy(this.page.view, colour, i === this.at ? CHOSEN : opacity);
      arm.stand(transforms);
      this.page.view.viewer.scene.add(arm.group);
      this.arms.push(arm);
    }
    this.page.view.viewer.set_dirty();
  }
}
