// The menu of the view: which links are seen, and how exactly; in a narrow window, where the bar has one row, the layers.

import { $, $$ } from "./element.js";
import { closable } from "./menu.js";

const NARROW = matchMedia("(max-width: 720px)"); // as in phone.css

export class Sight {
  // `exact(on)` asks for all triangles of the meshes' files.
  constructor(exact) {
    $("exact").addEventListener("change", ({ target }) => exact(target.checked));
    closable($("sight"));
    const layers = $$("#switches > label:not(:has(#drag-tool))");
    const arrange = () => (NARROW.matches ? $("sight-menu").prepend(...layers) : $("sight").before(...layers));
    NARROW.addEventListener("change", arrange);
    arrange();
    this.messages = { scene: (message) => this.show(message) };
  }

  show({ exact, simplified }) {
    $("exact").checked = exact;
    $("exact").parentElement.hidden = !exact && !simplified;
  }
}
