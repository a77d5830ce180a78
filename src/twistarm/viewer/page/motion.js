// A motion as samples, and its values at any moment between them.

// The interval k of `times` that `time` is in, its length, and which part of it has passed.
export function between(times, time) {
  const k = Math.max(0, Math.min(times.findLastIndex((moment) => moment <= time), times.length - 2));
  const h = times[k + 1] - times[k];
  return { k, h, s: Math.max(0, Math.min(1, (time - times[k]) / h)) };
}

export class Motion {
  // times [s], and at each theta and its rates.
  constructor({ times, theta, rates }) {
    this.times = times;
    this.theta = theta;
    this.rates = rates;
    this.duration = times.at(-1);
  }

  // Theta and its rates at `time`: between two samples the cubic that has both of either.
  at(time) {
    const { times, theta, rates } = this;
    if (times.length < 2) return { theta: theta[0], rates: rates[0] };
    const { k, h, s } = between(times, time);
    const joints = theta[k].map((from, i) => {
      const [way, begins, ends] = [theta[k + 1][i] - from, h * rates[k][i], h * rates[k + 1][i]];
      const [bend, twist] = [3 * way - 2 * begins - ends, begins + ends - 2 * way];
      return [from + s * (begins + s * (bend + s * twist)), (begins + s * (2 * bend + 3 * s * twist)) / h];
    });
    return { theta: joints.map(([value]) => value), rates: joints.map(([, rate]) => rate) };
  }
}
