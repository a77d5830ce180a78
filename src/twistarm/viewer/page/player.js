// The player below the view: play, pause, scrub, speed, again and again.

import { $, element } from "./element.js";

export class Player {
  constructor(ask) {
    this.ask = ask;
    this.running = this.driven = false;
    this.time = this.duration = 0; // of the trajectory, s; the scrubber runs from 0 to 1
    this.other = new Option(); // a speed that is none of the list's
    this.pressed = this.sought = false; // the scrubber: under a hand, and ahead of what is on show
    this.messages = { player: (message) => this.show(message), servo: ({ driven }) => this.disable(driven), colliding: ({ band }) => this.mark(band) };
    $("play").addEventListener("click", () => ask({ type: this.running ? "pause" : "play" }));
    this.listen();
    const pace = () => ask({ type: "pace", speed: Number($("speed").value), loop: $("loop").checked });
    for (const id of ["speed", "loop"]) $(id).addEventListener("change", pace);
  }

  listen() {
    $("scrub").addEventListener("pointerdown", () => { this.pressed = true; });
    for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => this.lift());
    $("scrub").addEventListener("input", ({ target }) => this.seek(target));
  }

  seek(scrub) {
    this.sought = true;
    this.ask({ type: "seek", time: Number(scrub.value) * this.duration });
  }

  // A press where the scrubber stands is no input, and holds the motion there all the same.
  lift() {
    if (!this.pressed) return;
    this.pressed = false;
    if (this.running && !this.sought) this.seek($("scrub"));
    this.follow();
  }

  release() {
    this.sought = false;
    this.follow();
  }

  show({ duration, speed, loop }) {
    $("player").hidden = duration === null;
    this.duration = duration ?? 0;
    $("loop").checked = loop;
    this.showSpeed(speed);
    this.report();
  }

  showSpeed(speed) {
    this.other.remove();
    if (![...$("speed").options].some(({ value }) => Number(value) === speed)) {
      Object.assign(this.other, { text: `${speed} ×`, value: speed });
      $("speed").append(this.other);
    }
    $("speed").value = String(speed);
  }

  update({ time, running }) {
    this.time = time;
    this.running = running;
    $("play").disabled = this.driven && !running;
    $("play").textContent = running ? "❚❚" : "▶";
    $("play").setAttribute("aria-label", running ? "Pause" : "Play");
    this.report();
  }

  report() {
    this.follow();
    const text = `${this.time.toFixed(2)} / ${this.duration.toFixed(2)} s`;
    $("time").textContent = text;
    $("scrub").setAttribute("aria-valuetext", text);
  }

  // Where the motion collides, in shares of its duration.
  mark(band) {
    $("scrub").title = band.length > 0 ? "The motion collides where the band is red" : "";
    $("band").replaceChildren(...band.map(([from, to]) => {
      const part = element("span");
      Object.assign(part.style, { left: `${100 * from}%`, width: `${100 * (to - from)}%` });
      return part;
    }));
  }

  offline() { this.pressed = this.sought = false; }

  // A hand on the scrubber is not pulled along.
  follow() {
    if (!this.pressed && !this.sought) $("scrub").value = this.duration > 0 ? this.time / this.duration : 0;
  }

  // A servo drives the arm: what runs may be stopped, and that is all.
  disable(driven) {
    this.driven = driven;
    $("scrub").disabled = driven;
    $("play").disabled = driven && !this.running;
  }
}
