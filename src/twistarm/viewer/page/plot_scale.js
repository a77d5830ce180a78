// What a plot shows of the joints, and in which numbers: all of them as shares of their limits, or one in its unit; and
// how fast the tool is.

import { figure, limitDigits, signed, unitShown } from "./units.js";

export const RATES = ["position", "velocity", "acceleration"];
const TITLES = { position: "Position", velocity: "Velocity", acceleration: "Acceleration" };
const PER = { position: "", velocity: "/s", acceleration: "/s²" };
const FAR = 3; // a limit farther off than this many times what moves is told, not drawn
const AIR = 0.12; // of the height, above and below
const LEAST = 1e-3; // rad, m, and per s and s²: less is rounding, and fills no plot
const STILL = 0.05; // of the largest peak: likewise

// {title, low, high, marks: [{at, label, limit}], lines: [{joint, values}]} of the plots' message for a rate. `chosen`
// is a joint's place; null: all.
export const scaled = (plots, rate, chosen) => chosen === null ? shares(plots, rate) : alone(plots, rate, chosen);

// The same of the tool: the speed of its origin, and how fast it turns at most.
export function toolScaled({ tool }) {
  const lines = [{ joint: 0, values: tool.linear }];
  const { low, high } = reach([0, LEAST], lines);
  const digits = decimals(high - low);
  const marks = ticks(low, high).filter((at) => at >= 0).map((at) => ({ at, limit: false, label: signed(at, digits) }));
  return { title: "Tool, m/s", low, high, marks, lines };
}

export const worded = (value, { unit }, rate) => `${figure(value, unit)} ${unitShown(unit)}${PER[rate]}`;

// By what a joint's values are divided, after `middle` is taken off: ±1 are its limits. Without a limit its peak, or a
// part of the largest among its `others`: what stands still is drawn so.
export function share({ limits, range, peak, unit }, rate, others) {
  if (rate !== "position") {
    const most = Math.max(...others.filter((other) => other.unit === unit).map((other) => other.peak[rate]));
    return { middle: 0, half: limits[rate] ?? Math.max(peak[rate], STILL * most, LEAST) };
  }
  const [low, high] = range;
  return { middle: (low + high) / 2, half: (high - low) / 2 || 1 };
}

function shares(plots, rate) {
  const lines = plots.joints.map((joint, i) => {
    const { middle, half } = share(joint, rate, plots.joints);
    return { joint: i, values: plots[rate][i].map((value) => (value - middle) / half) };
  });
  const limited = plots.joints.some((joint) => ends(joint, rate).some((limit) => limit !== null));
  const words = limited && rate === "position" ? ["lower", "", "upper"] : ["−100 %", "0", "100 %"];
  const marks = [-1, 0, 1].map((at, i) => ({ at, label: words[i], limit: limited && at !== 0 }));
  return { title: `${TITLES[rate]}, ${wholes(plots.joints, rate)}`, lines, marks, ...reach([-1, 1], lines) };
}

// What is a whole: the limit, and a joint's own peak where it has none.
function wholes(joints, rate) {
  if (rate === "position") return "share of range";
  const without = joints.filter(({ limits }) => limits[rate] === null).length;
  if (without === joints.length) return "share of peak (no limits)";
  if (without > 0) return "share of limit, else of peak";
  return joints.some(({ usual }) => usual.includes(rate)) ? "share of usual limit" : "share of limit";
}

function alone(plots, rate, chosen) {
  const joint = plots.joints[chosen];
  const scale = Number(figure(1, joint.unit, 9).replace("−", "-")); // a degree or 1
  const lines = [{ joint: chosen, values: plots[rate][chosen].map((value) => value * scale) }];
  const limits = ends(joint, rate).map((limit) => (limit === null ? null : limit * scale));
  const [least, most] = extremes(lines);
  const room = FAR * Math.max(most - least, Math.abs(most), Math.abs(least));
  const drawn = limits.filter((limit) => limit !== null && limit >= least - room && limit <= most + room);
  const middle = (least + most) / 2;
  const { low, high } = reach([middle - LEAST * scale, middle + LEAST * scale, ...drawn], lines);
  const round = ticks(low, high).filter((at) => drawn.every((limit) => Math.abs(at - limit) > AIR * (high - low)));
  const marks = [...round.map((at) => ({ at, limit: false })), ...drawn.map((at) => ({ at, limit: true }))];
  const digits = decimals(high - low);
  const exact = limitDigits(joint.unit, digits);
  for (const mark of marks) mark.label = signed(mark.at, mark.limit ? exact : digits);
  return { title: `${TITLES[rate]}, ${unitShown(joint.unit)}${PER[rate]}${limitsInWords(joint, rate, limits, exact)}`, low, high, marks, lines };
}

function limitsInWords(joint, rate, [low, high], digits) {
  const usual = joint.usual.includes(rate) ? "usual limit" : "limit";
  if (rate !== "position") return high === null ? " · no limit" : ` · ${usual} ±${signed(high, digits)}`;
  const words = [low, high].map((limit) => (limit === null ? "none" : signed(limit, digits)));
  return low === null && high === null ? " · no limits" : ` · limits ${words.join(" … ")}`;
}

function ends({ limits }, rate) {
  if (rate === "position") return limits.position;
  return limits[rate] === null ? [null, null] : [-limits[rate], limits[rate]];
}

function extremes(lines) {
  const [least, most] = [Math.min, Math.max].map((of) => of(...lines.map(({ values }) => of(...values))));
  return [least, most];
}

function reach(limits, lines) {
  const [least, most] = extremes(lines);
  const [low, high] = [Math.min(least, ...limits), Math.max(most, ...limits)];
  const air = AIR * (high - low || Math.abs(high) || 1);
  return { low: low - air, high: high + air };
}

export function ticks(low, high) {
  const step = stride(high - low);
  const count = Math.floor(high / step) - Math.ceil(low / step) + 1;
  return Array.from({ length: Math.max(0, count) }, (_, i) => (Math.ceil(low / step) + i) * step);
}

export const decimals = (span) => Math.max(0, Math.min(9, -Math.floor(Math.log10(stride(span)))));

function stride(span) {
  const rough = (span || 1) / 4;
  const power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 5].find((times) => times * power >= rough) ?? 10);
}
