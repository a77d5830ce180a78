// A recorded motion: samples in time, and the moment between two of them.

/* global MeshCat */

export class Recording {
  // `samples`: times [s], theta, tool, and per node seven numbers: position, then quaternion (x, y, z, w).
  constructor(samples) {
    this.samples = samples;
    this.duration = samples.times.at(-1);
  }

  // The frame at `time`, in the form the process sends it live.
  at(time) {
    const { times, theta, tool, nodes } = this.samples;
    const [i, share] = this.between(time);
    const mixed = (rows) => rows[i].map((value, k) => value + share * ((rows[i + 1] ?? rows[i])[k] - value));
    const transforms = {};
    for (const [path, rows] of Object.entries(nodes)) transforms[path] = blended(rows[i], rows[i + 1] ?? rows[i], share);
    // Angles jump at ±π, so the tool's are those of the nearer sample.
    const near = tool[share < 0.5 ? i : i + 1];
    return { theta: mixed(theta), others: this.samples.others, transforms, tool: near, time: Math.min(time, times.at(-1)) };
  }

  // The last sample not after `time`, and how far on it is to the next.
  between(time) {
    const { times } = this.samples;
    let i = times.findLastIndex((moment) => moment <= time);
    i = Math.max(0, Math.min(i, times.length - 2));
    if (times.length < 2) return [0, 0];
    return [i, Math.max(0, Math.min(1, (time - times[i]) / (times[i + 1] - times[i])))];
  }
}

function blended(a, b, share) {
  const { Matrix4, Quaternion, Vector3 } = MeshCat.THREE;
  const position = new Vector3(a[0], a[1], a[2]).lerp(new Vector3(b[0], b[1], b[2]), share);
  const turn = new Quaternion(a[3], a[4], a[5], a[6]).normalize();
  turn.slerp(new Quaternion(b[3], b[4], b[5], b[6]).normalize(), share);
  return new Matrix4().compose(position, turn, new Vector3(1, 1, 1)).toArray();
}
