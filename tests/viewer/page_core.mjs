// Runs core.js in Node.js: node page_core.mjs PAGE < [[hello, calls], …] → [{solves, forms, answers}, …].

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const page = process.argv[2];
const { Core } = await import(pathToFileURL(join(page, "core.js")).href);
const module = new WebAssembly.Module(readFileSync(join(page, "arm.wasm")));

// A call is the name of a method of Core and what it takes; "step" first takes what a servo does where it cannot follow.
function answered(core, [name, ...given]) {
  if (name === "step") return core.servo({ onUnreachable: given.shift() }).step(...given);
  return core[name](...given);
}

console.log(JSON.stringify(JSON.parse(readFileSync(0, "utf8")).map(([hello, calls]) => {
  const core = new Core(module, hello);
  return { solves: core.solves, forms: core.forms, answers: calls.map((call) => answered(core, call)) };
})));
