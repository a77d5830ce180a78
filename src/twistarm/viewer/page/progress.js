// How much of the scene is here: a number and a bar in the header, until everything is drawn.

import { $ } from "./element.js";
import { report } from "./words.js";

export class Progress {
  /** @type {{objects: number, left: number, notes: string[]} | null} */ reported;
  drawn = 0;
  bytes = 0;
  complete = false;

  // `whole()` is called once everything is drawn, `say(text)` with what the header says of it until then, null after that.
  constructor(say, whole) {
    this.say = say;
    this.whole = whole;
    this.bar = $("progress");
    this.messages = { scene: (message) => this.learn(message) };
    this.hello();
  }

  hello() {
    this.reported = null;
    this.drawn = 0;
    this.bytes = 0;
    this.complete = false;
  }

  learn(message) {
    this.reported = message;
    report($("notes"), message.notes[0] ?? "", message.notes.slice(1));
    this.show();
  }

  add(bytes) {
    this.drawn += 1;
    this.bytes += bytes;
    this.show();
  }

  // A mesh that is still to be read counts as one object; it may come to several, one for each material.
  show() {
    if (!this.reported || this.complete) return;
    const total = Math.max(this.reported.objects + this.reported.left, this.drawn);
    this.complete = this.reported.left === 0 && this.drawn >= this.reported.objects;
    this.bar.hidden = this.complete;
    this.bar.setAttribute("aria-valuenow", this.drawn);
    this.bar.setAttribute("aria-valuemax", total);
    this.bar.firstElementChild.style.width = `${(100 * this.drawn) / total}%`;
    this.bar.title = `${this.drawn} of ${total} objects, ${(this.bytes / 1e6).toFixed(1)} MB`;
    this.bar.setAttribute("aria-valuetext", this.bar.title);
    this.say(this.complete ? null : `${this.drawn} / ${total}`);
    if (this.complete) this.whole();
  }

  offline() { this.bar.hidden = true; }
}
