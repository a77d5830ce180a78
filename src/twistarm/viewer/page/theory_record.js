// The panel of the theory on a stand-alone page: the numbers are those of the nearest moment that has some.

import { $, element } from "./element.js";
import { Theory } from "./theory.js";

const MOVED = "You moved the arm: numbers were saved for where it stood and for its motion alone. The live view has them everywhere.";

export class TheoryRecord {
  // `data`: arm, and theory: axes, times [s], the numbers at each, and those of the arm as it was saved.
  constructor(view, layers, data) {
    this.record = data.theory;
    this.theory = new Theory({
      view,
      state: { hello: data },
      layers,
    });
    this.words = element("p", "", MOVED);
    $("theory-numbers").before(this.words);
    this.theory.build(data.theory.axes);
    if (data.reach) this.theory.reach.draw(data.reach);
    this.theory.switches.boxes.get("reach").hidden = !data.reach; // there is nobody to map it
  }

  // `aside`: the arm stands as it was saved, or where somebody moved it by "hand", for which there are no numbers.
  placed({ time, aside }) {
    const numbers = aside ? { saved: this.record.aside, hand: null }[aside] : this.record.numbers[this.nearest(time)];
    this.words.hidden = numbers !== null;
    $("theory-numbers").hidden = numbers === null;
    if (numbers === null) this.theory.forget();
    else if (numbers !== this.theory.numbers) this.theory.take(numbers);
    this.theory.placed();
  }

  nearest(time) {
    const { times } = this.record;
    const next = times.findIndex((moment) => moment >= time);
    if (next <= 0) return next < 0 ? times.length - 1 : 0;
    return time - times[next - 1] < times[next] - time ? next - 1 : next;
  }
}
