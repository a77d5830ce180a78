// Where a motion has the joints at any moment, from samples of it.

export class Recording {
  // `samples`: times [s] and theta at each.
  constructor({ times, theta }) {
    this.times = times;
    this.theta = theta;
    this.duration = times.at(-1);
  }

  // Theta at `time`.
  at(time) {
    const { times, theta } = this;
    const [i, share] = this.between(time);
    return times.length < 2 ? [...theta[0]] : theta[i].map((value, k) => value + share * (theta[i + 1][k] - value));
  }

  // The last sample not after `time`, and how far on it is to the next.
  between(time) {
    const { times } = this;
    let i = times.findLastIndex((moment) => moment <= time);
    i = Math.max(0, Math.min(i, times.length - 2));
    if (times.length < 2) return [0, 0];
    return [i, Math.max(0, Math.min(1, (time - times[i]) / (times[i + 1] - times[i])))];
  }
}
