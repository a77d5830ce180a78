// The panels beside the view, one at a time: by click, or by arrow keys on the row of tabs.

import { $, $$ } from "./element.js";
import { keep, kept } from "./storage.js";

const CHOSEN = "twistarm tab";

export class Tabs {
  constructor() {
    this.tabs = $$('#tabs [role="tab"]');
    for (const tab of this.tabs) tab.addEventListener("click", () => this.choose(tab));
    $("tabs").addEventListener("keydown", (event) => this.press(event));
    this.choose(this.tabs.find(({ id }) => id === kept(CHOSEN, { session: true })) ?? this.tabs[0]);
  }

  choose(chosen) {
    for (const tab of this.tabs) {
      const selected = tab === chosen;
      tab.setAttribute("aria-selected", String(selected));
      tab.tabIndex = selected ? 0 : -1;
      $(tab.getAttribute("aria-controls")).hidden = !selected;
    }
    keep(CHOSEN, chosen.id, { session: true });
    dispatchEvent(new CustomEvent("panel", { detail: chosen.getAttribute("aria-controls") }));
  }

  remembered() {
    return this.tabs.find((tab) => tab.getAttribute("aria-selected") === "true").id;
  }

  recall(id) {
    this.choose(this.tabs.find((tab) => tab.id === id));
  }

  press(event) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const at = this.tabs.findIndex((tab) => tab.getAttribute("aria-selected") === "true");
    const next = this.tabs.at((at + step) % this.tabs.length);
    this.choose(next);
    next.focus();
    event.preventDefault();
    event.stopPropagation(); // arrow keys jog elsewhere
  }
}
