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

// Of J: the `count` largest singular values, descending, a unit vector `axes` of each, and the rank. The largest
// component of an axis is positive, the first of equal ones. Equal values have the axes that are nearest to the
// coordinates. The axes of a value 0 begin with the motions that configurations beside this one have: `slopes()` gives
// the derivative of J by each coordinate. As twistarm.Manipulability has them.
export function singularValues(J, count, slopes = () => []) {
  const { values, axes, rows } = decomposed(J);
  const none = NONE * values[0];
  const found = [];
  for (let last = 0; last < count; last += 1) {
    const next = last + 1 < count ? values[last + 1] : 0;
    const equal = axes.slice(found.length, last + 1);
    if (values[last] - next > none) found.push(...nearestAxes(projector(equal, J.length), equal.length));
  }
  const lost = count - found.length;
  if (lost > 0) found.push(...lacking(found, rows.slice(0, found.length), slopes(), J.length).slice(0, lost));
  const kept = values.slice(0, count);
  return { values: kept, axes: found, rank: kept.filter((value) => value > none).length };
}

// Uᵀ J = Σ Vᵀ by rotations of pairs of rows until all are orthogonal (Hestenes 1958), so small values keep their
// digits. axes: the columns of U, all of them. rows: of Σ Vᵀ.
function decomposed(J) {
  const rows = J.map((row) => [...row]);
  const axes = identity(J.length);
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
        for (const each of [rows, axes]) rotate(each[i], each[j], tangent);
      }
    }
  }
  const found = rows.map((row, i) => ({ value: norm(row), row, axis: axes[i] })).sort((one, other) => other.value - one.value);
  return { values: found.map(({ value }) => value), axes: found.map(({ axis }) => axis), rows: found.map(({ row }) => row) };
}

// In place, as it is done a hundred times for every frame.
function rotate(one, other, tangent) {
  const cosine = 1 / Math.hypot(1, tangent);
  for (let k = 0; k < one.length; k += 1) {
    const [a, b] = [one[k], other[k]];
    one[k] = cosine * (a - tangent * b);
    other[k] = cosine * (b + tangent * a);
  }
}

// Unit vectors across `axes`: first those in which `slopes` move the tool by coordinates that now do not (across `rows`).
function lacking(axes, rows, slopes, size) {
  const across = identity(size).map((row, i) => plus(row, projector(axes, size)[i], -1));
  const moved = rows.map((row) => times(row, 1 / norm(row)));
  const free = slopes.map((slope) => slope.map((row) => moved.reduce((left, v) => plus(left, v, -dot(left, v)), row)));
  const { values, axes: all } = decomposed(across.map((weights) => free.flatMap((slope) => combined(weights, slope))));
  const seen = all.filter((_, i) => values[i] > SEEN);
  const beside = projector(seen, size);
  const never = across.map((row, i) => plus(row, beside[i], -1));
  return [...nearestAxes(beside, seen.length), ...nearestAxes(never, size - axes.length - seen.length)];
}

// The sum of `rows`, each times its weight.
export function combined(weights, rows) {
  return rows.slice(1).reduce((sum, row, i) => plus(sum, row, weights[i + 1]), times(rows[0], weights[0]));
}

const identity = (size) => Array.from({ length: size }, (_, i) => Array.from({ length: size }, (__, j) => Number(i === j)));

function projector(axes, size) {
  return identity(size).map((row, i) => row.map((_, j) => axes.reduce((sum, u) => sum + u[i] * u[j], 0)));
}

// Orthonormal vectors in the range of a projector: first the coordinate axis nearest to it, seen in it.
function nearestAxes(projected, count) {
  const found = [];
  for (let left = projected; found.length < count;) {
    const sizes = left.map((row, i) => row[i]);
    const longest = Math.max(...sizes);
    const toward = left[sizes.findIndex((size) => size >= longest - EQUAL)];
    const axis = times(toward, 1 / norm(toward));
    found.push(axis);
    left = left.map((row, i) => plus(row, axis, -axis[i]));
  }
  return found;
}
