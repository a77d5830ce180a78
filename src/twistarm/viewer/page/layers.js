// The layers of this page, kept for its tab. A program may switch some of them on all pages.

import { keep, kept } from "./storage.js";

const FIRST = { screws: true, frames: true, path: true, collision: false, reach: false };
const DRAWN = ["screws", "frames", "path", "collision"]; // nodes of the scene
const KEPT = "twistarm layers";

export class Layers {
  // `act` holds changed(layers) for each change and need(what) of what the process makes for them.
  constructor(view, act) {
    this.view = view;
    this.act = act;
    this.looked = false;
    this.needed = "";
    this.on = FIRST;
    this.reported = {}; // by the program: [on, how often it has switched it]
    Object.assign(this, JSON.parse(kept(KEPT, { session: true }) ?? "{}"));
    this.messages = { visible: ({ type, ...reported }) => this.take(reported) };
  }

  hello() {
    this.needed = "";
    this.show({});
  }

  take(reported) {
    const anew = Object.entries(reported).filter(([layer, visible]) => String(visible) !== String(this.reported[layer]));
    this.reported = reported;
    this.show(Object.fromEntries(anew.map(([layer, [on]]) => [layer, on])));
  }

  show(changed) {
    this.on = { ...this.on, ...changed };
    keep(KEPT, JSON.stringify({ on: this.on, reported: this.reported }), { session: true });
    for (const layer of DRAWN) this.view.setVisible(layer, Boolean(this.on[layer]));
    this.act.changed(this.on);
    this.ask();
  }

  // `looked`: at collisions, beside what the layers need.
  ask(looked = this.looked) {
    this.looked = looked;
    const { on } = this;
    const needed = { collision: this.looked || on.collision, reach: on.reach };
    if (JSON.stringify(needed) === this.needed) return;
    this.needed = JSON.stringify(needed);
    this.act.need(needed);
  }

  remembered() { return this.on; }
  recall(on) { this.show(on); }
}
