// All configurations that reach the target: counted, stepped through, and each drawn faintly.

import { ArmCopy } from "./arm_copy.js";
import { $ } from "./element.js";
import { eases } from "./glide.js";
import { bare } from "./keys.js";
import { report } from "./words.js";

const KEYS = { KeyN: 1, KeyP: -1 }; // next and previous
const INSIDE = { colour: "--accent", opacity: 0.16 };
const BEYOND = { colour: "--warn", opacity: 0.16 };
const STATISTICS = /, \d+ of \d+ searches .*/;
const CHOSEN = 0.45; // opacity of one beyond the limits, where the arm does not go

export class Solutions {
  // `page` holds view, links(theta) and ask(request); `target()`: the target to reach.
  constructor(page, target) {
    this.page = page;
    this.target = target;
    this.places = [];
    this.theta = [];
    this.arms = [];
    this.at = null;
    this.current = null;
    this.requested = false;
    this.hit = []; // the places of those that collide
    this.differ = false; // whether other joints may go on moving in some of them
    this.messages = {
      solutions: (message) => this.show(message),
      solution: ({ at, current }) => this.choose(at, current),
      colliding: ({ solutions }) => this.collide(solutions),
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

  hello() { this.show({ requested: false, places: [], words: "", theta: [] }); }

  press(event) {
    if (!(event.code in KEYS) || !bare(event) || $("solutions-all").disabled) return;
    if (this.requested) this.step(KEYS[event.code]);
    else this.ask();
  }

  ask() {
    const target = this.target();
    if (target) this.page.ask({ type: "solutions", ...target });
  }

  step(by) {
    const { length } = this.places;
    if (length === 0) return;
    const place = this.at === null ? (by > 0 ? 0 : length - 1) : (this.at + by + length) % length;
    this.page.ask({ type: "solution", place, ease: eases() });
  }

  show({ requested, places, words, theta }) {
    this.requested = requested;
    this.places = places;
    this.theta = theta;
    this.differ = new Set(places.map(({ free, beyond }) => (beyond.length > 0 ? places[0].free : free).join())).size > 1; // else the words say it
    $("solutions").hidden = !requested;
    const [, ...lines] = words.split("\n"); // the first says what is requested
    report($("solutions-words"), lines[0]?.replace(STATISTICS, "") ?? "", lines.slice(STATISTICS.test(lines[0]) ? 0 : 1));
    this.choose(this.at, this.current);
    if (requested && this.page.view.radius !== undefined) this.page.view.reframe();
  }

  // Which of them was chosen, and where the arm current: it does not go beyond its limits.
  choose(at, current) {
    Object.assign(this, { at, current });
    const { length } = this.places;
    const { free, beyond } = this.places[at] ?? { free: [], beyond: [] };
    $("solution-place").textContent = length === 0 ? "none" : `${at === null ? "–" : at + 1} of ${length}`;
    for (const id of ["solution-next", "solution-previous"]) $(id).disabled = length === 0 || (length === 1 && at === 0);
    $("solutions").dataset.beyond = beyond.length > 0;
    report($("solution-words"), beyond.length > 0 ? `outside the limits: ${beyond.join(", ")}; the arm stays`
      : this.hit.includes(at) ? "in collision"
      : free.length > 0 && this.differ ? `one of a family: ${free.join(", ")} can move while the tool stays` : "");
    this.draw();
  }

  collide(places) {
    this.hit = places;
    this.choose(this.at, this.current);
  }

  draw() {
    for (const arm of this.arms) arm.remove();
    this.arms = [];
    const drawn = $("solution-ghosts").checked ? this.theta : [];
    for (const [i, theta] of drawn.entries()) {
      if (i === this.current) continue; // the arm itself
      const beyond = this.places[i].beyond.length > 0;
      const { colour, opacity } = beyond || this.hit.includes(i) ? BEYOND : INSIDE;
      const arm = new ArmCopy(this.page.view, colour, i === this.at ? CHOSEN : opacity, i);
      arm.stand(this.page.links(theta));
      this.page.view.node("/solutions").add(arm.group);
      this.arms.push(arm);
    }
    this.page.view.viewer.set_dirty();
  }
}
