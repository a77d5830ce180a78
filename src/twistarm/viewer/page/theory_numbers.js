// The numbers of the theory where the arm stands: Jacobians, screws, singular values and ellipsoids.

import { combined, dot, norm, plus, singularValues, times } from "./singular_values.js";

const TOOL = "/frames/tool";
const TURNLESS = 1e-12; // rad/m: a twist that turns less is a translation, the rest is the rounding of several joints
const ALONG = 0.995; // cosine from which on a direction has the name of an axis
const SLIGHT = 0.05; // a part of a unit direction below this is not mentioned

// In SI units and radians; matrices are lists of rows. g (4, 4): g_st. spatial, body, hybrid (6, n): the Jacobians.
// columns: of the spatial Jacobian as screws; axes: of each moving joint. singular_values, condition (null: infinite),
// rank, yoshikawa, smallest, standing (in words): of the body Jacobian with metres divided by the reach (MLS §3.4.4).
// linear, angular: the ellipsoids {J θ̇ : ‖θ̇‖ ≤ 1 rad/s} in base axes, where a slide counts the reach per second (Yoshikawa
// 1985). motion: Vˢ = Jˢ θ̇ for the frame's rates as twist and screw, and the tool origin's velocity; null at rest.
export function numbers({ arm, kinematics }, { joints, length, below }, { transforms, rates }) {
  const [x, y, z, p] = parts(transforms[TOOL]);
  const toTool = (xi) => halves(xi).flatMap((half) => [x, y, z].map((axis) => dot(axis, half)));
  const atTool = (xi) => plus(xi, [...cross(xi.slice(3), p), 0, 0, 0]);
  const moving = joints.map(({ node }) => {
    const { screw, terms } = kinematics.joints[kinematics.nodes[node].joint];
    return { twist: carried(transforms[node], screw), terms };
  });
  const spatial = arm.joints.map(() => new Array(6).fill(0));
  for (const { twist, terms } of moving) for (const [i, factor] of terms) spatial[i] = plus(spatial[i], twist, factor);
  const hybrid = spatial.map(atTool);
  const body = hybrid.map(toTool);
  const radian = arm.joints.map(({ unit }) => (unit === "m" ? length : 1)); // a coordinate's rate that counts 1 rad/s
  const scaled = (xi, i) => xi.map((value, k) => (value * radian[i]) / (k < 3 ? length : 1));

  // The derivatives of J^b: of joint j before l, ∂b_j/∂q_l = [b_j, b_l].
  function slopes() {
    const bodies = moving.map(({ twist }) => halves(toTool(atTool(twist))));
    const all = body.map(() => body.map(() => new Array(6).fill(0)));
    moving.forEach((joint, j) => moving.slice(j + 1).forEach((other, l) => {
      const change = bracket(bodies[j], bodies[j + 1 + l]);
      for (const [i, c] of joint.terms) for (const [k, d] of other.terms) all[k][i] = plus(all[k][i], change, c * d);
    }));
    return all.map((columns, k) => rows(columns.map((xi, i) => times(scaled(xi, i), radian[k]))));
  }

  const found = singularValues(rows(body.map(scaled)), Math.min(6, body.length), slopes);
  const { values, rank } = found;
  const twist = rates?.some(Boolean) ? combined(rates, spatial) : null;
  const [linear, angular] = [0, 3].map((half) => {
    const part = singularValues(rows(hybrid.map((xi, i) => times(xi, radian[i]))).slice(half, half + 3), 3);
    return { semi_axes: part.values, directions: rows(part.axes, 3) };
  });
  return {
    g: [...rows([x, y, z, p], 3), [0, 0, 0, 1]], spatial: rows(spatial), body: rows(body), hybrid: rows(hybrid),
    columns: spatial.map(toScrew), axes: moving.map((joint) => toScrew(joint.twist)),
    singular_values: values, rank, condition: rank === values.length ? values[0] / values.at(-1) : null,
    yoshikawa: values.reduce((product, value) => product * value, 1), smallest: values.at(-1), below,
    rank_words: inWords(found, below), linear, angular,
    motion: twist && { twist, screw: toScrew(twist), velocity: combined(rates, hybrid).slice(0, 3) },
  };
}

// Axis, point nearest to the origin [m], pitch [m/rad] and magnitude of a twist. A translation has the pitch null, which
// is infinite, and goes through the origin. MLS §2.3.3.
function toScrew(xi) {
  const [v, w] = halves(xi);
  const [speed, rate] = [norm(v), norm(w)];
  if (rate <= TURNLESS * speed) return { axis: times(v, 1 / (speed || 1)), point: [0, 0, 0], pitch: null, magnitude: speed };
  const [axis, slide] = [times(w, 1 / rate), times(v, 1 / rate)];
  return { axis, point: cross(axis, slide), pitch: dot(axis, slide), magnitude: rate };
}

// Ad_g ξ, g by columns.
function carried(g, xi) {
  const [x, y, z, p] = parts(g);
  const [v, w] = halves(xi).map((half) => combined(half, [x, y, z]));
  return [...plus(v, cross(p, w)), ...w];
}

const bracket = ([va, wa], [vb, wb]) => [...plus(cross(wa, vb), cross(wb, va), -1), ...cross(wa, wb)];
const parts = (g) => [0, 4, 8, 12].map((first) => g.slice(first, first + 3)); // the axes and the origin
const halves = (xi) => [xi.slice(0, 3), xi.slice(3)];
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const rows = (columns, count = 6) => Array.from({ length: count }, (_, r) => columns.map((column) => column[r]));

// The rank, and the directions, in tool axes, of singular values under `below`.
function inWords({ values, axes, rank }, below) {
  const weak = axes.filter((_, i) => values[i] < below).map(directionInWords);
  const hard = weak.slice(0, Math.max(0, weak.length - (values.length - rank)));
  const lost = weak.slice(hard.length);
  let words = `Rank ${rank} of ${values.length}`;
  if (lost.length > 0) words += `, singular: the tool cannot ${lost.join(", nor ")}`;
  if (hard.length > 0) words += `${lost.length > 0 ? "; it" : ", nearly singular: the tool"} can hardly ${hard.join(", nor ")}`;
  return `${words}.`;
}

// A tool twist of length 1, metres in the reach.
function directionInWords(xi) {
  const [v, w] = halves(xi);
  const [along, about] = [v, w].map((half) => axisInWords(times(half, 1 / Math.max(norm(half), SLIGHT))));
  if (norm(w) < SLIGHT) return `move along ${along}`;
  return norm(v) < SLIGHT ? `turn about ${about}` : `move along ${along} while it turns about ${about}`;
}

function axisInWords(axis) {
  const sizes = axis.map(Math.abs);
  const largest = sizes.indexOf(Math.max(...sizes));
  if (sizes[largest] >= ALONG) return `its ${"xyz"[largest]} axis`;
  const first = sizes.findIndex((size) => size >= sizes[largest] - 1e-6);
  const text = axis.map((value) => (value * Math.sign(axis[first])).toFixed(2).replace(/^-0\.00$/, "0.00"));
  return `(${text.join(", ")}) in tool axes`;
}
