// What the program draws in the scene: Meshcat's objects by node, and text over the view.

import { dispose } from "./disposal.js";
import { bytes, element } from "./element.js";
import { Pins } from "./pins.js";
import { THREE } from "./view.js";

export class Drawings {
  constructor(view) {
    this.view = view;
    this.texts = new Map(); // by node
    this.pins = new Pins(view, "drawn-text");
    this.messages = { drawn: (message) => this.show(message) };
  }

  hello() {
    this.texts.clear();
    this.pins.show([]);
  }

  show({ node, objects, text }) {
    const { viewer } = this.view;
    dispose(this.view.node(node));
    viewer.delete_path(this.view.split(node));
    for (const object of objects) viewer.handle_command_bytearray(bytes(object));
    this.texts.delete(node);
    if (text) this.texts.set(node, { layer: "drawn", node: "/drawn", at: new THREE.Vector3(...text.at), text: element("span", "", text.words) });
    this.pins.show([...this.texts.values()]);
    viewer.set_dirty();
  }
}
