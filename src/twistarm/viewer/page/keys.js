// The keys that are held, as a twist. A key is where it lies on the board, not its letter: Shift or another layout
// between pressing and letting go cannot leave it held.

const TURNS = {
  KeyW: [0, 1], KeyS: [0, -1], KeyA: [1, 1], KeyD: [1, -1], KeyR: [2, 1], KeyF: [2, -1],
  KeyQ: [3, 1], KeyE: [3, -1], ArrowUp: [4, -1], ArrowDown: [4, 1], ArrowLeft: [5, 1], ArrowRight: [5, -1],
}; // component of (v, w), sign; a tool that looks along x rises where it turns about y the negative way

export class Keys {
  constructor() {
    this.held = new Set();
  }

  // Whether the key means a motion. One that repeats was pressed before this page listened, and starts nothing.
  press({ code, repeat }) {
    if (!(code in TURNS)) return false;
    if (!repeat) this.held.add(code);
    return true;
  }

  lift({ code }) {
    this.held.delete(code);
  }

  clear() {
    this.held.clear();
  }

  // Six numbers, -1, 0 or 1.
  twist() {
    const twist = [0, 0, 0, 0, 0, 0];
    for (const code of this.held) twist[TURNS[code][0]] += TURNS[code][1];
    return twist;
  }
}

// Whether `element` holds a text that is written in it.
export function types(element) {
  return element?.matches("input:is([type=text], :not([type])), textarea, [contenteditable]") ?? false;
}

// Whether a key is pressed alone, anew, and for no field.
export function bare({ repeat, ctrlKey, metaKey, altKey }) {
  return !(repeat || ctrlKey || metaKey || altKey || takesKeys(document.activeElement));
}

// Whether typing is for `element`: a slider or a text field, say.
export function takesKeys(element) {
  return element?.matches("input:not([type=checkbox]), select, textarea, [contenteditable]") ?? false;
}
