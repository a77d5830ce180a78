// The links: which are shown, and how much can be seen through them all.

import { $, element } from "./element.js";
import { writeName } from "./names.js";

const FAINTEST = 0.1;

export class LinkList {
  constructor(view) {
    this.view = view;
    this.nodes = {};
    this.hidden = new Set();
    this.opacity = 1;
    $("opacity").min = FAINTEST;
    $("opacity").addEventListener("input", () => this.fade(Number($("opacity").value)));
    $("all-links").addEventListener("click", () => this.recall({ hidden: [], opacity: 1 }));
    view.onDrawn.push(() => this.apply());
  }

  // `links`: the node of each by its name. One that was hidden stays so on an arm that comes in this one's place.
  hello({ links }) {
    this.nodes = links;
    this.boxes = new Map(Object.keys(links).map((name) => [name, this.box(name)]));
    $("links").replaceChildren(...[...this.boxes].map(([name, box]) => {
      const label = element("label");
      label.append(box, writeName(element("span"), name));
      return label;
    }));
    $("links-part").hidden = this.boxes.size === 0;
    this.apply();
  }

  box(name) {
    const made = Object.assign(element("input"), { type: "checkbox", ariaLabel: name });
    made.addEventListener("change", () => {
      this.hidden[made.checked ? "delete" : "add"](name);
      this.apply();
    });
    return made;
  }

  fade(opacity) {
    this.opacity = opacity;
    this.apply();
  }

  // What another page needs to show the same, and to show what another did.
  remembered() {
    return { hidden: [...this.hidden], opacity: this.opacity };
  }

  recall({ hidden, opacity }) {
    this.hidden = new Set(hidden);
    this.fade(opacity);
  }

  apply() {
    const { viewer } = this.view;
    $("opacity").value = this.opacity;
    for (const [name, path] of Object.entries(this.nodes)) {
      this.boxes.get(name).checked = !this.hidden.has(name);
      viewer.set_property(this.view.split(path), "visible", !this.hidden.has(name));
      this.view.node(path).traverse(({ material }) => material && soften(material, this.opacity));
    }
    viewer.set_dirty();
  }
}

// As drawn, times `opacity`. What is seen through is what lies behind the arm: its own back stays hidden.
export function soften(material, opacity) {
  material.userData.drawn ??= { opacity: material.opacity, transparent: material.transparent };
  const { drawn } = material.userData;
  material.opacity = opacity * drawn.opacity;
  material.transparent = drawn.transparent || opacity < 1;
}
