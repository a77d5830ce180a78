// A second arm to compare with the first, as a ghost in its place or at its side. Its own sliders move it.

import { coloured } from "./arm_copy.js";
import { Core } from "./core.js";
import { $ } from "./element.js";
import { corners } from "./framing.js";
import { JointRow } from "./joint_row.js";
import { soften } from "./link_tree.js";
import { writeName } from "./names.js";
import { withUnit, signed, span } from "./units.js";
import { THREE } from "./view.js";

const ROOT = "/beside"; // as in arm_scene.py
const GHOST = 0.4; // opacity
const SPACING = 1.5; // the bases of the two, in radii of the larger one
const ROUNDING = 1e-6; // rad, m: a value may lie this far beyond a limit
const BEHIND = 2; // units of depth: where both arms are, you see the first

export class Beside {
  /** @type {any} of the second arm, or null */ core;
  /** @type {Map<string, any>} its joints that have a name of the first arm's */ shared;

  constructor({ view, panel, state, module }) {
    this.view = view;
    this.panel = panel;
    this.state = state;
    this.module = module;
    this.core = null;
    this.values = {}; // of its joints by name, and of those beside its chain
    this.rows = new Map();
    $("beside-apart").addEventListener("change", () => this.dress());
    $("beside-follow").addEventListener("change", () => this.update(state.frame));
    $("radians").addEventListener("change", () => this.rows.forEach((row) => row.label()));
    view.onDrawn.push(() => this.dress());
  }

  // `beside`: arm, kinematics, theta and others of the second, or null. After a reconnection it stays as it stood.
  hello({ arm, beside }) {
    const reported = JSON.stringify([arm, beside]);
    if (reported === this.reported) return;
    this.reported = reported;
    this.core = null;
    this.rows.clear();
    $("beside").hidden = beside === null;
    if (beside !== null) this.build([...arm.joints, ...arm.others], beside);
  }

  build(theirs, beside) {
    this.core = new Core(this.module, beside);
    this.names = beside.arm.joints.map(({ name }) => name);
    this.values = { ...beside.others };
    this.names.forEach((name, i) => { this.values[name] = beside.theta[i]; });
    const joints = [...beside.arm.joints, ...beside.arm.others.map((joint) => ({ ...joint, beside: true }))];
    this.shared = new Map(joints.filter(({ name, unit }) => theirs.some((other) => other.name === name && other.unit === unit)).map((joint) => [joint.name, joint]));
    for (const joint of joints) this.rows.set(joint.name, new JointRow(joint, this.panel, (value) => this.move(joint, value)));
    writeName($("beside-name"), beside.arm.name);
    $("beside-joints").replaceChildren(...[...this.rows.values()].map(({ row }) => row));
    $("beside-follow").checked = this.shared.size > 0;
    $("beside-follow").disabled = this.shared.size === 0;
    $("beside-follow").parentElement.title = `${this.shared.size} of ${joints.length} joints share a name with the first arm and follow it within their limits`;
  }

  update(frame) {
    if (!this.core || !frame) return;
    const follows = $("beside-follow").checked;
    for (const [name, row] of this.rows) row.disable(follows && this.shared.has(name));
    const first = { ...frame.others };
    this.panel.names.forEach((name, i) => { first[name] = frame.theta[i]; });
    for (const [name, joint] of follows ? this.shared : []) this.values[name] = clipped(first[name], joint);
    this.show();
  }

  move(joint, value) {
    const { name, unit, range } = joint;
    if (Math.abs(value - clipped(value, joint)) <= ROUNDING) this.values[name] = value;
    else this.panel.showError(`${name} = ${withUnit(value, unit)} is outside its limits ${span(range, unit)}`);
    this.show();
  }

  show() {
    const { core, values } = this;
    const { transforms, tool } = core.place(this.names.map((name) => values[name]), values);
    const below = Object.entries(transforms).filter(([path]) => path.startsWith("/arm/"));
    this.view.place(Object.fromEntries(below.map(([path, matrix]) => [ROOT + path, matrix])));
    for (const [name, row] of this.rows) row.show(values[name]);
    const { position } = this.state.frame.tool;
    const distance = Math.hypot(...position.map((value, i) => value - tool.position[i]));
    $("beside-tool").textContent = `Tool at ${tool.position.map((value) => signed(value, 3)).join(", ")} m, ${(1000 * distance).toFixed(0)} mm from the first tool`;
  }

  // A ghost where the first one's base is, or as it is drawn, beside the first.
  dress() {
    if (!this.core) return;
    const sideBySide = $("beside-apart").checked;
    const node = this.view.node(ROOT);
    this.view.rim.give(node);
    node.traverse(({ material }) => {
      if (!material) return;
      soften(material, sideBySide ? 1 : GHOST);
      material.emissive?.copy(sideBySide ? new THREE.Color(0) : coloured("--accent"));
      Object.assign(material, { emissiveIntensity: 0.3, polygonOffset: !sideBySide, polygonOffsetFactor: BEHIND, polygonOffsetUnits: BEHIND });
    });
    this.view.viewer.scene.updateMatrixWorld(true);
    const boxes = ["/arm", ROOT].map((path) => new THREE.Box3().setFromPoints(corners(this.view.node(path))));
    const radius = Math.max(...boxes.map((box) => box.getSize(new THREE.Vector3()).length() / 2));
    this.view.place({ [ROOT]: new THREE.Matrix4().makeTranslation(0, sideBySide ? SPACING * radius : 0, 0).toArray() });
    this.view.reframe();
  }
}

const clipped = (value, { limits: [lower, upper] }) => Math.max(lower ?? -Infinity, Math.min(upper ?? Infinity, value));
