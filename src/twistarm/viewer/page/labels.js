// Text over the view: each joint's name and pitch at the tip of its axis, S and T at the frames.

import { $, element } from "./element.js";
import { pitchWords } from "./figures.js";
import { cut } from "./names.js";
import { THREE } from "./view.js";

const LONGEST = 20; // letters of a name
const NEAR = 0.04; // sizes of the arm: labels whose tips are nearer at rest stand below each other
const LINE = 19; // px

export class Labels {
  constructor(view) {
    this.view = view;
    this.layer = element("div");
    this.layer.id = "labels";
    this.layer.setAttribute("aria-hidden", "true"); // the same stands in the table of axes
    this.layer.hidden = true;
    $("pane").append(this.layer);
    this.labels = [];
    const { scene } = view.viewer;
    const before = scene.onAfterRender;
    scene.onAfterRender = (...drawn) => {
      before.apply(scene, drawn);
      this.follow();
    };
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
    this.labels = [...joints, ...frames];
    this.layer.replaceChildren(...this.labels.map(({ text }) => text));
  }

  // With the drawing, whatever moved: the camera or the arm.
  follow() {
    if (this.layer.hidden) return;
    const { camera } = this.view.viewer;
    const { offsetWidth: width, offsetHeight: height } = this.layer;
    for (const { layer, node, at, text, down } of this.labels) {
      const place = at.clone().applyMatrix4(this.view.node(node).matrixWorld);
      const ahead = place.clone().applyMatrix4(camera.matrixWorldInverse).z < -camera.near;
      text.hidden = !ahead || !this.view.node(`/${layer}`).visible;
      if (text.hidden) continue;
      const { x, y } = place.project(camera);
      text.style.transform = `translate(${(0.5 * (x + 1) * width).toFixed(2)}px, ${(0.5 * (1 - y) * height + down).toFixed(2)}px)`;
    }
  }
}

function joint(name, pitch) {
  const made = element("span", "joint-label");
  made.append(element("b", "", cut(name, LONGEST)), ` ${pitchWords(pitch)}`);
  return made;
}
