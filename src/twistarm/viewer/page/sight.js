// The menu of the view: which links are seen, and how exactly.

import { $ } from "./element.js";
import { closable } from "./menu.js";

export class Sight {
  // `exact(on)` asks for all triangles of the meshes' files, null where nobody can be asked.
  constructor(exact) {
    $("exact")?.addEventListener("change", ({ target }) => exact(target.checked));
    closable($("sight"));
    this.messages = { scene: (message) => this.show(message) };
  }

  show({ exact, simplified }) {
    $("exact").checked = exact;
    $("exact").parentElement.hidden = !exact && !simplified;
  }
}
