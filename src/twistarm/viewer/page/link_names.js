// The names of the link under the pointer and of its joint, beside it; of one that a finger touches, for a while.

import { Carriers } from "./carriers.js";
import { element } from "./element.js";
import { THREE } from "./view.js";

const PERIOD = 34; // ms between two looks: a look goes through every triangle near the pointer
const AWHILE = 2000; // ms
const STILL = 8; // px that a finger may slip
const ASIDE = 14; // px

export class LinkNames {
  constructor(view) {
    this.view = view;
    /** @type {any} */
    this.carriers = null;
    this.words = [];
    this.caster = new THREE.Raycaster();
    this.last = 0;
    this.pressed = null;
    this.waiting = 0;
    this.label = Object.assign(element("div"), { id: "link-name", hidden: true });
    view.viewer.dom_element.closest("main").append(this.label);
    const pane = view.viewer.dom_element;
    pane.addEventListener("pointermove", (event) => this.move(event));
    pane.addEventListener("pointerdown", (event) => this.press(event));
    pane.addEventListener("pointerup", (event) => this.lift(event));
    pane.addEventListener("pointerleave", () => this.clear());
    pane.addEventListener("wheel", () => this.clear(), { passive: true });
  }

  hello({ arm, links, kinematics }) {
    this.carriers = new Carriers({ arm, kinematics });
    const names = new Map(Object.entries(links).map(([name, path]) => [path, name]));
    const words = (path) => [names.get(path), this.carriers.of(path)?.joint.name].filter(Boolean).join(" · ");
    const paths = Object.keys(kinematics.nodes).filter((path) => path.startsWith("/arm/")); // rods where there are no links
    this.words = paths.map((path) => [path, words(path)]);
    this.clear();
  }

  // At rest alone: a hand that turns the view or drags the tool has something else in mind.
  move(event) {
    if (event.pointerType === "touch") return;
    if (event.buttons !== 0) return this.clear();
    const wait = this.last + PERIOD - performance.now();
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => this.show(event), Math.max(0, wait));
  }

  press({ clientX, clientY }) {
    this.pressed = { clientX, clientY };
    this.clear();
  }

  lift(event) {
    const { clientX, clientY } = this.pressed ?? { clientX: Infinity, clientY: Infinity };
    const still = Math.hypot(event.clientX - clientX, event.clientY - clientY) < STILL;
    this.pressed = null;
    if (event.pointerType !== "touch" || !still) return;
    this.show(event);
    this.waiting = setTimeout(() => this.clear(), AWHILE);
  }

  clear() {
    clearTimeout(this.waiting);
    this.label.hidden = true;
  }

  show(event) {
    this.last = performance.now();
    const { left, top, width } = this.view.viewer.renderer.domElement.getBoundingClientRect();
    const [x, y] = [event.clientX - left, event.clientY - top];
    const found = this.at(event);
    const { style } = this.view.viewer.dom_element;
    if (style.cursor !== "grab") style.cursor = found && this.carriers.of(found.path) ? "pointer" : "";
    this.label.hidden = found === null;
    if (found === null) return;
    this.label.textContent = found.words;
    const beside = x + ASIDE + this.label.offsetWidth < width ? x + ASIDE : x - ASIDE - this.label.offsetWidth;
    this.label.style.transform = `translate(${Math.max(0, beside)}px, ${Math.max(0, y - ASIDE - this.label.offsetHeight)}px)`;
  }

  // {path, words, point} of the link nearest to the eye there, the point in the world; null where there is none, or a
  // handle of the tool lies before it.
  at(event) {
    const { viewer } = this.view;
    if (viewer.dom_element.style.cursor === "grab") return null;
    this.caster.setFromCamera(this.view.onScreen(event), viewer.camera);
    /** @type {any} */
    let nearest = null;
    for (const [path, words] of this.words) {
      const node = this.view.node(path);
      if (!node.visible || !this.view.node("/arm").visible) continue;
      const [hit] = this.caster.intersectObject(node, true);
      if (hit && !(hit.distance > nearest?.distance)) nearest = { path, words, point: hit.point, distance: hit.distance };
    }
    return nearest;
  }
}
