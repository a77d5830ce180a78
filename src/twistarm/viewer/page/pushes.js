// What is held by pointers and keys, as a twist along the chosen axes and as rates of joints.

export class Pushes {
  held = new Map();

  // `push` is {axis, sign} for a component of (v, w), or {joint, sign}.
  hold(by, push) { this.held.set(by, push); }
  lift(by) { this.held.delete(by); }
  clear() { this.held.clear(); }
  has(push) { return [...this.held.values()].includes(push); }

  // Six numbers, the sum of -1 or 1 for each that is held.
  twist() { return this.sum("axis", 6); }

  rates(count) {
    return this.sum("joint", count).map((value) => Math.sign(value));
  }

  sum(what, count) {
    const total = Array(count).fill(0);
    for (const push of this.held.values()) if (what in push) total[push[what]] += push.sign;
    return total;
  }
}
