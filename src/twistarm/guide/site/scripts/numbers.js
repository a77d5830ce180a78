// Vectors, matrices, rotations, and how numbers are written. Scripts of a page that opens from disk cannot be modules:
// what one has for the others is in window.guide.
"use strict";

(() => {
  const RAD = Math.PI / 180;
  const { cos, sin, acos, hypot, abs, max, min } = Math;

  const add = (a, b) => a.map((x, i) => x + b[i]);
  const times = (s, a) => a.map((x) => s * x);
  const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
  const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
  const unit = (a) => times(1 / (hypot(...a) || 1), a);
  const columns = (M) => M[0].map((_, j) => M.map((row) => row[j]));
  const product = (A, B) => A.map((row) => columns(B).map((column) => dot(row, column)));
  const apply = (M, p) => M.map((row) => dot(row, p));

  // Rodrigues' formula for a unit vector w.
  function turned(w, angle) {
    const [x, y, z] = w;
    const K = [[0, -z, y], [z, 0, -x], [-y, x, 0]];
    const KK = product(K, K);
    const one = (i, j) => (i === j ? 1 : 0);
    return K.map((row, i) => row.map((k, j) => one(i, j) + sin(angle) * k + (1 - cos(angle)) * KK[i][j]));
  }

  const AXES = { X: [1, 0, 0], Y: [0, 1, 0], Z: [0, 0, 1] };
  const euler = (order, angles) => [...order].map((axis, i) => turned(AXES[axis], angles[i])).reduce(product);

  // e^{ξ̂θ} of a screw: a turn about the line through q along w, and h θ along it.
  function screwed(w, q, h, angle) {
    const R = turned(w, angle);
    return { R, p: add(add(q, times(-1, apply(R, q))), times(h * angle, w)) };
  }

  const text = (x, digits = 3) => ((x < 0 && Number(x.toFixed(digits)) !== 0 ? "−" : " ") + abs(x).toFixed(digits)).padStart(digits + 3);
  const row = (numbers, digits) => numbers.map((x) => text(x, digits)).join(" ");
  const matrix = (name, M) => M.map((line, i) => `${i === 0 ? name.padEnd(4) : "    "}${row(line)}`).join("\n");

  const UNITY = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const ORIGIN = [0, 0, 0];
  const trace = (R) => R[0][0] + R[1][1] + R[2][2];
  const wrapped = (angle) => angle - 360 * Math.round(angle / 360);
  const angleOf = (R) => acos(max(-1, min(1, (trace(R) - 1) / 2))) / RAD;

  const numbers = { RAD, UNITY, ORIGIN, add, times, dot, cross, unit, columns, product, apply };
  window.guide = { numbers: { ...numbers, turned, euler, screwed, trace, angleOf, wrapped, text, row, matrix } };
})();
