// Samples of a motion, and its values at any moment between them.

export class Recording {
  // `samples`: times [s], theta and its rates at each.
  constructor({ times, theta, rates }) {
    this.times = times;
    this.duration = times.at(-1);
    const ofJoints = (rows) => rows[0].map((_, joint) => rows.map((each) => each[joint]));
    this.theta = ofJoints(theta);
    this.rates = ofJoints(rates);
  }

  // Theta at `time`, and its rates.
  at(time) {
    const [theta, rates] = [this.theta, this.rates].map((joints) => joints.map((values) => interpolated(this.times, values, time)));
    return { theta, rates };
  }
}

// The value at `time` of one that is `values[k]` at `times[k]`, linear between them.
export function interpolated(times, values, time) {
  if (times.length < 2) return values[0];
  const i = Math.max(0, Math.min(times.findLastIndex((moment) => moment <= time), times.length - 2));
  const share = Math.max(0, Math.min(1, (time - times[i]) / (times[i + 1] - times[i])));
  return values[i] + share * (values[i + 1] - values[i]);
}
