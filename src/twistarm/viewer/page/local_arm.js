// The arm of a page that has nobody to ask: its joints are moved here, inside their limits, and moved back.

import { Glide } from "./glide.js";
import { Kinematics, told } from "./kinematics.js";
import { LocalHistory } from "./local_history.js";
import { shown, span } from "./units.js";

const ROUNDING = 1e-6; // rad, m: a value may lie this far beyond a limit, as in arm_data.py

export class LocalArm {
  // `data`: arm, kinematics, others; `act` holds moved() and refuse(words).
  constructor({ arm, kinematics, others, poses }, act) {
    this.arm = arm;
    this.poses = poses;
    this.act = act;
    this.others = { ...others };
    this.kinematics = new Kinematics(kinematics);
    this.names = arm.joints.map(({ name }) => name);
    this.theta = arm.joints.map(() => 0);
    this.history = new LocalHistory();
    this.glide = new Glide((theta) => this.stand(theta));
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
    const { theta, others } = this.stood;
    this.history.note(`move ${name}`, place < 0 ? { others } : { theta });
    if (place < 0) this.others = { ...this.others, [name]: value };
    else this.glide.stop();
    return this.stand(place < 0 ? this.theta : this.theta.with(place, value));
  }

  pose(name) {
    this.go(`go to ${name}`, this.poses[name]);
  }

  random() {
    const anywhere = ({ range: [lower, upper] }) => lower + Math.random() * (upper - lower);
    this.go("go to a random configuration", this.arm.joints.map(anywhere));
  }

  go(words, goal) {
    const { theta } = this.stood;
    if (goal.every((value, i) => value === theta[i])) return;
    this.history.note(words, { theta });
    this.glide.go(this.theta, goal);
  }

  // By "undo" or "redo".
  back(kind) {
    const { theta, others } = this.history.take(kind, this.stood);
    if (others) this.others = others;
    if (theta) this.glide.go(this.theta, theta);
    else this.stand(this.theta);
  }

  // Where it stands, or is about to.
  get stood() {
    return { theta: this.glide.goal ?? this.theta, others: this.others };
  }

  stand(theta) {
    this.theta = theta;
    this.act.moved();
  }
}

function outside({ limits: [lower, upper] }, value) {
  return value < (lower ?? -Infinity) - ROUNDING || value > (upper ?? Infinity) + ROUNDING;
}
