// Messages of the page have at most two lines. The rest of a long text and its details are in one fold.

import { element } from "./element.js";

const LONGEST = 200; // characters that are not cut
const written = new WeakMap();
const room = new ResizeObserver((heads) => heads.forEach(({ target }) => fit(target)));

// `short` is a text or elements; the lines of `more` are in the fold, and so is what follows two sentences of a long
// text. An empty text empties the place.
export function report(place, text, details = []) {
  const sentences = typeof text === "string" && text.length > LONGEST ? text.split(/(?<=[.;:]) /) : [text];
  const [short, more] = sentences.length > 2 ? [sentences.slice(0, 2).join(" "), [sentences.slice(2).join(" "), ...details]] : [text, details];
  const head = element("span", "short");
  head.append(...[short].flat());
  const reported = [head.textContent, ...more].join("\n");
  if (written.get(place) === reported) return;
  written.set(place, reported);
  const open = place.querySelector("details")?.open ?? false;
  if (!reported) return place.replaceChildren();
  const fold = element("details", more.length > 0 ? "words more" : "words");
  const summary = element("summary");
  summary.append(head);
  fold.append(summary, ...more.map((line) => element("p", line.startsWith(" ") ? "why" : "", line.trim())));
  fold.open = open && more.length > 0;
  fold.addEventListener("toggle", () => fit(head));
  place.replaceChildren(fold);
  fit(head);
  room.observe(head);
}

function fit(head) {
  const fold = head.closest("details");
  if (!fold || fold.open) return;
  const long = fold.classList.contains("more") || head.scrollHeight > head.clientHeight + 1;
  fold.classList.toggle("whole", !long);
  head.parentElement.tabIndex = long ? 0 : -1;
}
