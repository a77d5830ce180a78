// The menu of the view: from where the arm is seen, which links, and how exactly.

import { $, $$ } from "./element.js";

export class Sight {
  // `go(side)`; `exact(on)` asks for all triangles of the meshes' files, null where nobody can be asked.
  constructor(go, exact) {
    for (const button of $$("#sides button")) {
      button.addEventListener("click", () => go(button.dataset.side));
    }
    $("exact")?.addEventListener("change", ({ target }) => exact(target.checked));
    $("sight").addEventListener("keydown", (event) => this.press(event));
    addEventListener("pointerdown", ({ target }) => $("sight").contains(target) || this.close(), true);
    this.messages = { scene: (message) => this.show(message) };
  }

  close() {
    $("sight").open = false;
  }

  press(event) {
    if (event.key !== "Escape" || !$("sight").open) return;
    this.close();
    $("sight").querySelector("summary").focus();
    event.stopPropagation();
  }

  show({ exact, simplified }) {
    $("exact").checked = exact;
    $("exact").parentElement.hidden = !exact && !simplified;
  }
}
