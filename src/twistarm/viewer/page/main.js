// The live page: what the process says is shown, what the person does is asked for.

import { copyTheta } from "./copying.js";
import { Findings } from "./findings.js";
import { Highlight } from "./highlight.js";
import { Jog } from "./jog.js";
import { Link } from "./link.js";
import { Panel } from "./panel.js";
import { View } from "./view.js";

const view = new View(document.getElementById("pane"));
const state = { hello: null, frame: null, drawn: 0, fitted: false };

const panel = new Panel({
  joint: (name, value) => ask({ type: "joint", name, value }),
  pose: (name) => ask({ type: "pose", name }),
  random: () => ask({ type: "random" }),
  copy: () => copyTheta(state.frame.theta),
  visible: (what, visible) => ask({ type: "visible", what, visible }),
  play: () => ask({ type: "play" }),
  pause: () => ask({ type: "pause" }),
  seek: (time) => ask({ type: "seek", time }),
  fit: () => view.fit(),
});

const highlight = new Highlight(view);
const findings = new Findings((node, name) => highlight.point(node, name));

const jog = new Jog({
  jog: (twist, frame) => ask({ type: "jog", twist, frame }),
  stop: () => link.interrupt({ type: "stop" }, { type: "jog" }),
});

function ask(request) {
  panel.showError("");
  link.send(request);
}

const receive = {
  hello(message) {
    Object.assign(state, { hello: message, frame: null, drawn: 0 });
    findings.choose(null);
    view.clear();
    panel.showError("");
    panel.release();
    panel.build(message.arm, message.notes, true);
  },
  frame(message) {
    state.frame = message;
    view.place(message.transforms);
    highlight.follow();
    panel.show(message);
    if (!state.fitted) view.fit();
    state.fitted = true;
  },
  visible(message) {
    for (const layer of ["screws", "frames", "path"]) view.setVisible(layer, message[layer]);
    panel.showVisible(message);
  },
  path(message) {
    view.drawPath(message);
    panel.showPath(message.points.length > 0);
  },
  player: ({ duration }) => panel.showPlayer(duration),
  servo(message) {
    jog.show(message);
    panel.showDriven(message.driven);
  },
  findings: (message) => findings.show(message),
  error: ({ message }) => panel.showError(message),
};

const link = new Link({
  message: (message) => receive[message.type](message),
  object(bytes) {
    view.draw(bytes);
    state.drawn += 1;
    const { objects } = state.hello;
    panel.showStatus(state.drawn < objects ? `${state.drawn} / ${objects}` : "live");
  },
  status(status) {
    panel.showStatus(status);
    if (status === "offline") jog.lose();
  },
  // What was refused goes back to where it stands.
  idle() {
    panel.release();
    if (state.frame) panel.show(state.frame);
  },
});

globalThis.twistarm = { view, panel, findings, highlight, jog, link, state };
