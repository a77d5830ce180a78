// The camera goes where the whole arm is seen from a given side: in a third of a second, over the arm and not through it.

import { DIRECTION, THREE } from "./view.js";

const TIME = 300; // ms
const BESIDE = 1e-3; // straight from above, up on the screen would be undefined

// Towards the camera, in the arm's base axes: x ahead, y to its left, z up.
export const SIDES = {
  front: [1, 0, 0], back: [-1, 0, 0], left: [0, 1, 0], right: [0, -1, 0],
  top: [0, -BESIDE, 1], bottom: [0, -BESIDE, -1], iso: DIRECTION,
};

export class Presets {
  constructor(view) {
    this.view = view;
    this.moving = 0;
    view.viewer.dom_element.addEventListener("pointerdown", () => this.stop(), true);
    view.viewer.dom_element.addEventListener("wheel", () => this.stop(), { capture: true, passive: true });
  }

  go(name) {
    this.stop();
    const { camera, controls } = this.view.viewer;
    const to = this.view.standpoint(SIDES[name]);
    const [begin, end] = [seen(camera.position, controls.target), seen(to.position, to.target)];
    end.theta = begin.theta + nearest(end.theta - begin.theta);
    this.view.turned = true; // by somebody's hand
    this.step({ begin, end, from: controls.target.clone(), to: to.target, begun: performance.now() });
  }

  stop() {
    cancelAnimationFrame(this.moving);
    this.moving = 0;
  }

  step(path) {
    const { camera, controls } = this.view.viewer;
    const { begin, end, from, to, begun } = path;
    const share = Math.min(1, (performance.now() - begun) / TIME);
    const eased = share * share * (3 - 2 * share);
    const mix = (a, b) => a + eased * (b - a);
    const way = new THREE.Spherical(mix(begin.radius, end.radius), mix(begin.phi, end.phi), mix(begin.theta, end.theta));
    controls.target.lerpVectors(from, to, eased);
    camera.position.setFromSpherical(way).add(controls.target);
    controls.update();
    this.view.viewer.set_dirty();
    this.moving = share < 1 ? requestAnimationFrame(() => this.step(path)) : 0;
  }
}

const seen = (position, target) => new THREE.Spherical().setFromVector3(position.clone().sub(target));
const nearest = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
