// Numbers as people read them: degrees for angles, metres for lengths.

const DEGREES = 180 / Math.PI;

export function signed(number, digits) {
  const text = number.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

export function shown(value, unit, digits) {
  return unit === "rad" ? `${signed(value * DEGREES, digits ?? 1)}°` : `${signed(value, digits ?? 3)} m`;
}

export function shortened(value, unit) {
  return unit === "rad" ? shown(value, unit, 0) : `${signed(value, 2)} m`;
}
