// The stand-alone page: an arm and perhaps a motion, with nobody to ask.

import { Findings } from "./findings.js";
import { Highlight } from "./highlight.js";
import { Panel } from "./panel.js";
import { Recording } from "./recording.js";
import { Tabs } from "./tabs.js";
import { View } from "./view.js";

const data = JSON.parse(document.getElementById("data").textContent);
for (const part of document.querySelectorAll("[data-live]")) part.remove(); // there is nobody to ask
const tabs = new Tabs();
const view = new View(document.getElementById("pane"));
const highlight = new Highlight(view);
const findings = new Findings((node, name) => highlight.point(node, name));
const recording = new Recording(data.samples);
const state = { frame: null, time: 0, since: null };

const panel = new Panel({
  visible(what, on) {
    view.setVisible(what, on);
    data.visible[what] = on;
    panel.showVisible(data.visible);
  },
  play: () => run(true),
  pause: () => run(false),
  seek(time) {
    run(false);
    show(time);
  },
  fit: () => view.fit(),
});

function show(time) {
  state.time = time;
  state.frame = { ...recording.at(time), running: state.since !== null };
  view.place(state.frame.transforms);
  highlight.follow();
  panel.show(state.frame);
}

function run(on) {
  if (on && state.time >= recording.duration) state.time = 0;
  state.since = on ? performance.now() - 1000 * state.time : null;
  show(state.time);
  if (on) requestAnimationFrame(tick);
}

function tick() {
  if (state.since === null) return;
  const time = (performance.now() - state.since) / 1000;
  if (time >= recording.duration) {
    state.since = null;
    return show(recording.duration);
  }
  show(time);
  requestAnimationFrame(tick);
}

panel.build(data.arm, data.notes, false);
findings.show(data.findings);
panel.showVisible(data.visible);
panel.showPath(data.path.points.length > 0);
panel.showPlayer(recording.duration > 0 ? recording.duration : null);
for (const object of data.objects) view.draw(Uint8Array.from(atob(object), (letter) => letter.charCodeAt(0)));
view.drawPath(data.path);
show(0);
view.fit();
document.body.dataset.drawn = "";
if (recording.duration > 0) run(true);

globalThis.twistarm = { tabs, view, panel, findings, highlight, state, data };
