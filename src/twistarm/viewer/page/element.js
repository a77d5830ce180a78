// What the page is made of, and what it makes of itself.

const GZIP = 0x1f; // its first byte, which begins neither the core nor drawings

/** The element of that id, of whichever kind its tag is. @type {(id: string) => any} */
export const $ = (id) => document.getElementById(id);

/** All elements that match. @type {(selector: string) => any[]} */
export const $$ = (selector) => [...document.querySelectorAll(selector)];

export function element(tag, className, text) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text !== undefined) made.textContent = text;
  return made;
}

export function button(className, text, title, press) {
  const made = Object.assign(element("button", className, text), { type: "button", title });
  made.addEventListener("click", press);
  return made;
}

export const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));

// What is packed in base64, of gzip as a rule.
export async function unzipped(text) {
  const packed = bytes(text);
  if (packed[0] !== GZIP) return packed.buffer;
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

export const styled = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
