// Keys: which of them jog, and for whom they are pressed.

// By places on the board, not letters: Shift or another layout between pressing and letting go cannot leave a key held.
const TURNS = {
  KeyW: [0, 1], KeyS: [0, -1], KeyA: [1, 1], KeyD: [1, -1], KeyR: [2, 1], KeyF: [2, -1],
  KeyQ: [3, 1], KeyE: [3, -1], ArrowUp: [4, -1], ArrowDown: [4, 1], ArrowLeft: [5, 1], ArrowRight: [5, -1],
}; // component of (v, w), sign; a tool that looks along x rises where it turns about y the negative way

// Hold the key in `pushes` if it jogs; whether it does. One that repeats was pressed before this page listened.
export function pressed({ code, repeat }, pushes) {
  if (!(code in TURNS)) return false;
  const [axis, sign] = TURNS[code];
  if (!repeat) pushes.hold(code, { axis, sign });
  return true;
}

// Whether `element` holds a text that is written in it.
export const types = (element) => element?.matches("input:is([type=text], :not([type])), textarea, [contenteditable]") ?? false;
export const bare = ({ repeat, ctrlKey, metaKey, altKey }) => !(repeat || ctrlKey || metaKey || altKey || takesKeys(document.activeElement));
export const takesKeys = (element) => element?.matches("input:not([type=checkbox]), select, textarea, [contenteditable]") ?? false;
