// Whether the target is met, in a word and a colour, with the reason; the words of its solution are folded.

import { $, element } from "./element.js";
import { tell } from "./words.js";

const REASON = "reason: "; // how a line of the words begins

export class Verdict {
  constructor() {
    this.place = $("target-words");
    this.missed = $("missed"); // the same in short, while another panel is in front
  }

  // While a hand moves the target, it is not read aloud.
  busy(on) {
    for (const place of [this.place, this.missed]) place.setAttribute("aria-busy", on);
  }

  show(message) {
    this.place.dataset.met = message?.met ?? "";
    if (message?.given) tell(this.place, [element("span", "met", message.met ? "✓ met" : "✕ not met"), ` ${inShort(message)}`], message.words.split("\n"));
    else tell(this.place, "");
    this.missed.textContent = message?.met === false ? `✕ not met: ${inShort(message)}` : "";
  }
}

// The reason, where one is given, and what was asked.
function inShort({ words }) {
  const [first, ...rest] = words.split("\n");
  const asked = first.slice(first.indexOf(": ") + 2); // of which arm is no news
  const reason = rest.find((line) => line.startsWith(REASON));
  return reason ? `${reason.slice(REASON.length)} · ${asked}` : asked;
}
