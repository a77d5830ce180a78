// Undo and redo: two buttons, and Ctrl+Z and Ctrl+Shift+Z unless somebody types in a field.

import { $ } from "./element.js";
import { types } from "./keys.js";

const NAMES = { undo: ["Undo", "Ctrl+Z"], redo: ["Redo", "Ctrl+Shift+Z"] };

export class History {
  constructor(ask) {
    this.ask = ask;
    this.words = { undo: null, redo: null };
    this.messages = { history: (message) => this.show(message) };
    for (const kind in NAMES) $(kind).addEventListener("click", () => ask({ type: kind }));
    addEventListener("keydown", (event) => this.press(event));
  }

  show({ undo, redo }) {
    this.words = { undo, redo };
    for (const [kind, [name, keys]] of Object.entries(NAMES)) {
      const words = this.words[kind];
      $(kind).disabled = words === null;
      $(kind).title = words === null ? `Nothing to ${kind}` : `${name}: ${words} (${keys})`;
    }
  }

  press(event) {
    const kind = meant(event);
    if (!kind || types(document.activeElement)) return;
    event.preventDefault();
    if (this.words[kind] !== null) this.ask({ type: kind });
  }
}

function meant({ key, ctrlKey, metaKey, shiftKey, altKey }) {
  if (altKey || !(ctrlKey || metaKey)) return null;
  if (key.toLowerCase() === "z") return shiftKey ? "redo" : "undo";
  return key.toLowerCase() === "y" ? "redo" : null;
}
