// How a page stands, so that another can stand so: of each part that has it, remembered() is told to recall(what).

import { $ } from "./element.js";

export function stateOf(parts) {
  const keepers = Object.entries(parts).filter(([, part]) => part.remembered);
  return Object.fromEntries(keepers.map(([name, part]) => [name, part.remembered()]));
}

export function restore(parts, state) {
  for (const [name, part] of Object.entries(parts)) {
    if (state[name] !== undefined) part.recall?.(state[name]);
  }
  for (const id of state.pressed ?? []) $(id)?.click(); // such as a switch that the scene of a lesson begins with
}
