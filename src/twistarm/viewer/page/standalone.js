// The stand-alone page: an arm and perhaps a motion, with nobody to ask.

import { hang, made, stand } from "./collision.js";
import { copyTheta } from "./copying.js";
import { Cube } from "./cube.js";
import { Drawings } from "./drawings.js";
import { $, $$, bytes } from "./element.js";
import { Findings } from "./findings.js";
import { Highlight } from "./highlight.js";
import { History } from "./history.js";
import { Layers } from "./layers.js";
import { LinkDrag } from "./link_drag.js";
import { LinkNames } from "./link_names.js";
import { LinkTree } from "./link_tree.js";
import { LocalArm } from "./local_arm.js";
import { restore } from "./page_state.js";
import { Panel } from "./panel.js";
import { Path } from "./path.js";
import { Playback } from "./playback.js";
import { Player } from "./player.js";
import { Plots } from "./plots.js";
import { Presets } from "./presets.js";
import { Recording } from "./recording.js";
import { Share } from "./share.js";
import { Sight } from "./sight.js";
import { Tabs } from "./tabs.js";
import { Theory } from "./theory.js";
import { View } from "./view.js";

const STANDS = { time: 0, running: false, speed: 1, loop: false };

const data = JSON.parse($("data").textContent);
for (const part of $$("[data-live]")) part.remove(); // there is nobody to ask
const tabs = new Tabs();
const view = new View($("pane"));
const presets = new Presets(view);
const cube = new Cube(view, (side) => presets.go(side));
const sight = new Sight(null);
const links = new LinkTree(view);
const linkNames = new LinkNames(view);
const highlight = new Highlight(view);
const findings = new Findings((node, name) => {
  highlight.point(node, name);
  panel.mark(name);
});
const share = new Share({ view, seek });
const path = new Path({ view, links: (theta) => arm.kinematics.transforms([...theta, ...arm.arm.others.map(({ name }) => arm.others[name])]) });
const layers = new Layers(view, {
  shown(on) {
    panel.showVisible(on);
    theory.layered(on);
    $("show-collision").checked = on.collision;
  },
});
const theory = new Theory({ view, state: { hello: data }, layers });
const recording = new Recording(data.samples);
const playback = new Playback(recording.duration, data.player ?? STANDS);
/** @type {{frame: any}} */
const state = { frame: null };
let aside = data.aside && "saved"; // where the arm stands, if not on its motion: as it was saved, or by hand
let bodies = []; // obstacles, and the shapes that are checked
let next; // frame of a running motion

const arm = new LocalArm(data, {
  moved() {
    aside = "hand";
    playback.pause();
    panel.showError("");
    panel.release();
    show();
  },
  refuse(words) {
    panel.showError(words);
    panel.release();
    panel.show(state.frame);
  },
});
if (data.aside) arm.theta = data.aside;

const panel = new Panel({
  joint: (name, value) => arm.joint(name, value),
  pose: (name) => arm.pose(name),
  random: () => arm.random(),
  copy: () => copyTheta(state.frame.theta),
  visible: (what, on) => layers.show({ [what]: on }),
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
new LinkDrag({ view, panel, findings, names: linkNames, theory });
const history = new History({ undo: () => arm.back("undo"), redo: () => arm.back("redo") });

function seek(time) {
  arm.glide.stop();
  aside = null;
  playback.seek(time);
  player.release();
  show();
}

function show() {
  const at = aside ? { theta: arm.theta, rates: null } : recording.at(playback.time);
  state.frame = { ...arm.frame(at.theta), rates: at.rates, time: playback.time, running: playback.running, aside };
  view.place(state.frame.transforms);
  stand(bodies, state.frame);
  highlight.follow();
  panel.show(state.frame);
  links.placed(state.frame);
  player.placed(state.frame);
  share.placed(state.frame);
  plots.placed(state.frame);
  theory.placed(state.frame);
  history.show(arm.history.words);
}

function showPlayer() {
  const shown = { ...playback, duration: data.player && recording.duration > 0 ? recording.duration : null };
  player.show(shown);
  share.offer(shown);
}

function run() {
  arm.glide.stop();
  aside = null;
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

panel.build({ ...data.arm, poses: Object.keys(data.poses) }, data.notes);
for (const part of [share, links, linkNames]) part.hello(data);
findings.show(data.findings);
panel.showPath(data.path.points.length + data.path.ideal.length > 0);
plots.show(data.plots);
showPlayer();
for (const object of data.objects ?? globalThis.twistarmObjects) view.draw(bytes(object));
path.show(data.path);
const drawings = new Drawings(view);
for (const drawn of data.drawings) drawings.show(drawn);
theory.build(data.axes);
if (data.reach) theory.reach.draw(data.reach);
theory.switches.boxes.get("reach").hidden = !data.reach; // there is nobody to map it
layers.show(data.visible);
show();
view.fit();
const [obstacles, shapes] = [data.obstacles, data.shapes].map((list, faint) => list.map((body) => ({ ...body, mesh: made(body, faint === 1, view.radius) })));
hang(view, obstacles, "/obstacles");
hang(view, shapes, "/collision");
links.take(data.shapes);
bodies = [...obstacles, ...shapes];
const collision = $("show-collision");
collision.parentElement.hidden = shapes.length === 0;
collision.parentElement.title = "The shapes that are checked";
collision.addEventListener("change", () => layers.show({ collision: collision.checked }));
show();
restore({ view, layers, links, tabs, panel, plots, theory }, JSON.parse($("state").textContent));
document.body.dataset.drawn = "";
if (playback.running) tick();

globalThis.twistarm = { presets, cube, sight, links, linkNames, tabs, view, panel, arm, history, findings, highlight, share, playback, player, plots, state, data, theory, obstacles, shapes, drawings };
