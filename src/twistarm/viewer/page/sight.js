// The menu of the view: from where the arm is seen, which links, and how exactly.

import { $, $$ } from "./element.js";
import { closable } from "./menu.js";

export class Sight {
  // `go(side)`; `exact(on)` asks for all triangles of the meshes' files, null where nobody can be asked.
  constructor(go, exact) {
    for (const button of $$("#sides button")) {
      button.addEventListener("click", () => go(button.dataset.side));
    }
    $("exact")?.addEventListener("change", ({ target }) => exact(target.checked));
    closable($("sight"));
    this.messages = { scene: (message) => this.show(message) };
  }

  show({ exact, simplified }) {
    $("exact").checked = exact;
    $("exact").parentElement.hidden = !exact && !simplified;
  }
}
