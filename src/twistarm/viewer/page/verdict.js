// Whether the target is met, in a word and a colour, and the words of its solution, line by line.

import { element } from "./element.js";

export class Verdict {
  constructor() {
    this.place = document.getElementById("target-words");
    this.told = "";
  }

  // While a hand moves the target, it is not read aloud.
  busy(on) {
    this.place.setAttribute("aria-busy", on);
  }

  // `near`: the target is this page's own, and whoever gave it should see why it is not met.
  show(message, near) {
    const words = message?.given ? `${message.met}\n${message.words}` : "";
    if (words === this.told) return;
    this.told = words;
    const missed = message?.met === false && this.place.dataset.met !== "false";
    this.place.dataset.met = message?.met ?? "";
    this.place.replaceChildren(...(words ? lines(message) : []));
    if (missed && near) this.place.scrollIntoView({ block: "nearest" });
  }
}

function lines({ met, words }) {
  const [first, ...rest] = words.split("\n");
  const head = element("p", "first");
  head.append(element("span", "met", met ? "✓ met" : "✕ not met"), " ", first);
  return [head, ...rest.map((line) => element("p", line.startsWith(" ") ? "why" : "", line.trim()))];
}
