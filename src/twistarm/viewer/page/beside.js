// A second arm to compare with the first, as a ghost in its place or at its side. Its own sliders move it.

import { coloured } from "./arm_copy.js";
import { $ } from "./element.js";
import { corners } from "./framing.js";
import { JointRow } from "./joint_row.js";
import { soften } from "./link_tree.js";
import { LocalArm } from "./local_arm.js";
import { writeName } from "./names.js";
import { signed } from "./units.js";
import { THREE } from "./view.js";

const ROOT = "/beside"; // as in arm_scene.py
const GHOST = 0.4; // opacity
const APART = 1.5; // the bases of the two, in radii of the larger one
const BEHIND = 2; // units of depth: where both arms are, you see the first

export class Beside {
  /** @type {any} the second arm, or null */ arm;
  /** @type {Map<string, any>} its joints that have a name of the first arm's */ shared;

  constructor({ view, panel, state }) {
    this.view = view;
    this.panel = panel;
    this.state = state;
    this.arm = null;
    this.rows = new Map();
    $("beside-apart").addEventListener("change", () => this.dress());
    $("beside-follow").addEventListener("change", () => this.placed(state.frame));
    $("radians").addEventListener("change", () => this.rows.forEach((row) => row.label()));
    view.onDrawn.push(() => this.dress());
  }

  // `beside`: arm, kinematics, theta and others of the second, or null. After a reconnection it stays as it stood.
  hello({ arm, beside }) {
    const told = JSON.stringify([arm, beside]);
    if (told === this.told) return;
    this.told = told;
    this.arm = null;
    this.rows.clear();
    $("beside").hidden = beside === null;
    if (beside !== null) this.build([...arm.joints, ...arm.others], beside);
  }

  build(theirs, beside) {
    this.arm = new LocalArm({ ...beside, poses: {} }, {
      moved: () => this.show(),
      refuse: (words) => {
        this.panel.showError(words);
        this.show();
      },
    });
    this.arm.theta = beside.theta;
    const joints = [...beside.arm.joints, ...beside.arm.others.map((joint) => ({ ...joint, beside: true }))];
    this.shared = new Map(joints.filter(({ name, unit }) => theirs.some((each) => each.name === name && each.unit === unit)).map((joint) => [joint.name, joint]));
    for (const joint of joints) {
      this.rows.set(joint.name, new JointRow(joint, {
        send: (value) => this.arm.joint(joint.name, value),
        complain: (text, box) => this.panel.complain(text, box),
        settle: (box) => this.panel.settle(box),
      }));
    }
    writeName($("beside-name"), beside.arm.name);
    $("beside-joints").replaceChildren(...[...this.rows.values()].map(({ row }) => row));
    $("beside-follow").checked = this.shared.size > 0;
    $("beside-follow").disabled = this.shared.size === 0;
    $("beside-follow").parentElement.title = `${this.shared.size} of ${joints.length} joints have a name of the first arm's, and follow it inside their limits`;
  }

  placed(frame) {
    if (!this.arm || !frame) return;
    const { arm, shared } = this;
    const follows = $("beside-follow").checked;
    for (const [name, row] of this.rows) row.disable(follows && shared.has(name));
    if (follows) {
      const first = { ...frame.others };
      this.panel.names.forEach((name, i) => { first[name] = frame.theta[i]; });
      const taken = (name, own) => (shared.has(name) ? clipped(first[name], shared.get(name)) : own);
      arm.theta = arm.names.map((name, i) => taken(name, arm.theta[i]));
      for (const name in arm.others) arm.others[name] = taken(name, arm.others[name]);
    }
    this.show();
  }

  show() {
    const { theta, others, transforms, tool } = this.arm.frame(this.arm.theta);
    const below = Object.entries(transforms).filter(([path]) => path.startsWith("/arm/"));
    this.view.place(Object.fromEntries(below.map(([path, matrix]) => [ROOT + path, matrix])));
    this.arm.names.forEach((name, i) => this.rows.get(name).show(theta[i]));
    for (const name in others) this.rows.get(name).show(others[name]);
    const { position } = this.state.frame.tool;
    const apart = Math.hypot(...position.map((value, i) => value - tool.position[i]));
    $("beside-tool").textContent = `Tool at ${tool.position.map((value) => signed(value, 3)).join(", ")} m, ${(1000 * apart).toFixed(0)} mm from the first one's`;
  }

  // A ghost where the first one's base is, or as it is drawn, beside the first.
  dress() {
    if (!this.arm) return;
    const apart = $("beside-apart").checked;
    const node = this.view.node(ROOT);
    this.view.rim.give(node);
    node.traverse(({ material }) => {
      if (!material) return;
      soften(material, apart ? 1 : GHOST);
      material.emissive?.copy(apart ? new THREE.Color(0) : coloured("--accent"));
      Object.assign(material, { emissiveIntensity: 0.3, polygonOffset: !apart, polygonOffsetFactor: BEHIND, polygonOffsetUnits: BEHIND });
    });
    this.view.viewer.scene.updateMatrixWorld(true);
    const boxes = ["/arm", ROOT].map((path) => new THREE.Box3().setFromPoints(corners(this.view.node(path))));
    const radius = Math.max(...boxes.map((box) => box.getSize(new THREE.Vector3()).length() / 2));
    this.view.place({ [ROOT]: new THREE.Matrix4().makeTranslation(0, apart ? APART * radius : 0, 0).toArray() });
    this.view.reframe();
  }
}

function clipped(value, { limits: [lower, upper] }) {
  return Math.max(lower ?? -Infinity, Math.min(upper ?? Infinity, value));
}
