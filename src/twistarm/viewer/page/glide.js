// A way from where the arm stands to another configuration: eased, straight in joint space, as playback.py has it live.

const TIME = 500; // ms

// Whether whoever looks wants things to move by themselves.
export const eases = () => !matchMedia("(prefers-reduced-motion: reduce)").matches;

export class Glide {
  // `place(theta)` is called for every picture until the goal is reached.
  constructor(place) {
    this.place = place;
    this.goal = null;
    this.next = 0;
    this.begun = 0;
  }

  go(start, goal) {
    this.stop();
    if (!eases()) return this.place(goal);
    this.start = start;
    this.goal = goal;
    this.begun = performance.now();
    return this.step();
  }

  stop() {
    cancelAnimationFrame(this.next);
    this.goal = null;
  }

  step() {
    const { start, goal } = this;
    const share = Math.min(1, (performance.now() - this.begun) / TIME);
    const eased = share * share * (3 - 2 * share);
    if (share < 1) this.next = requestAnimationFrame(() => this.step());
    else this.goal = null;
    this.place(share < 1 ? start.map((value, i) => value + eased * (goal[i] - value)) : goal);
  }
}
