// The line of a few words at the bottom of the view: whether keys jog, along which axes, how fast, what the servo says.

import { $ } from "./element.js";
import { withUnit, signed } from "./units.js";

const SLOW = 150; // ms between two words of this page: little more, and a command dies
const LINGER = 2000; // ms for which this is said
const WHOLE = 0.95; // of a command: what is above counts as all of it
const STEADY = 300; // ms for which less must be done before it is said: every motion begins slowly

export class JogLine {
  constructor(jog) {
    this.jog = jog;
    this.servo = null; // the process's last word on it
    this.spoken = this.slowed = this.staled = this.partial = NaN; // ms: the last word, and since when what is amiss
  }

  hear(servo) {
    this.servo = servo;
    this.judge(servo);
    $("jog").hidden = !servo.jog && this.heard() === "";
    $("jog").classList.toggle("accepts", servo.jog);
  }

  judge({ status, share }) {
    const now = performance.now();
    if (status === "STALE") this.staled = now;
    if (share === null || share >= WHOLE) this.partial = NaN;
    else if (Number.isNaN(this.partial)) {
      this.partial = now;
      setTimeout(() => this.report(), STEADY);
    }
  }

  spoke(spoken) {
    const now = performance.now();
    if (now - this.spoken > SLOW) this.slowed = now;
    this.spoken = spoken;
  }

  report() {
    if (!this.servo) return;
    const { ready, accepts, frame, gamepad } = this.jog;
    const words = [ready ? "Jog on" : "Jog off: click the view", `${frame} axes`, speedWords(this.jog.speeds()),
      gamepad.note()];
    write($("jog-line"), accepts ? words.filter(Boolean).join(" · ") : "Servo");
    write($("jog-servo"), this.heard());
    $("jog-servo").dataset.status = this.servo.status ?? "";
    write($("jog-share"), this.done());
  }

  heard() {
    const word = this.servo.status === "OK" && !this.steady ? "OK" : this.servo.reason;
    const late = this.servo.jog && performance.now() - Math.min(this.slowed, this.staled) < LINGER;
    return late ? [word, "this browser is too slow: make the window smaller"].filter(Boolean).join(" · ") : word;
  }

  get steady() { return performance.now() - this.partial >= STEADY; }

  done() {
    const percent = Math.round(100 * this.servo.share);
    return this.steady && percent > 0 ? `${percent} % of the command` : "";
  }
}

export const speedWords = ([linear, angular]) => `${signed(linear, 3)} m/s, ${withUnit(angular, "rad", 0)}/s`;

// Only what is new: the line is read aloud, and laid out anew, each time it is written.
function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
