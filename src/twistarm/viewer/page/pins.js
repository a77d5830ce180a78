// Text pinned to places of the scene: it stands over the view, and goes along with what it belongs to. Texts avoid each
// other, handles, what else stands over the view, and the edges of the picture.

import { $, element } from "./element.js";
import { occupied } from "./framing.js";

const EDGE = 8; // px
const APART = 1; // px
const PLACES = [0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6]; // heights of the text from where it belongs, on its right and left: the first free one

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

  // `pins`: {layer, node, at, text, whole}: an element at the place `at` of a node, seen with a layer; `whole`: also
  // where its place is out of the picture.
  show(pins) {
    this.pins = pins;
    this.layer.replaceChildren(...pins.map(({ text }) => text));
  }

  follow() {
    if (this.layer.hidden || this.pins.length === 0) return;
    const { camera } = this.view.viewer;
    for (const { layer, node, at, text, whole } of this.pins) {
      const place = at.clone().applyMatrix4(this.view.node(node).matrixWorld);
      const ahead = place.clone().applyMatrix4(camera.matrixWorldInverse).z < -camera.near;
      const { x, y } = place.project(camera);
      text.hidden = !ahead || !this.view.node(`/${layer}`).visible || (!whole && Math.max(Math.abs(x), Math.abs(y)) > 1);
      if (!text.hidden) this.put(text, x, y);
    }
  }

  put(text, x, y) {
    const { offsetWidth: width, offsetHeight: height } = this.layer;
    const { offsetWidth: wide, offsetHeight: high, offsetLeft, offsetTop } = text;
    const { free } = this.view;
    const obstructed = (this.view.obstructed ??= [...occupied(this.layer), ...this.view.gizmos.flatMap((gizmo) => gizmo.square())]);
    const within = (place, size, from, to) => Math.max(from + EDGE, Math.min(place, to - EDGE - size));
    const [right, down] = [0.5 * (x + 1) * width, 0.5 * (1 - y) * height + offsetTop];
    const spots = PLACES.flatMap((place) => [right + offsetLeft, right - offsetLeft - wide].map((left) => ({
      left: within(left, wide, 0, width),
      top: within(down + place * (high + APART), high, free.top * height, (1 - free.bottom) * height),
    })));
    const clear = ({ left, top }) =>
      !obstructed.some((box) => left < box.right && left + wide > box.left && top < box.bottom && top + high > box.top);
    const { left, top } = spots.find(clear) ?? spots[0];
    obstructed.push({ left, top, right: left + wide + APART, bottom: top + high + APART });
    text.style.transform = `translate(${(left - offsetLeft).toFixed(2)}px, ${(top - offsetTop).toFixed(2)}px)`;
  }
}
