// What is handed on: the stand-alone page, a picture of the view, and a film of the motion.

import { $ } from "./element.js";
import { film } from "./film.js";
import { corners } from "./framing.js";
import { closable } from "./menu.js";
import { stateOf } from "./page_state.js";
import { asBlob, painted } from "./picture.js";
import { fileName, save } from "./saving.js";
import { keep, kept } from "./storage.js";

const SIDES = ["width", "height"];
const SMALLEST = 16; // pixels
const LARGEST = 8192;
const RATE = 30; // frames of a film in a second
const LOOKS = 12; // at the motion, before it is filmed
const PATIENCE = 10000; // ms until a moment of the motion is on show
const KEPT = "twistarm picture"; // width and height as typed, with a comma between them

const STATE = 'id="state">{}'; // where saved_page.py leaves room for it, ahead of all scripts

export class Share {
  // `page` holds the view, seek(time) and keepers().
  constructor(page) {
    this.page = page;
    this.view = page.view;
    this.name = "";
    this.duration = this.time = 0; // of the motion, s
    this.films = this.stopped = false;
    /** @type {any} */
    this.awaited = null; // a moment of the motion
    this.messages = { player: (message) => this.offer(message), error: ({ message }) => this.awaited?.fail(message) };
    const typed = (kept(KEPT) ?? ",").split(",");
    SIDES.forEach((side, i) => {
      $(`picture-${side}`).value = typed[i];
      $(`picture-${side}`).addEventListener("keydown", ({ key }) => key === "Enter" && this.act(() => this.picture()));
    });
    $("save-page").addEventListener("click", () => this.act(() => this.standAlone()));
    $("save-picture").addEventListener("click", () => this.act(() => this.picture()));
    $("save-film").addEventListener("click", () => (this.films ? (this.stopped = true) : this.act(() => this.film())));
    $("share").addEventListener("toggle", () => this.open());
    closable($("share"));
  }

  hello({ arm }) { this.name = arm.name; }

  open() {
    this.say("");
    SIDES.forEach((side, i) => { $(`picture-${side}`).placeholder = this.size()[i]; });
  }

  // Do one thing at a time, and say what came of it.
  async act(make) {
    if (this.busy) return;
    this.busy = true;
    this.say("Saving …");
    await new Promise((resolve) => setTimeout(resolve)); // so that it is read
    try {
      this.say(`Saved: ${await make()}`);
    } catch (error) {
      this.say(error.message, true);
    } finally {
      this.busy = false;
    }
  }

  async standAlone() {
    let answer;
    try {
      answer = await fetch("arm.html");
    } catch {
      throw new Error("twistarm view does not answer. Start it again.");
    }
    if (!answer.ok) throw new Error((await answer.text()).trim());
    const page = await answer.text();
    // A "<" in JSON can only stand in a string; escaped, no name can close the script.
    const state = JSON.stringify(stateOf(this.page.keepers())).replaceAll("<", "\\u003c");
    const whole = page.replace(STATE, () => STATE.slice(0, -2) + state);
    return save(new Blob([whole], { type: "text/html" }), fileName(this.name, ".html"));
  }

  async picture() {
    return save(await asBlob(painted(this.view, ...this.typed())), fileName(this.name, ".png"));
  }

  typed() {
    const typed = SIDES.map((side) => $(`picture-${side}`).value.trim());
    const sides = typed.map((text, i) => pixels(text || String(this.size()[i]), SIDES[i]));
    keep(KEPT, typed.join());
    return sides;
  }

  offer({ duration }) {
    this.duration = duration ?? 0;
    $("save-film").hidden = this.duration === 0;
  }

  async film() {
    const sides = this.typed();
    this.films = this.view.held = true;
    $("save-film").textContent = "Cancel";
    try {
      const blob = await this.record(...sides, RATE, (share) => this.say(`recording: ${Math.round(100 * share)} %`));
      return save(blob, fileName(this.name, ".webm"));
    } finally {
      this.films = this.stopped = this.view.held = false;
      this.view.reframe();
      $("save-film").textContent = "Video (WebM)";
    }
  }

  async record(width, height, rate, report) {
    const { duration } = this;
    const made = await film(this.view, { width, height, rate, duration }, {
      begin: () => this.look(),
      show: (time) => this.reach(time),
      report,
      stopped: () => this.stopped || this.duration !== duration,
    });
    if (made) return made;
    throw new Error(this.stopped ? "Cancelled: nothing is saved." : "The motion was replaced: nothing is saved.");
  }

  // See the arm on its whole way, unless somebody has turned the view.
  async look() {
    const { duration, view } = this;
    await this.reach(this.time > 0 ? 0 : duration); // the arm may be elsewhere, at either time
    const points = [];
    for (let i = 0; i <= LOOKS && !view.turned; i++) {
      await this.reach(duration * (i / LOOKS));
      view.viewer.scene.updateMatrixWorld(true);
      points.push(...corners(view.node("/arm"), true));
    }
    if (points.length > 0) view.fit(points);
  }

  async reach(time) {
    if (this.time === time && this.awaited) return;
    await new Promise((resolve, reject) => {
      this.awaited = { time, resolve, fail: (words) => reject(new Error(words)) };
      setTimeout(reject, PATIENCE, new Error("The motion does not play: nothing is saved."));
      this.page.seek(time);
    });
  }

  update({ time }) {
    this.time = time;
    if (this.awaited?.time === time) this.awaited.resolve();
  }

  // Of the view, in pixels: what an empty box means.
  size() {
    const { offsetWidth, offsetHeight } = $("pane");
    return [offsetWidth, offsetHeight];
  }

  say(text, wrong = false) {
    $("share-note").textContent = text;
    $("share-note").classList.toggle("wrong", wrong);
  }
}

function pixels(text, side) {
  const number = Number(text);
  if (/^\d+$/.test(text) && number >= SMALLEST && number <= LARGEST) return number;
  throw new Error(`Give the ${side} in whole pixels, ${SMALLEST} … ${LARGEST}; got ${text.slice(0, 20)}`);
}
