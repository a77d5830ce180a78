// Singular values of a matrix of few rows, with directions by a rule that does not change from frame to frame.

const NONE = 1e-9; // a singular value this small beside the largest is the rounding of 0
const SEEN = 1e-3; // a motion beside a singular configuration grows at least so fast with the distance
const EQUAL = 1e-6; // squares of components of unit vectors that differ by less are equally large
const ROUNDING = 4e-15; // of sums of products
const MOST_SWEEPS = 40;

export const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
export const norm = (a) => Math.sqrt(dot(a, a));
export const times = (a, factor) => a.map((value) => value * factor);
export const plus = (a, b, factor = 1) => a.map((value, i) => value + factor * b[i]);

// The sum of `rows`, each times its weight.
export const combined = (weights, rows) => rows.reduce((sum, row, i) => plus(sum, row, weights[i]), times(rows[0], 0));

// Of J: the `count` largest singular values, descending, a unit vector `axes` of each, and the rank. The largest
// component of an axis is positive, the first of equal ones. Equal values have the axes that are nearest to the
// coordinates. The axes of a value 0 begin with the motions that configurations beside this one have: `slopes()` gives
// the derivative of J by each coordinate. As twistarm.Manipulability has them.
export function singularValues(J, count, slopes = () => []) {
  const parts = decomposed(J);
  const values = parts.slice(0, count).map(({ value }) => value);
  const all = parts.map(({ axis }) => axis);
  const none = NONE * values[0];
  const axes = [];
  values.forEach((value, i) => {
    if (value - (values[i + 1] ?? 0) > none) axes.push(...nearestAxes(all.slice(axes.length, i + 1)));
  });
  const lost = count - axes.length;
  if (lost > 0) axes.push(...lacking(all.slice(axes.length), parts.slice(0, axes.length), slopes()).slice(0, lost));
  return { values, axes, rank: values.filter((value) => value > none).length };
}

// Uᵀ J = Σ Vᵀ by rotations of pairs of rows until all are orthogonal (Hestenes 1958), so small values keep their
// digits. Of each value the axis, a column of U, and the row of Σ Vᵀ; values that must be 0 are there too.
function decomposed(J) {
  const rows = J.map((row) => [...row]);
  const axes = J.map((_, i) => J.map((__, j) => Number(i === j)));
  const nothing = (ROUNDING * norm(J.flat())) ** 2;
  for (let sweep = 0, turned = true; turned && sweep < MOST_SWEEPS; sweep += 1) {
    turned = false;
    for (let i = 1; i < rows.length; i += 1) {
      for (let j = 0; j < i; j += 1) {
        const [a, b, c] = [dot(rows[i], rows[i]), dot(rows[j], rows[j]), dot(rows[i], rows[j])];
        if (Math.abs(c) <= ROUNDING * Math.sqrt(a * b) || Math.min(a, b) <= nothing) continue;
        turned = true;
        const slope = (b - a) / (2 * c);
        const tangent = (slope < 0 ? -1 : 1) / (Math.abs(slope) + Math.hypot(1, slope));
        for (const matrix of [rows, axes]) rotate(matrix[i], matrix[j], tangent);
      }
    }
  }
  return rows.map((row, i) => ({ value: norm(row), row, axis: axes[i] })).sort((a, b) => b.value - a.value);
}

// In place, as it is done a hundred times for every frame.
function rotate(u, v, tangent) {
  const cosine = 1 / Math.hypot(1, tangent);
  for (let k = 0; k < u.length; k += 1) {
    const [a, b] = [u[k], v[k]];
    u[k] = cosine * (a - tangent * b);
    v[k] = cosine * (b + tangent * a);
  }
}

// Axes in the range of `left`: first those in which `slopes` move the tool by coordinates that do not move it now.
function lacking(left, moving, slopes) {
  const moved = moving.map(({ row, value }) => times(row, 1 / value));
  const free = slopes.map((slope) => slope.map((row) => moved.reduce((rest, v) => plus(rest, v, -dot(rest, v)), row)));
  const parts = decomposed(left.map((axis) => free.flatMap((slope) => combined(axis, slope))));
  return [true, false].flatMap((seen) =>
    nearestAxes(parts.filter(({ value }) => value > SEEN === seen).map(({ axis }) => combined(axis, left))));
}

// Of orthonormal vectors others with the same range: first the coordinate axis nearest to it, seen in it.
function nearestAxes(vectors) {
  const found = [];
  let projector = vectors[0]?.map((_, i) => vectors.reduce((sum, u) => plus(sum, u, u[i]), times(vectors[0], 0)));
  while (found.length < vectors.length) {
    const sizes = projector.map((row, i) => row[i]);
    const longest = Math.max(...sizes);
    const toward = projector[sizes.findIndex((size) => size >= longest - EQUAL)];
    const axis = times(toward, 1 / norm(toward));
    found.push(axis);
    projector = projector.map((row, i) => plus(row, axis, -axis[i]));
  }
  return found;
}
