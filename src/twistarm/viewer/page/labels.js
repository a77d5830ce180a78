// Labels of what is drawn: each joint's name and pitch at the tip of its axis, S and T at the frames.

import { element } from "./element.js";
import { pitchWords } from "./figures.js";
import { cut } from "./names.js";
import { Pins } from "./pins.js";
import { THREE } from "./view.js";

const LONGEST = 20; // letters of a name

export class Labels extends Pins {
  constructor(view) {
    super(view, "labels"); // the same stands in the table of axes
    this.layer.hidden = true;
  }

  build(axes) {
    const joints = axes.joints.map(({ name, node, tip, pitch }) => ({
      layer: "screws", node, at: new THREE.Vector3(...tip), text: joint(name, pitch),
    }));
    const frames = [["S", "/frames/space"], ["T", "/frames/tool"]].map(([name, node]) => ({
      layer: "frames", node, at: new THREE.Vector3(), text: element("span", "frame", name),
    }));
    this.show([...joints, ...frames]);
  }
}

function joint(name, pitch) {
  const made = element("span", "joint-label");
  made.append(element("b", "", cut(name, LONGEST)), ` ${pitchWords(pitch)}`);
  return made;
}
