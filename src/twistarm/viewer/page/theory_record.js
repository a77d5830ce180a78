// The panel of the theory on a stand-alone page: the numbers are those of the nearest moment that has some.

import { Theory } from "./theory.js";

export class TheoryRecord {
  // `data`: arm, visible, and theory: axes, times [s], the numbers at each, and those of the arm as it was saved.
  constructor(view, data) {
    this.record = data.theory;
    this.theory = new Theory({
      view,
      state: { hello: data },
      ask: ({ what, visible }) => {
        data.visible[what] = visible;
        this.theory.show(data.visible);
      },
    });
    this.theory.build(data.theory.axes);
    this.theory.show(data.visible);
  }

  placed({ time, aside }) {
    const numbers = aside ? this.record.aside : this.record.numbers[this.nearest(time)];
    if (numbers !== this.theory.numbers) this.theory.take(numbers);
    else this.theory.placed();
  }

  nearest(time) {
    const { times } = this.record;
    const next = times.findIndex((moment) => moment >= time);
    if (next <= 0) return next < 0 ? times.length - 1 : 0;
    return time - times[next - 1] < times[next] - time ? next - 1 : next;
  }
}
