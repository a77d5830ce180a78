// Labels of what is drawn: each joint's name and pitch at the tip of its axis, S and T at the frames.

import { element } from "./element.js";
import { pitchWords } from "./figures.js";
import { cut } from "./names.js";
import { Pins } from "./pins.js";
import { THREE } from "./view.js";

const LONGEST = 20; // letters of a name
const NEAR = 0.04; // sizes of the arm: labels whose tips are nearer at rest stand below each other
const LINE = 19; // px

export class Labels extends Pins {
  constructor(view) {
    super(view, "labels"); // the same stands in the table of axes
    this.layer.hidden = true;
  }

  build(axes) {
    const tips = axes.joints.map(({ tip }) => new THREE.Vector3(...tip));
    const joints = axes.joints.map(({ name, node, pitch }, i) => ({
      layer: "screws", node, at: tips[i], text: joint(name, pitch),
      down: LINE * tips.slice(0, i).filter((tip) => tip.distanceTo(tips[i]) < NEAR * axes.size).length,
    }));
    const frames = [["S", "/frames/space"], ["T", "/frames/tool"]].map(([name, node]) => ({
      layer: "frames", node, at: new THREE.Vector3(), text: element("span", "frame", name), down: 0,
    }));
    this.show([...joints, ...frames]);
  }
}

function joint(name, pitch) {
  const made = element("span", "joint-label");
  made.append(element("b", "", cut(name, LONGEST)), ` ${pitchWords(pitch)}`);
  return made;
}
