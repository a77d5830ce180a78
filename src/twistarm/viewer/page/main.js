// The page: what the process says is shown, what the person does is asked for. A saved page has a process inside.
//
// The page is made of parts. Each is given `page` and is a Part: it may have messages {type: function} that it shows,
// hello(message) for an arm that is new to the page, layered(layers) after a layer was switched, update(frame) after the
// arm has moved, offline() when the process has gone.

import { Beside } from "./beside.js";
import { Collision } from "./collision.js";
import { Controls } from "./controls.js";
import { copyTheta } from "./copying.js";
import { Core, loaded } from "./core.js";
import { Cube } from "./cube.js";
import { Drawings } from "./drawings.js";
import { $, $$ } from "./element.js";
import { Findings } from "./findings.js";
import { Ghost } from "./ghost.js";
import { eases } from "./glide.js";
import { Highlight } from "./highlight.js";
import { History } from "./history.js";
import { Jog } from "./jog.js";
import { JogPanel } from "./jog_panel.js";
import { Keeping } from "./keeping.js";
import { Layers } from "./layers.js";
import { Link } from "./link.js";
import { LinkDrag } from "./link_drag.js";
import { LinkNames } from "./link_names.js";
import { LinkTree } from "./link_tree.js";
import { restore } from "./page_state.js";
import { Panel } from "./panel.js";
import { Path } from "./path.js";
import { Player } from "./player.js";
import { Plots } from "./plots.js";
import { Presets } from "./presets.js";
import { Process } from "./process.js";
import { Program } from "./program.js";
import { Progress } from "./progress.js";
import { violation } from "./schema.js";
import { ScenePanel } from "./scene_panel.js";
import { Share } from "./share.js";
import { Sight } from "./sight.js";
import { easeSoftware } from "./software.js";
import { Solutions } from "./solutions.js";
import { Tabs } from "./tabs.js";
import { NONE, Target } from "./target.js";
import { Theory } from "./theory.js";
import { View } from "./view.js";
import { Work } from "./work.js";

const QUIET = ["jog", "jog_joints", "needs"]; // asked again and again, or unseen: an error stays to be read
const SILENCE = "twistarm view has ended or does not answer. The panel works again when it answers.";
const STRANGER = "twistarm view was started again. Open the address that it printed.";
const LACKING = "This browser cannot run the page, which needs WebAssembly and DecompressionStream. Open it with Firefox 121, Chrome or Edge 115, Safari 16.4, or a later one.";

const saved = $("data") && JSON.parse($("data").textContent); // where this is a saved page
const described = globalThis.twistarmSchema ?? fetch("schema.json").then((file) => file.json());
const [schema, module] = await Promise.all([described, loaded().catch(unsupported)]);
const view = new View($("pane"));
easeSoftware(view);
/** @type {{hello: any, frame: any, fitted: boolean}} */
const state = { hello: null, frame: null, fitted: false };
const latest = {}; // the last message of each type
let silence = SILENCE; // why nothing can be asked
let refusal = ""; // of a motion, while the mark stands where it stops
/** @type {any} */
let ahead = null; // of a frame, what the page has asked for: it stays until the process has answered

const seek = (time) => ask({ type: "seek", time });
const panel = new Panel({
  joint: moveJoint,
  pose: (name) => ask({ type: "pose", name, ease: eases() }),
  random: () => ask({ type: "random", ease: eases() }),
  copy: () => copyTheta(state.frame.theta),
  visible: (what, on) => layers.show({ [what]: on }),
  fit: () => view.fit(),
});

const presets = new Presets(view);
const cube = new Cube(view, (side) => presets.go(side));
const highlight = new Highlight(view);
const findings = new Findings((node, name) => {
  highlight.point(node, name);
  panel.mark(name);
});

const jog = new Jog({
  jog: (twist, frame) => ask({ type: "jog", twist, frame }),
  joints: (rates) => ask({ type: "jog_joints", rates }),
  stop: () => link.interrupt({ type: "stop" }, { type: "jog" }, { type: "jog_joints" }),
}, view);

const layers = new Layers(view, {
  changed(on) {
    panel.showVisible(on);
    for (const part of allParts()) part.layered?.(on);
  },
  need: (what) => ask({ type: "needs", ...what }),
});

const keepers = () => ({ ...parts, view, panel }); // of how the page stands
const links = (theta) => (state.frame ? page.core.links(theta, state.frame.others) : {}); // where they would stand
/** @type {any} */
const page = { view, panel, jog, layers, state, module, core: null, links, ask, move, seek, keepers };
const collision = new Collision(page);
const parts = {
  tabs: new Tabs(),
  sight: new Sight((on) => ask({ type: "exact", on })),
  links: new LinkTree(view, (on) => layers.ask(on)),
  linkNames: new LinkNames(view),
  beside: new Beside(page),
  jogging: new JogPanel(page),
  target: new Target(page),
  solutions: new Solutions(page, () => parts.target.current()),
  ghost: new Ghost(page),
  path: new Path(page),
  program: new Program(page),
  keeping: new Keeping(page),
  player: new Player(ask),
  history: new History(ask),
  plots: new Plots(seek),
  theory: new Theory(page),
  collision,
  scene: new ScenePanel(page, collision),
  controls: new Controls(ask),
  drawings: new Drawings(view),
  share: new Share(page),
  work: new Work(),
  progress: new Progress((text) => panel.showStatus(text ?? link.kind), look),
};
Object.assign(parts, { drag: new LinkDrag({ view, panel, findings, names: parts.linkNames, theory: parts.theory }), layers });

/**
 * @typedef {object} Part
 * @property {Object<string, (message: any) => void>} [messages]
 * @property {(message: any) => void} [hello]
 * @property {(layers: any) => void} [layered]
 * @property {(frame: any) => void} [update]
 * @property {() => void} [offline]
 */

/** @returns {Part[]} */
function allParts() {
  return /** @type {any[]} */ (Object.values(parts));
}

// Bring the arm into view with the first frame, and again once all of it is drawn, unless somebody has turned it since.
function look() {
  if (state.fitted || !state.frame) return;
  if (view.radius === undefined || (parts.progress.complete && !view.turned)) view.fit();
  state.fitted = parts.progress.complete;
}

// Without the compiled core there are no poses.
function unsupported(error) {
  Object.assign($("error"), { hidden: false, textContent: `${LACKING} (${error.message})` });
  throw error;
}

function ask(request) {
  const wrong = violation(schema.requests, request);
  if (wrong || !QUIET.includes(request.type)) panel.showError(wrong);
  if (wrong) return false;
  const sent = link.send(request);
  if (!sent) takeBack();
  return sent;
}

// Show at once what was asked for: theta or others, and the target that the arm is moved to.
function move(to, target) {
  ahead = { ...ahead, ...to, ...(to.theta && { running: false, rates: null }) };
  if (target) report({ type: "target", ...target });
  report({ ...state.frame, ...ahead });
}

// A value beyond a limit is left to the process, which refuses it with the reason.
function moveJoint(name, value) {
  const [lower, upper] = panel.rows.get(name).joint.limits;
  const inside = value >= (lower ?? -Infinity) && value <= (upper ?? Infinity);
  if (!ask({ type: "joint", name, value }) || !inside || !state.frame) return;
  const i = panel.names.indexOf(name);
  const { theta, others } = state.frame;
  if (i < 0) move({ others: { ...others, [name]: value } });
  else move({ theta: theta.with(i, value) }, NONE);
}

// Nobody was asked: all stands as the process left it.
function takeBack() {
  show({ type: "error", message: silence });
  putBack();
  for (const type of ["player", "program"]) if (latest[type]) show(latest[type]);
}

// What was refused goes back to where it stands.
function putBack() {
  panel.release();
  parts.controls.release();
  if (!state.frame) return;
  if (ahead) {
    ahead = null;
    for (const type of ["target", "frame"]) report(latest[type]);
  }
  parts.scene.release();
  panel.show(state.frame);
  parts.player.release();
}

const receive = {
  hello(message) {
    Object.assign(state, { hello: message, frame: null });
    page.core = saved ? link.core : new Core(module, message);
    ahead = null;
    findings.choose(null);
    view.clear();
    panel.showError("");
    panel.release();
    panel.build(message.arm, []);
    for (const part of allParts()) part.hello?.(message);
  },
  frame(message) {
    const frame = { ...message, ...page.core.place(message.theta, message.others) };
    const first = state.frame === null;
    state.frame = frame;
    view.place(frame.transforms);
    highlight.follow();
    panel.show(frame);
    look();
    for (const part of allParts()) part.update?.(frame);
    if (first) for (const act of view.onDrawn) act(); // copies of the arm stand beside it
  },
  path({ points, ideal, stopped }) {
    panel.showPath(points.length + ideal.length > 0);
    if (stopped === null && $("error").textContent === refusal) panel.showError(""); // its cause is gone
    refusal = stopped === null ? "" : latest.error?.message ?? "";
  },
  servo(message) {
    jog.show(message);
    panel.showDriven(message.driven);
  },
  findings: (message) => findings.show(message),
  error: ({ message }) => panel.showError(message),
};

// A message of another version of the process is told, not drawn.
function show(message) {
  const wrong = violation(schema.messages, message);
  if (wrong) return panel.showError(`This page and twistarm differ in version: ${wrong}. Reload the page.`);
  latest[message.type] = message;
  if (message.type === "frame") report({ ...message, ...ahead });
  else if (message.type !== "target" || !ahead?.theta) report(message);
}

function report(message) {
  receive[message.type]?.(message);
  for (const part of allParts()) part.messages?.[message.type]?.(message);
}

const on = {
  message: show,
  object(bytes) {
    view.draw(bytes);
    parts.progress.add(bytes.length);
  },
  status(status) {
    const gone = status === "offline";
    panel.showStatus(status);
    for (const area of $$("#panel > :not(header, #reports), #verdict")) area.inert = gone;
    if (!gone) silence = SILENCE;
    panel.showError(gone ? silence : "");
    if (!gone) return;
    if (ahead) putBack();
    jog.lose();
    for (const part of allParts()) part.offline?.();
  },
  idle: putBack,
  refused() {
    silence = STRANGER;
    panel.showError(STRANGER);
  },
};
/** @type {any} */
const link = saved ? new Process(saved, new Core(module, saved.hello), on) : new Link(on);
if (saved) {
  await link.begin();
  restore(keepers(), link.remembered(JSON.parse($("state").textContent)));
  document.body.dataset.drawn = "";
}

globalThis.twistarm = { presets, cube, view, panel, collision, findings, highlight, jog, link, state, parts };
