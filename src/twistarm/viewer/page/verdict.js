// Whether the target is reached, in a sign and a colour, with the reason; the details are folded.

import { DEFAULTS } from "./core.js";
import { $, element } from "./element.js";
import { withUnit, signed } from "./units.js";
import { report } from "./words.js";

const DEGREES = 180 / Math.PI;
const AT_BOUND = 1e-6; // rad, m: how near to its bound a joint stands at it
const NEGLIGIBLE = 0.005 / DEGREES; // an angle that would be written as 0.00°
const ALONG = 0.999; // cosine from which a direction is that of an axis
const LONGEST = 1000; // letters that the process takes

export class Verdict {
  place = $("target-words");
  missed = $("missed"); // the same in short, while another panel is in front

  // While a hand moves the target, it is not read aloud.
  busy(on) {
    for (const place of [this.place, this.missed]) place.setAttribute("aria-busy", on);
  }

  show(message) {
    const [short, ...why] = message.words.split("\n");
    this.place.dataset.converged = message.converged ?? "";
    const mark = message.converged ? "✓" : "✕";
    report(this.place, message.given ? [element("span", "converged", mark), ` ${short}`] : "", message.given ? why : []);
    this.missed.textContent = message.converged === false ? `✕ ${short}` : "";
  }
}

// What the solution of a target comes to, line by line: the first in short. `hello` of the arm that `core` is of.
export function inWords({ arm, core: { reasons } }, core, given, solution, tolerances) {
  const { converged, stop, theta, unlimited } = solution;
  const parts = { position: ["Position"], approach: ["Position", "direction"], pose: ["Position", "orientation"] }[given.kind];
  if (converged) return `${parts.join(" and ")} reached`;
  const far = solution.positionError > (tolerances.position || DEFAULTS.position);
  const off = solution.orientationError > (tolerances.orientation || DEFAULTS.orientation) && parts.length > 1;
  const turned = off ? [`${parts[1]} ${angle(solution.orientationError)} off`] : [];
  const lines = far ? [shortfall(reasons[stop], stop, given, solution), ...turned] : [`Position reached, ${turned}: ${reasons[stop]}`];
  if (unlimited !== null) lines.push(...blocked(arm, core, given, solution, tolerances, far));
  else lines.push(...missing(core, given, theta, !far));
  const bounds = theta.flatMap((value, i) => within(arm.joints[i], value, AT_BOUND));
  if (bounds.length > 0) lines.push(`At the limit: ${bounds.join(", ")}`);
  if (solution.certain) lines.push("The closed form proves that no configuration inside the limits reaches the target");
  return lines.join("\n").slice(0, LONGEST).replace(/[\ud800-\udbff]$/, "");
}

// What limits do: as explain() of a solution says it.
function blocked({ joints }, core, given, { unlimited, orientationError }, { orientation }, far) {
  const beyond = unlimited.flatMap((value, i) => within(joints[i], value, 0));
  const where = beyond.length > 0 ? `with ${beyond.join(", ")}` : "just beyond a limit";
  const turned = turn(core, given, unlimited);
  if (turned <= (orientation || DEFAULTS.orientation)) return [`Without joint limits the arm reaches the target ${where}`];
  const more = missing(core, given, unlimited);
  if (far) return [`Without joint limits the arm reaches the position ${where}`, ...more];
  return [`Limits prevent ${angle(orientationError - turned)} of the rotation`, `Without joint limits ${angle(turned)} are missing ${where}`, ...more];
}

// Of the rotation: what no joint turns, and what limits prevent, if that is asked for.
function missing(core, given, theta, all = false) {
  if (given.kind === "position") return [];
  const { impossible, prevented, axis } = core.split(given, theta);
  const never = impossible > NEGLIGIBLE ? [`No joint turns the tool about ${named(axis)}: ${angle(impossible)} of the rotation are missing`] : [];
  return all && prevented > NEGLIGIBLE ? [...never, `Limits or reach prevent ${angle(prevented)} of the rotation`] : never;
}

function turn(core, given, theta) {
  if (given.kind === "position") return 0;
  const { g } = core.kinematics(theta);
  const numbers = core.target(given);
  const off = given.kind === "pose"
    ? g.slice(0, 3).flatMap((row, i) => row.slice(0, 3).map((value, j) => (value - numbers[4 * i + j]) / Math.SQRT2))
    : g.slice(0, 3).map((row, i) => row[0] * numbers[6] + row[1] * numbers[7] + row[2] * numbers[8] - numbers[3 + i]);
  return 2 * Math.asin(Math.min(1, Math.hypot(...off) / 2));
}

function shortfall(reason, stop, { position }, { positionError }) {
  const by = stop === "OUT_OF_REACH" ? " by" : ",";
  const place = position.map((value) => signed(value, 3)).join(", ");
  return `${reason[0].toUpperCase()}${reason.slice(1)}${by} ${length(positionError)}${stop === "OUT_OF_REACH" ? "" : " short"}: (${place}) m`;
}

// A joint and its value, where that is beyond a limit or nearer to it than `near`; none where it turns all the way.
function within({ name, unit, limits: [lower, upper] }, value, near) {
  const turns = unit === "rad" && (upper ?? Infinity) - (lower ?? -Infinity) > 2 * Math.PI - AT_BOUND;
  const [side, limit] = lower !== null && value < lower + near ? ["lower", lower] : ["upper", upper];
  if (turns || limit === null || (side === "upper" && value <= upper - near)) return [];
  return [near > 0 ? `${name} (${withUnit(limit, unit)})` : `${name} ${withUnit(value, unit)} (${side} limit ${withUnit(limit, unit)})`];
}

function named(axis) {
  const i = [0, 1, 2].find((place) => Math.abs(axis[place]) >= ALONG);
  return i === undefined ? `(${axis.map((value) => value.toFixed(2)).join(", ")}) in its axes` : `its ${"xyz"[i]} axis`;
}

const length = (metres) => Math.abs(metres) >= 0.1 ? `${metres.toFixed(3)} m` : `${Number((1e3 * metres).toPrecision(3))} mm`;

function angle(radians) {
  const degrees = DEGREES * radians;
  return `${Math.abs(degrees) >= 0.1 ? degrees.toFixed(1) : Number(degrees.toPrecision(2))}°`;
}
