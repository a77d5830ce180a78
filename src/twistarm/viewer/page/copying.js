// The configuration to the clipboard, as a list of Python's in rad and m.

import { element } from "./element.js";

const WHILE = 4000; // ms for which it is said

export async function copyTheta(theta) {
  const list = `[${theta.join(", ")}]`;
  try {
    // Where the page comes by plain http from another machine there is no clipboard.
    await navigator.clipboard.writeText(list);
    const done = element("span", "", "theta copied, in rad and m");
    say(done);
    setTimeout(() => done.remove(), WHILE);
  } catch {
    offer(list);
  }
}

// To be copied by hand.
function offer(list) {
  const field = element("input");
  Object.assign(field, { type: "text", readOnly: true, value: list });
  field.setAttribute("aria-label", "theta");
  say(field, element("span", "", "The browser keeps the clipboard to itself here: press Ctrl+C (⌘C)"));
  field.select();
  field.addEventListener("blur", () => document.activeElement === field || say());
}

function say(...what) {
  document.getElementById("copied").replaceChildren(...what);
}
