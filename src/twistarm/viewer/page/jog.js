// Jogging: what keys and gamepad hold is said again and again as a twist; when nothing is held any more, once to stop.

import { Gamepad } from "./gamepad.js";
import { Keys, takesKeys } from "./keys.js";
import { shown, signed } from "./units.js";

const PERIOD = 40; // ms between two messages: some may be late before the process gives up waiting
const FULL = [0.25, 1.0]; // m/s, the reduced speed of ISO 10218-1 at which people stand beside a robot; rad/s
const SHARES = [0.05, 0.1, 0.2, 0.4, 0.7, 1];
const SLOW = 150; // ms between two words of this page: little more, and a command dies
const LINGER = 2000; // ms for which this is said
const WHOLE = 0.95; // of a command: what is above counts as all of it
const STEADY = 300; // ms for which less must be done before it is said: every motion begins slowly

const $ = (id) => document.getElementById(id);

export class Jog {
  // `act` holds jog(twist, frame) and stop().
  constructor(act) {
    this.act = act;
    this.keys = new Keys();
    this.gamepad = new Gamepad();
    this.taken = false; // whether the process takes commands
    this.focused = document.hasFocus();
    this.frame = "base";
    this.step = 3; // of SHARES
    this.timer = null; // while something is held
    this.said = this.slowed = this.staled = this.partial = NaN; // ms: the last word, and since when what is amiss
    this.next = 0;
    this.listen();
  }

  listen() {
    addEventListener("keydown", (event) => this.press(event));
    addEventListener("keyup", (event) => {
      this.keys.lift(event);
      this.update();
    });
    // From here on the page would not see a key go up.
    addEventListener("blur", () => this.attend(false));
    addEventListener("focus", () => this.attend(true));
    addEventListener("pagehide", () => this.release());
    addEventListener("contextmenu", (event) => event.defaultPrevented || this.release());
    document.addEventListener("visibilitychange", () => this.release());
    document.addEventListener("focusin", () => this.release());
    // Whoever turns the view lets go of a slider: the view itself takes no focus.
    $("pane").addEventListener("pointerdown", () => document.activeElement?.blur());
  }

  // What the process says of its servo: whether it takes commands, status, joint, reason.
  show(servo) {
    const begins = servo.jog && !this.taken;
    Object.assign(this, { taken: servo.jog, servo });
    this.judge(servo);
    $("jog").hidden = !servo.jog && this.heard() === "";
    $("jog").classList.toggle("taken", servo.jog);
    if (!servo.jog) this.release();
    if (begins) this.poll();
    this.tell();
  }

  judge({ status, share }) {
    const now = performance.now();
    if (status === "STALE") this.staled = now;
    if (share === null || share >= WHOLE) this.partial = NaN;
    else if (Number.isNaN(this.partial)) {
      this.partial = now;
      setTimeout(() => this.tell(), STEADY);
    }
  }

  // The process is gone.
  lose() {
    this.show({ jog: false, status: null, joint: null, reason: "", share: null });
  }

  get ready() {
    return this.taken && this.focused && !document.hidden && !takesKeys(document.activeElement);
  }

  attend(focused) {
    this.focused = focused;
    this.release();
  }

  // Everything counts as let go, and must be pressed anew.
  release() {
    this.keys.clear();
    this.gamepad.clear();
    this.update();
  }

  press(event) {
    if (!this.ready) return;
    if (event.ctrlKey || event.metaKey || event.altKey) return this.release();
    if (!this.keys.press(event) && !this.choose(event)) return;
    event.preventDefault();
    this.update();
  }

  choose({ code, key, repeat }) {
    if (code === "KeyT" && !repeat) this.frame = this.frame === "tool" ? "base" : "tool";
    else if (key === "+" || key === "=") this.step = Math.min(this.step + 1, SHARES.length - 1);
    else if (key === "-") this.step = Math.max(this.step - 1, 0);
    else return false;
    this.tell();
    return true;
  }

  poll() {
    cancelAnimationFrame(this.next); // one that was left from before a reconnection
    if (!this.taken) return;
    this.update();
    this.tell();
    this.next = requestAnimationFrame(() => this.poll());
  }

  update() {
    const held = this.twist().some((value) => value !== 0);
    if (held && this.timer === null) {
      this.timer = setInterval(() => this.repeat(), PERIOD);
      this.say();
    } else if (!held && this.timer !== null) {
      clearInterval(this.timer);
      this.timer = null;
      this.spoke(NaN);
      this.act.stop();
    }
  }

  repeat() {
    this.update();
    if (this.timer !== null) this.say();
  }

  say() {
    this.spoke(performance.now());
    this.act.jog(this.twist(), this.frame);
  }

  // Whether this page itself let its last word grow old.
  spoke(said) {
    const now = performance.now();
    if (now - this.said > SLOW) this.slowed = now;
    this.said = said;
  }

  // [m/s, rad/s]; no faster across two axes than along one.
  twist() {
    if (!this.ready) return [0, 0, 0, 0, 0, 0];
    const pad = this.gamepad.twist();
    const sum = this.keys.twist().map((value, i) => value + pad[i]);
    const speeds = this.speeds();
    return [sum.slice(0, 3), sum.slice(3)].flatMap((half, i) => {
      const scale = speeds[i] / Math.max(1, Math.hypot(...half));
      return half.map((value) => scale * value);
    });
  }

  speeds() {
    return FULL.map((speed) => SHARES[this.step] * speed);
  }

  // The line of a few words.
  tell() {
    const [linear, angular] = this.speeds();
    const words = [this.ready ? "Jog on" : "Jog off: click the view", `${this.frame} axes`,
      `${signed(linear, 3)} m/s, ${shown(angular, "rad", 0)}/s`, this.gamepad.note()];
    write($("jog-line"), this.taken ? words.filter(Boolean).join(" · ") : "Servo");
    write($("jog-servo"), this.heard());
    $("jog-servo").dataset.status = this.servo.status ?? "";
    write($("jog-share"), this.done());
  }

  heard() {
    const word = this.servo.status === "OK" ? "OK" : this.servo.reason;
    const late = performance.now() - Math.min(this.slowed, this.staled) < LINGER;
    return late ? [word, "this browser is too slow: make the window smaller"].filter(Boolean).join(" · ") : word;
  }

  // How much of the command is done, where it is not all of it.
  done() {
    const steady = performance.now() - this.partial >= STEADY;
    return steady ? `${Math.round(100 * this.servo.share)} % of what was asked` : "";
  }
}

// Only what is new: the line is read aloud, and laid out anew, each time it is written.
function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
