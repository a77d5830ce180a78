// The moves of an arm with nobody to ask, to be undone and done again; as history.py has them live.

const MOST = 100; // steps
const PAUSE = 1000; // ms between two moves of the same kind from which on they are two: a drag is one

export class LocalHistory {
  constructor() {
    Object.assign(this, { undo: [], redo: [], last: ["", -Infinity] });
  }

  // Before what `words` say is done: where the arm stands.
  note(words, stood) {
    const [last, at] = this.last;
    const now = performance.now();
    if (last !== words || now - at > PAUSE) this.undo = [...this.undo.slice(1 - MOST), { words, stood }];
    Object.assign(this, { redo: [], last: [words, now] });
  }

  // Where the arm goes by "undo" or "redo" from where it stands.
  take(kind, stood) {
    const step = this[kind].pop();
    this[kind === "undo" ? "redo" : "undo"].push({ ...step, stood });
    this.last = ["", -Infinity];
    return step.stood;
  }

  // What each would do; null: nothing.
  get words() {
    return { undo: this.undo.at(-1)?.words ?? null, redo: this.redo.at(-1)?.words ?? null };
  }
}
