// The name of the link under the pointer, beside it; of one that a finger touches, for a while.

import { element } from "./element.js";
import { THREE } from "./view.js";

const PERIOD = 34; // ms between two looks: a look goes through every triangle near the pointer
const AWHILE = 2000; // ms
const STILL = 8; // px that a finger may slip
const ASIDE = 14; // px

export class LinkNames {
  constructor(view) {
    this.view = view;
    this.links = {};
    this.caster = new THREE.Raycaster();
    this.last = 0;
    this.pressed = null;
    this.waiting = null;
    this.label = Object.assign(element("div"), { id: "link-name", hidden: true });
    document.querySelector("main").append(this.label);
    const pane = view.viewer.dom_element;
    pane.addEventListener("pointermove", (event) => this.move(event));
    pane.addEventListener("pointerdown", (event) => this.press(event));
    pane.addEventListener("pointerup", (event) => this.lift(event));
    pane.addEventListener("pointerleave", () => this.clear());
    pane.addEventListener("wheel", () => this.clear(), { passive: true });
  }

  hello({ links }) {
    this.links = links;
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
    const name = this.at(this.view.onScreen(event));
    this.label.hidden = name === null;
    if (name === null) return;
    this.label.textContent = name;
    const beside = x + ASIDE + this.label.offsetWidth < width ? x + ASIDE : x - ASIDE - this.label.offsetWidth;
    this.label.style.transform = `translate(${Math.max(0, beside)}px, ${Math.max(0, y - ASIDE - this.label.offsetHeight)}px)`;
  }

  // Of the link nearest to the eye there; null where there is none, or a handle of the tool lies before it.
  at(point) {
    const { viewer } = this.view;
    if (viewer.dom_element.style.cursor === "grab") return null;
    this.caster.setFromCamera(point, viewer.camera);
    let nearest = { distance: Infinity, name: null };
    for (const [name, path] of Object.entries(this.links)) {
      const node = this.view.node(path);
      if (!node.visible || !this.view.node("/arm").visible) continue;
      const [hit] = this.caster.intersectObject(node, true);
      if (hit && hit.distance < nearest.distance) nearest = { distance: hit.distance, name };
    }
    return nearest.name;
  }
}
