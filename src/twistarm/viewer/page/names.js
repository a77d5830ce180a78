// Names where there is little room: whole where they fit, else cut once, in the middle: they differ more often in their ends.

import { element } from "./element.js";

const END = 9; // letters that are always seen
const WHOLE = 12; // letters for which there is room everywhere

// As wide as `root` is; the whole is its title, unless it has another (null: none of its own).
export function writeName(root, name, title = name) {
  const letters = [...name];
  const from = letters.length > WHOLE ? letters.length - END : letters.length;
  const parts = [letters.slice(0, from), letters.slice(from)].filter(({ length }) => length > 0);
  root.classList.add("cut");
  if (title !== null) root.title = title;
  root.replaceChildren(...parts.map((part) => element("span", "", part.join(""))));
  return root;
}

export function cut(name, longest) {
  const letters = [...name];
  if (letters.length <= longest) return name;
  const half = Math.floor(longest / 2);
  return `${letters.slice(0, longest - half).join("")}…${letters.slice(1 - half).join("")}`;
}
