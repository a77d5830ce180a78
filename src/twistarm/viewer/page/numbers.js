// The numbers behind the drawing, as tables, each with a button that copies it with all its digits.

import { copyText } from "./copying.js";
import { $, button, element } from "./element.js";
import { heads, pitchWords, python, pythonRows, short } from "./figures.js";
import { writeName } from "./names.js";

const TWIST = ["vx", "vy", "vz", "ωx", "ωy", "ωz"];
const MANY = 6; // columns as wide as the panel
const UNITS = "in SI units and radians";
const EXPLAINED = {
  σ: "Speeds of the tool in as many directions, for joint rates of 1 rad/s in all; metres are divided by the reach",
  condition: "The greatest singular value divided by the least: near a singular configuration it is large",
  linear: "Greatest and least speeds of the tool's origin, and their directions, for joint rates of 1 rad/s in all",
  angular: "Greatest and least rates at which the tool turns, and their axes, for joint rates of 1 rad/s in all",
  Yoshikawa: "Yoshikawa's manipulability, the product of the singular values: 0 in a singular configuration",
};

export class Numbers {
  tables = [];

  // `axes` of the moving joints, `names` of the coordinates.
  build(axes, names, arm) {
    const moving = axes.joints.map(({ name }) => name);
    this.names = names;
    this.rankText = element("p", "rank");
    Object.assign(this.rankText, { id: "theory-rank", title: "In how many independent ways the tool moves now" });
    const columns = heads(names);
    const titles = names.map((name, i) => `${name} [${arm.joints[i].unit}]`);
    this.tables = [
      new Table("g_st", "g_st", "Pose of T seen from S [m]", ["", "", "", ""], [], ["", "", "", ""], ({ g }) => g),
      new Table("J^s", "Jˢ", "Spatial Jacobian, per rad or m of a joint", columns, titles, TWIST, ({ spatial }) => spatial),
      new Table("J^b", "Jᵇ", "Body Jacobian, per rad or m of a joint", columns, titles, TWIST, ({ body }) => body),
      new Values("singular values", "Singular values", "Scaled by the reach", values, ({ singular_values }) => singular_values),
      new Values("ellipsoids", "Ellipsoids", "Semi-axes, directions in S", ellipsoids, ({ linear, angular }) => ({ linear, angular })),
      new Values("joint screws", "Joint screws", "Axis, point [m], pitch; in S", (all) => screws(moving, all.axes),
        (all) => moving.map((name, i) => ({ name, ...all.axes[i] }))),
      new Values("instantaneous screw", "Instantaneous screw", "Joint or motion", (all, i) => instant(this.names, all, i),
        (all, i) => chosenScrew(this.names, all, i)),
    ];
    $("theory-numbers").replaceChildren(this.rankText, ...this.tables.map((table) => table.section));
  }

  // `chosen`: the coordinate whose screw is shown; null: the whole motion.
  show(all, chosen) {
    set(this.rankText, all.rank_words);
    this.rankText.dataset.weak = all.smallest < all.below;
    for (const table of this.tables) table.show(all, chosen);
  }
}

class Table {
  constructor(name, title, meaning, columns, titles, rows, read) {
    this.read = read;
    this.ofJoints = titles.length > 0;
    this.cells = rows.map(() => columns.map(() => element("td")));
    const table = element("table", columns.length > MANY ? "matrix wide" : "matrix");
    table.setAttribute("aria-label", `${title}: ${meaning}`);
    table.style.setProperty("--columns", columns.length);
    if (columns.some(Boolean)) {
      const head = element("tr");
      head.append(element("td"), ...columns.map((column, i) => jointCell(column, titles[i])));
      table.append(head);
    }
    rows.forEach((row, r) => {
      const line = element("tr");
      if (row) line.append(headCell(row, "row"));
      line.append(...this.cells[r]);
      table.append(line);
    });
    const around = element("div", "around");
    around.tabIndex = 0; // to be scrolled by keys
    around.append(table);
    around.setAttribute("role", "group");
    around.setAttribute("aria-label", title);
    this.section = section(title, meaning, around, () => copyText(pythonRows(this.matrix), name, UNITS));
  }

  show(all, chosen) {
    this.matrix = this.read(all);
    this.cells.forEach((line, r) => line.forEach((cell, c) => {
      set(cell, short(this.matrix[r][c]));
      cell.classList.toggle("chosen", this.ofJoints && c === chosen);
    }));
  }
}

// Lines of words and numbers: `write(all, chosen)` gives [term, text, …], `read` what is copied.
class Values {
  constructor(name, title, meaning, write, read) {
    this.write = write;
    this.read = read;
    this.list = element("dl", "values");
    this.section = section(title, meaning, this.list, () => copyText(python(this.value), name, UNITS));
  }

  show(all, chosen) {
    this.value = this.read(all, chosen);
    const lines = this.write(all, chosen);
    while (this.list.children.length > 2 * lines.length) this.list.lastChild.remove();
    while (this.list.children.length < 2 * lines.length) this.list.append(element("dt"), element("dd"));
    lines.flat().forEach((text, k) => set(this.list.children[k], text));
  }
}

function section(title, meaning, content, copy) {
  const made = element("section", "figures");
  const head = element("h3", "", title);
  const copies = button("copy", "copy", `Copy ${title} with all digits, for Python`, copy);
  copies.setAttribute("aria-label", `Copy ${title}`);
  const line = element("div", "head");
  line.title = meaning;
  line.append(head, element("span", "meaning", meaning), copies);
  made.append(line, content);
  return made;
}

function jointCell(text, title) {
  const cell = Object.assign(headCell("", "col"), { title });
  cell.append(element("span", "", text));
  return cell;
}

const headCell = (text, scope) => Object.assign(element("th", "", text), { scope });

function set(node, text) {
  if (node.textContent === text) return;
  if (node.tagName === "DT") return writeName(node, text, EXPLAINED[text] ?? text);
  node.textContent = text;
  if (node.tagName === "DD") node.title = text;
}

const triple = (numbers, digits) => `(${numbers.map((number) => short(number, digits)).join(", ")})`;

function values({ singular_values: sigma, condition, yoshikawa }) {
  return [
    ["σ", sigma.map((value) => short(value)).join("  ")],
    ["condition", condition === null ? "∞" : short(condition)],
    ["Yoshikawa", yoshikawa.toPrecision(3).replace("-", "−")],
  ];
}

function ellipsoids(all) {
  const lines = (name, unit, { semi_axes: long, directions }) => long.map((length, k) =>
    [k === 0 ? name : "", `${short(length)} ${unit}  ${triple(directions.map((row) => row[k]), 2)}`]);
  return [...lines("linear", "m/s", all.linear), ...lines("angular", "rad/s", all.angular)];
}

function screws(names, all) {
  return all.flatMap(({ axis, point, pitch }, i) => [[names[i], `axis ${triple(axis)}`], [pitchWords(pitch), pitch === null ? "" : `point ${triple(point)}`]]);
}

function chosenScrew(names, { motion, columns }, i) {
  if (i !== null) return { name: names[i], ...columns[i] };
  const { screw, ...rest } = motion;
  return { name: "motion", ...screw, ...rest };
}

function instant(names, all, i) {
  const { name, axis, point, pitch, magnitude } = chosenScrew(names, all, i);
  const size = pitch === null ? `${short(magnitude)} m/s` : `${short(magnitude)} rad/s`;
  if (magnitude === 0) return [[name, "moves nothing"]];
  return [[name, `axis ${triple(axis)}`], [pitchWords(pitch), pitch === null ? "" : `point ${triple(point)}`], ["magnitude", size]];
}
