// Numbers as people read and type them: angles in degrees, or in radians where that is switched on; lengths in metres.

import { evaluated } from "./expression.js";
import { keep, kept } from "./storage.js";

const DEGREES = 180 / Math.PI;
const KEPT = "twistarm radians";
const STEPS = { "°": 1, rad: 0.01, m: 0.001, 1: 0.01 };
const WRITTEN = { m: { m: 1, cm: 100, mm: 1000, in: 1 / 0.0254 }, rad: { rad: 1, deg: DEGREES, "°": DEGREES }, 1: {} }; // typed units

let radians = kept(KEPT) === "true";

export const inRadians = () => radians;

export function setRadians(on) {
  radians = on;
  keep(KEPT, String(on));
}

// The unit on the page of what is in rad or m.
export const unitShown = (unit) => unit === "rad" && !radians ? "°" : unit;

export function signed(number, digits) {
  const text = number.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

// `digits` are those of degrees; metres and radians have two more.
export const figure = (value, unit, digits = 1) => signed(value * scale(unit), unitShown(unit) === "°" ? digits : digits + 2);
export const withUnit = (value, unit, digits) => figure(value, unit, digits) + mark(unit);

export function span([low, high], unit) {
  const whole = [low, high].every((end) => Number(figure(end, unit, 0).replace("−", "-")) === Number(figure(end, unit, 1).replace("−", "-")));
  const digits = whole ? 0 : 1; // those that a message about the limit has
  return `${figure(low, unit, digits)} … ${figure(high, unit, digits)}${mark(unit)}`;
}

// Decimals of a limit beside others of `digits`: radians tell little without two.
export const limitDigits = (unit, digits) => unitShown(unit) === "°" ? digits : Math.max(2, digits);

// What was typed, in rad or m; null where it is no number. `bare`: how many of a number without a unit are 1 rad or m,
// those of the page unless given; angles with pi are radians.
export function typed(text, unit, bare = scale(unit)) {
  const value = evaluated(text, WRITTEN[unit], unit === "rad" && /pi|π/i.test(text) ? 1 : bare);
  return Number.isFinite(value) ? value : null;
}

export const step = (unit) => STEPS[unitShown(unit)] / scale(unit);
export const stride = (unit) => `${STEPS[unitShown(unit)]}${mark(unit)}`;
const scale = (unit) => unitShown(unit) === "°" ? DEGREES : 1;
const mark = (unit) => ({ "°": "°", 1: "" }[unitShown(unit)] ?? ` ${unit}`);
