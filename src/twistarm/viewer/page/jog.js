// Jogging: what keys, buttons and a gamepad hold is said again and again as a twist, or as rates of joints; when nothing
// is held any more, once to stop.

import { $ } from "./element.js";
import { Gamepad } from "./gamepad.js";
import { AXES, inBase, ofHands } from "./jog_axes.js";
import { JogLine } from "./jog_line.js";
import { pressed, takesKeys } from "./keys.js";
import { Pushes } from "./pushes.js";

const PERIOD = 40; // ms between two messages: some may be late before the process gives up waiting
const FULL = [0.25, 1.0]; // m/s, the reduced speed of ISO 10218-1 at which people stand beside a robot; rad/s
const SHARES = [0.05, 0.1, 0.2, 0.4, 0.7, 1];

export class Jog {
  // `act` holds jog(twist, frame), joints(rates) and stop(); `view` is what view axes are those of.
  constructor(act, view) {
    this.act = act;
    this.view = view;
    this.keys = new Pushes();
    this.gamepad = new Gamepad();
    this.pushes = new Pushes();
    this.line = new JogLine(this);
    this.units = []; // of the joints
    this.accepts = false; // whether the process takes commands
    this.focused = document.hasFocus();
    this.frame = "base";
    this.step = 3; // of SHARES
    this.timer = null; // while something is held
    this.next = 0;
    this.changed = () => {}; // axes, speed or what is held
    this.listen();
  }

  listen() {
    addEventListener("keydown", (event) => this.press(event));
    addEventListener("keyup", (event) => {
      this.keys.lift(event.code);
      this.update();
    });
    // From here on the page would not see a key go up.
    addEventListener("blur", () => this.attend(false));
    addEventListener("focus", () => this.attend(true));
    addEventListener("pagehide", () => this.release());
    addEventListener("contextmenu", (event) => event.defaultPrevented || this.release());
    document.addEventListener("visibilitychange", () => this.release());
    document.addEventListener("focusin", ({ target }) => /** @type {HTMLElement} */ (target).dataset?.push !== undefined || this.release());
    // Whoever turns the view lets go of a slider: the view itself takes no focus.
    $("pane").addEventListener("pointerdown", () => /** @type {HTMLElement} */ (document.activeElement)?.blur());
  }

  show(servo) {
    const begins = servo.jog && !this.accepts;
    this.accepts = servo.jog;
    this.line.hear(servo);
    if (!servo.jog) this.release();
    if (begins) this.poll();
    this.report();
  }

  lose() { this.show({ jog: false, status: null, joint: null, reason: "", share: null }); }

  get ready() {
    return this.accepts && this.focused && !document.hidden && !takesKeys(document.activeElement);
  }

  attend(focused) {
    this.focused = focused;
    this.release();
  }

  release() {
    this.keys.clear();
    this.gamepad.clear();
    this.pushes.clear();
    this.update();
  }

  press(event) {
    if (!this.ready) return;
    if (event.ctrlKey || event.metaKey || event.altKey) return this.release();
    if (!pressed(event, this.keys) && !this.choose(event)) return;
    event.preventDefault();
    this.update();
  }

  choose({ code, key, repeat }) {
    if (code === "KeyT" && !repeat) this.take(AXES[(AXES.indexOf(this.frame) + 1) % AXES.length]);
    else if (key === "+" || key === "=") this.pace(1);
    else if (key === "-") this.pace(-1);
    else return false;
    return true;
  }

  take(frame) {
    this.frame = frame;
    this.report();
  }

  pace(steps) {
    this.step = Math.min(Math.max(this.step + steps, 0), SHARES.length - 1);
    this.report();
  }

  // A button of the page, held by a pointer or a key; see `Pushes`.
  hold(by, push) {
    if (!this.ready) return;
    this.pushes.hold(by, push);
    this.update();
  }

  lift(by) {
    this.pushes.lift(by);
    this.update();
  }

  poll() {
    cancelAnimationFrame(this.next); // one that was left from before a reconnection
    if (!this.accepts) return;
    this.update();
    this.report();
    this.next = requestAnimationFrame(() => this.poll());
  }

  update() {
    const held = [...this.twist(), ...this.rates()].some((value) => value !== 0);
    if (held && this.timer === null) {
      this.timer = setInterval(() => this.repeat(), PERIOD);
      this.say();
    } else if (!held && this.timer !== null) {
      clearInterval(this.timer);
      this.timer = null;
      this.line.spoke(NaN);
      this.act.stop();
    }
    this.changed();
  }

  repeat() {
    this.update();
    if (this.timer !== null) this.say();
  }

  // Joints go before the tool: a servo does one of the two.
  say() {
    this.line.spoke(performance.now());
    const rates = this.rates();
    if (rates.some((rate) => rate !== 0)) this.act.joints(rates);
    else if (this.frame === "view") this.act.jog(inBase(this.twist(), this.view), "base");
    else this.act.jog(this.twist(), this.frame);
  }

  // Along the chosen axes [m/s, rad/s]; no faster across two of them than along one.
  twist() {
    if (!this.ready) return [0, 0, 0, 0, 0, 0];
    const pad = this.gamepad.twist();
    const hands = ofHands(this.keys.twist().map((value, i) => value + pad[i]), this.frame);
    const buttons = this.pushes.twist();
    const sum = hands.map((value, i) => value + buttons[i]);
    const speeds = this.speeds();
    return [sum.slice(0, 3), sum.slice(3)].flatMap((half, i) => {
      const scale = speeds[i] / Math.max(1, Math.hypot(...half));
      return half.map((value) => scale * value);
    });
  }

  // Of every joint, base to tip [rad/s, m/s].
  rates() {
    if (!this.ready) return this.units.map(() => 0);
    const [linear, angular] = this.speeds();
    return this.pushes.rates(this.units.length).map((sign, i) => sign * (this.units[i] === "m" ? linear : angular));
  }

  speeds() {
    return FULL.map((speed) => SHARES[this.step] * speed);
  }

  get ends() { return { slowest: this.step === 0, fastest: this.step === SHARES.length - 1 }; }

  report() {
    this.line.report();
    this.changed();
  }
}
