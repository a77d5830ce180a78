// Buttons that move the tool or a joint for as long as they are held: by mouse, by touch, or by Space or Enter.

import { element } from "./element.js";
import { writeName } from "./names.js";

const PLAIN = ["x", "y", "z"].flatMap((axis) => [[`−${axis}`, `+${axis}`]]);
const ROUND = ["x", "y", "z"].map((axis) => [`${axis} ↻`, `${axis} ↺`]);
const WORDS = {
  base: [...PLAIN, ...ROUND],
  tool: [...PLAIN, ...ROUND],
  view: [["left", "right"], ["down", "up"], ["away", "nearer"], ["tip down", "tip up"], ["right", "left"], ["↻", "↺"]],
};
const HOLDING = ["Space", "Enter", "NumpadEnter"];

export class JogPad {
  constructor(jog, pad, joints) {
    this.jog = jog;
    this.joints = joints;
    this.buttons = [];
    this.tool = [0, 1, 2].flatMap((row) => [row, row + 3].flatMap((axis) => this.pair({ axis })));
    pad.append(element("h2", "", "Move"), element("h2", "", "Turn"), ...this.tool);
    this.ofJoints = [];
  }

  build(joints) {
    this.ofJoints = joints.flatMap(({ name }, joint) => {
      const pair = this.pair({ joint });
      pair.forEach((button, i) => caption(button, "−+"[i], `${"−+"[i]} ${name}`));
      return pair;
    });
    this.joints.replaceChildren(...joints.flatMap(({ name }, i) =>
      [writeName(element("span", "name"), name), ...this.ofJoints.slice(2 * i, 2 * i + 2)]));
  }

  pair(what) {
    return [-1, 1].map((sign) => {
      const button = element("button");
      button.type = "button";
      button.dataset.push = "";
      this.listen(button, { ...what, sign });
      return button;
    });
  }

  listen(button, push) {
    const { jog } = this;
    button.push = push;
    const by = ({ pointerId }) => `pointer ${pointerId}`;
    button.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      button.setPointerCapture(event.pointerId);
      button.focus({ preventScroll: true }); // whatever is typed in elsewhere gives the keys back
      jog.hold(by(event), push);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      button.addEventListener(end, (event) => jog.lift(by(event)));
    }
    button.addEventListener("contextmenu", (event) => event.preventDefault()); // a long touch
    button.addEventListener("keydown", (event) => {
      if (!HOLDING.includes(event.code)) return;
      event.preventDefault();
      if (!event.repeat && !event.ctrlKey && !event.metaKey && !event.altKey) jog.hold(event.code, push);
    });
    button.addEventListener("keyup", ({ code }) => HOLDING.includes(code) && jog.lift(code));
    button.addEventListener("blur", () => HOLDING.forEach((code) => jog.lift(code)));
  }

  show({ frame, accepts, pushes }) {
    for (const button of [...this.tool, ...this.ofJoints]) {
      button.disabled = !accepts;
      button.title = accepts ? "" : "Turn on Drive first";
      button.classList.toggle("held", pushes.has(button.push));
    }
    if (frame === this.frame) return;
    this.frame = frame;
    for (const button of this.tool) {
      const { axis, sign } = button.push;
      const word = WORDS[frame][axis][(sign + 1) / 2];
      caption(button, word, `${axis < 3 ? "Move" : "Turn"} ${word}, ${frame} axes`);
    }
  }
}

function caption(button, text, label) {
  button.textContent = text;
  button.setAttribute("aria-label", label);
}
