// The panel Jog: the switch that begins and ends a servo, the axes, the speed and the buttons.

import { $, $$ } from "./element.js";
import { speedWords } from "./jog_line.js";
import { JogPad } from "./jog_pad.js";
import { report } from "./words.js";

const HINT = "Turn on Drive to move a simulated arm with buttons, keys or a gamepad.";
const OTHERS = "A servo of your program drives the arm.";

export class JogPanel {
  // `page` holds jog and ask(request).
  constructor({ jog, ask }) {
    this.jog = jog;
    this.on = false;
    this.driven = false;
    this.note = "";
    this.on_unreachable = "slide";
    this.free = false;
    this.pad = new JogPad(jog, $("jog-pad"), $("jog-joints"));
    this.axes = $$('#jog-axes input[type="radio"]');
    this.choices = $$('#jog-unreachable input[type="radio"]');
    this.messages = {
      drive: (message) => this.showDrive(message),
      servo: ({ driven }) => this.showDrive({ driven }),
    };
    $("drive").addEventListener("change", () => {
      ask({ type: "servo", on: $("drive").checked });
      this.showDrive({}); // it is as the process says
    });
    for (const radio of this.axes) radio.addEventListener("change", () => jog.take(radio.value));
    for (const radio of this.choices) {
      radio.addEventListener("change", () => {
        ask({ type: "on_unreachable", what: radio.value });
        this.showDrive({}); // it is as the process says
      });
    }
    for (const radio of [...this.axes, ...this.choices]) {
      radio.addEventListener("click", (event) => event.detail && radio.blur()); // a mouse's: the keys jog on
    }
    $("slower").addEventListener("click", () => jog.pace(-1));
    $("faster").addEventListener("click", () => jog.pace(1));
    $("radians").addEventListener("change", () => this.show());
    jog.changed = () => this.show();
    this.show();
    this.showDrive({});
  }

  hello({ arm }) {
    this.jog.units = arm.joints.map(({ unit }) => unit);
    this.pad.build(arm.joints);
    this.show();
  }

  // News of `on`, `note`, `driven` and `on_unreachable`. Pages choose the last if no other servo drives, or it is `free`.
  showDrive(news) {
    Object.assign(this, news);
    const others = this.driven && !this.on;
    $("drive").checked = this.on;
    $("drive").disabled = others;
    for (const radio of this.choices) {
      radio.checked = radio.value === this.on_unreachable;
      radio.disabled = others && !this.free;
    }
    $("jog-limits").textContent = { slide: "slide along", stop: "stop" }[this.on_unreachable];
    report($("drive-note"), others ? OTHERS : this.on ? this.note : HINT);
  }

  show() {
    const { jog } = this;
    this.pad.show(jog);
    for (const radio of this.axes) radio.checked = radio.value === jog.frame;
    const { slowest, fastest } = jog.ends;
    $("slower").disabled = slowest;
    $("faster").disabled = fastest;
    const words = speedWords(jog.speeds());
    if ($("jog-pace").textContent !== words) $("jog-pace").textContent = words;
  }

  offline() { this.showDrive({ on: false, driven: false }); }
}
