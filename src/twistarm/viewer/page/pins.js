// Text pinned to places of the scene: it stands over the view, and goes along with what it belongs to.

import { $, element } from "./element.js";

const EDGE = 12; // px

export class Pins {
  // `id` of the layer that holds the text; it is for the eye alone, and says nothing that does not stand elsewhere.
  constructor(view, id) {
    this.view = view;
    this.layer = element("div", "pins");
    this.layer.id = id;
    this.layer.setAttribute("aria-hidden", "true");
    $("pane").append(this.layer);
    this.pins = [];
    view.afterRender(() => this.follow());
  }

  // `pins`: {layer, node, at, text, down, whole}: an element `down` px below the place `at` of a node, seen with a layer;
  // `whole`: it stays in the view to be read.
  show(pins) {
    this.pins = pins;
    this.layer.replaceChildren(...pins.map(({ text }) => text));
  }

  // With the drawing, whatever moved: the camera or the arm.
  follow() {
    if (this.layer.hidden) return;
    const { camera } = this.view.viewer;
    const { offsetWidth: width, offsetHeight: height } = this.layer;
    for (const { layer, node, at, text, down, whole } of this.pins) {
      const place = at.clone().applyMatrix4(this.view.node(node).matrixWorld);
      const ahead = place.clone().applyMatrix4(camera.matrixWorldInverse).z < -camera.near;
      text.hidden = !ahead || !this.view.node(`/${layer}`).visible;
      if (text.hidden) continue;
      const { x, y } = place.project(camera);
      const [left, top] = [0.5 * (x + 1) * width, 0.5 * (1 - y) * height + down];
      const most = whole ? width - text.offsetWidth - EDGE : Infinity;
      text.style.transform = `translate(${Math.min(left, most).toFixed(2)}px, ${top.toFixed(2)}px)`;
    }
  }
}
