// Numbers of the theory as they are read, in SI units and radians, and as Python reads them.

const INFINITE = 'float("inf")';
const NARROW = 7; // letters that fit into a column

// `digits` after the point, fewer for what is large: a column is as wide for any number.
export function short(number, digits = 3) {
  const size = Math.abs(number);
  if (size >= 1e4) return tidy(number.toExponential(1));
  return tidy(number.toFixed(Math.max(0, digits - (size < 9.9995 ? 0 : size < 99.995 ? 1 : 2))));
}

const tidy = (text) => Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");

// h in m/rad; null is infinite: a slide.
export function pitchWords(pitch) {
  if (pitch === null) return "h = ∞";
  const millimetres = 1000 * pitch;
  const size = Math.abs(millimetres);
  if (size < 1e-6) return "h = 0";
  return `h = ${tidy(size < 0.1 ? millimetres.toPrecision(2) : millimetres.toFixed(1))} mm/rad`;
}

// All digits: what Python reads is the very number.
export function python(value) {
  if (value === null) return INFINITE;
  if (Array.isArray(value)) return `[${value.map(python).join(", ")}]`;
  if (typeof value !== "object") return JSON.stringify(value);
  return `{${Object.entries(value).map(([name, entry]) => `${JSON.stringify(name)}: ${python(entry)}`).join(", ")}}`;
}

export const pythonRows = (rows) => `[\n${rows.map((row) => `    ${python(row)},\n`).join("")}]`;

// Heads of narrow columns: names, without what they begin with alike if one is long.
export function heads(names) {
  const [first] = names;
  let shared = 0;
  while (names.length > 1 && names.every((name) => shared < name.length - 1 && name[shared] === first[shared])) shared += 1;
  const left = names.map((name) => (shared > 2 && Math.max(...names.map(({ length }) => length)) > NARROW ? `…${name.slice(shared)}` : name));
  return left.map((name) => name.replaceAll("_", "_\u200b")); // where it may be broken
}
