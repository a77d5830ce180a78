// The messages between page and process, checked by the one schema that the process checks them by.

const LONGEST = 1000;

const number = (value) => Number.isFinite(value);
const list = (value) => Array.isArray(value);
const numbers = (value, size) => list(value) && value.every(number) && (size === undefined || value.length === size);
const text = (value) => typeof value === "string";
const object = (value) => typeof value === "object" && value !== null && !list(value);
const name = (value) => text(value) && value.length <= LONGEST;

const KINDS = {
  number: [number, "a finite number"],
  numbers: [numbers, "a list of finite numbers"],
  list: [list, "a list"],
  text: [text, "text"],
  object: [object, "an object"],
  name: [name, `text of at most ${LONGEST} characters`],
  point: [(value) => numbers(value, 3), "a list of 3 numbers"],
  quaternion: [(value) => numbers(value, 4), "a list of 4 numbers"],
  count: [(value) => Number.isSafeInteger(value) && value >= 0, "a whole number from 0 on"],
  flag: [(value) => typeof value === "boolean", "true or false"],
  names: [(value) => list(value) && value.every(name), `a list of names of at most ${LONGEST} characters`],
  poses: [(value) => list(value) && value.every(pose),
    `a list of poses, each with a name of at most ${LONGEST} characters and theta, a list of numbers`],
}; // of a field: its check, and what it must be in words

function pose(value) {
  if (!object(value) || Object.keys(value).some((key) => !["name", "theta", "by"].includes(key))) return false;
  return name(value.name) && numbers(value.theta) && (value.by === undefined || name(value.by));
}

// What is wrong with a message of this table, "requests" or "messages"; "" where nothing is.
export function violation(table, message) {
  const fields = table[message?.type];
  if (!fields) return `unknown message type ${message?.type}`;
  const { type, ...given } = message;
  for (const [field, word] of Object.entries(fields)) {
    if (!fits(word, given[field])) return `${type}: ${field} must be ${words(word)}`;
  }
  const extra = Object.keys(given).find((field) => !(field in fields));
  return extra === undefined ? "" : `${type} has no ${extra}`;
}

function words(word) {
  if (word.endsWith("?")) return `${words(word.slice(0, -1))}, or null`;
  return word.includes("|") ? `one of ${word.replaceAll("|", ", ")}` : KINDS[word][1];
}

function fits(word, value) {
  if (word.endsWith("?")) return value === null || fits(word.slice(0, -1), value);
  if (word.includes("|")) return word.split("|").includes(value);
  return KINDS[word][0](value);
}
