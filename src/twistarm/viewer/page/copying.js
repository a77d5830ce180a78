// To the clipboard: the configuration, as a list of Python's in rad and m, or any other text.

import { $, element } from "./element.js";

const WHILE = 4000; // ms for which it is said

export const copyTheta = (theta) => copyText(`[${theta.join(", ")}]`, "theta", "in rad and m");

// `text`, called `name`; `units` in words.
export async function copyText(text, name, units) {
  try {
    // Where the page comes by plain http from another machine there is no clipboard.
    await navigator.clipboard.writeText(text);
    const done = element("span", "", `${name} copied, ${units}`);
    say(done);
    setTimeout(() => done.remove(), WHILE);
  } catch {
    offer(text, name);
  }
}

function offer(text, name) {
  const field = element("input");
  Object.assign(field, { type: "text", readOnly: true, value: text }); // a line: newlines are dropped
  field.setAttribute("aria-label", name);
  say(field, element("span", "", "This browser does not let the page copy: press Ctrl+C (⌘C)"));
  field.select();
  field.addEventListener("blur", () => document.activeElement === field || say());
}

function say(...what) {
  $("copied").replaceChildren(...what);
}
