// The stand-alone page: an arm and perhaps a motion, with nobody to ask.

import { $ } from "./element.js";
import { Findings } from "./findings.js";
import { Highlight } from "./highlight.js";
import { Panel } from "./panel.js";
import { Playback } from "./playback.js";
import { Player } from "./player.js";
import { Plots } from "./plots.js";
import { Recording } from "./recording.js";
import { Share } from "./share.js";
import { Tabs } from "./tabs.js";
import { TheoryRecord } from "./theory_record.js";
import { View } from "./view.js";

const STANDS = { time: 0, running: false, speed: 1, loop: false };

const data = JSON.parse(document.getElementById("data").textContent);
for (const part of document.querySelectorAll("[data-live]")) part.remove(); // there is nobody to ask
const tabs = new Tabs();
const view = new View(document.getElementById("pane"));
const highlight = new Highlight(view);
const findings = new Findings((node, name) => highlight.point(node, name));
const share = new Share({ view });
const theory = new TheoryRecord(view, data);
const recording = new Recording(data.samples);
const playback = new Playback(recording.duration, data.player ?? STANDS);
const state = { frame: null };
let next; // frame of a running motion

const panel = new Panel({
  visible(what, on) {
    view.setVisible(what, on);
    data.visible[what] = on;
    panel.showVisible(data.visible);
  },
  fit: () => view.fit(),
});

const player = new Player({
  play: () => run(),
  pause() {
    playback.pause();
    show();
  },
  seek,
  pace(speed, loop) {
    Object.assign(playback, { speed, loop });
    showPlayer();
  },
});
const plots = new Plots(seek);

function seek(time) {
  playback.seek(time);
  player.release();
  show();
}

function show(frame = recording.at(playback.time)) {
  state.frame = { ...frame, time: playback.time, running: playback.running };
  view.place(state.frame.transforms);
  highlight.follow();
  panel.show(state.frame);
  player.placed(state.frame);
  plots.placed(state.frame);
  theory.placed(state.frame);
}

function showPlayer() {
  player.show({ ...playback, duration: data.player && recording.duration > 0 ? recording.duration : null });
}

function run() {
  playback.play();
  tick();
}

function tick() {
  cancelAnimationFrame(next); // of a run that was stopped a moment ago
  playback.advance();
  show();
  if (playback.running) next = requestAnimationFrame(tick);
}

// Space plays and pauses, unless it is for a button or a box.
addEventListener("keydown", (event) => {
  if (event.key !== " " || $("player").hidden || document.activeElement !== document.body) return;
  event.preventDefault();
  player.act[playback.running ? "pause" : "play"]();
});

panel.build(data.arm, data.notes, false);
share.hello(data);
findings.show(data.findings);
panel.showVisible(data.visible);
panel.showPath(data.path.points.length > 0);
plots.show(data.plots);
showPlayer();
for (const object of data.objects) view.draw(Uint8Array.from(atob(object), (letter) => letter.charCodeAt(0)));
view.drawPath(data.path);
for (const [layer, on] of Object.entries(data.visible)) view.setVisible(layer, on);
show(data.aside ? { ...new Recording(data.aside).at(0), aside: true } : undefined);
view.fit();
document.body.dataset.drawn = "";
if (playback.running) tick();

globalThis.twistarm = { tabs, view, panel, findings, highlight, share, playback, player, plots, state, data, theory: theory.theory };
