// The arm of a page that has nobody to ask: its joints are moved here, inside their limits.

import { Kinematics, told } from "./kinematics.js";
import { shown, span } from "./units.js";

const ROUNDING = 1e-6; // rad, m: a value may lie this far beyond a limit, as in admission.py

export class LocalArm {
  // `data`: arm, kinematics, others; `act` holds moved() and refuse(words).
  constructor({ arm, kinematics, others, poses }, act) {
    Object.assign(this, { arm, poses, act, others: { ...others } });
    this.kinematics = new Kinematics(kinematics);
    this.names = arm.joints.map(({ name }) => name);
    this.theta = arm.joints.map(() => 0);
  }

  // The frame with the arm at theta, as the process sends it live.
  frame(theta) {
    this.theta = theta;
    const { others } = this;
    const transforms = this.kinematics.transforms([...theta, ...this.arm.others.map(({ name }) => others[name])]);
    return { theta, others: { ...others }, transforms, tool: told(transforms["/frames/tool"]) };
  }

  joint(name, value) {
    const joint = [...this.arm.joints, ...this.arm.others].find((each) => each.name === name);
    if (outside(joint, value)) {
      const limits = span(joint.range, joint.unit);
      return this.act.refuse(`${name} = ${shown(value, joint.unit)} is outside its limits ${limits}`);
    }
    const place = this.names.indexOf(name);
    if (place < 0) this.others = { ...this.others, [name]: value };
    else this.theta = this.theta.with(place, value);
    return this.act.moved();
  }

  pose(name) {
    this.theta = [...this.poses[name]];
    this.act.moved();
  }

  random() {
    this.theta = this.arm.joints.map(({ range: [lower, upper] }) => lower + Math.random() * (upper - lower));
    this.act.moved();
  }
}

function outside({ limits: [lower, upper] }, value) {
  return value < (lower ?? -Infinity) - ROUNDING || value > (upper ?? Infinity) + ROUNDING;
}
