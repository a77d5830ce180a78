// The moves of an arm with nobody to ask, to be undone and done again. A step is what was
// moved, as it was before: `theta`, or the joints beside the arm, `others`.

const MOST = 100; // steps
const PAUSE = 1000; // ms between two moves of the same kind from which on they are two: a drag is one

export class LocalHistory {
  constructor() {
    this.undo = [];
    this.redo = [];
    this.last = { words: "", at: -Infinity };
  }

  // Before what `words` say is done: what it moves.
  note(words, before) {
    const now = performance.now();
    if (words !== this.last.words || now - this.last.at > PAUSE) this.undo = [...this.undo.slice(1 - MOST), { words, before }];
    this.redo = [];
    this.last = { words, at: now };
  }

  // What is put back by "undo" or "redo"; `now`: theta and others as they are.
  take(kind, now) {
    const { words, before } = this[kind].pop();
    const changed = Object.fromEntries(Object.keys(before).map((part) => [part, now[part]]));
    this[kind === "undo" ? "redo" : "undo"].push({ words, before: changed });
    this.last = { words: "", at: -Infinity };
    return before;
  }

  // What each would do; null: nothing.
  get words() {
    return { undo: this.undo.at(-1)?.words ?? null, redo: this.redo.at(-1)?.words ?? null };
  }
}
