// The bench of a slider: its controls, its drawing and its numbers.
"use strict";

(() => {
  const { Eye, player, numbers: { RAD, ORIGIN, add, times, columns } } = window.guide;
  const { cos, sin, hypot, abs } = Math;
  const SVG = "http://www.w3.org/2000/svg";
  const COLOURS = { x: "orange", y: "green", z: "blue" };
  const DASHES = { x: "", y: "7 3", z: "2 3" };

  function element(name, properties = {}, ...children) {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...children);
    return made;
  }

  function draw(parent, name, attributes) {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    parent.append(made);
    return made;
  }

  // Controls above, a drawing and its numbers below; whatever is moved, `show` draws anew.
  class Bench {
    constructor(stage, words, turns = false) {
      this.values = {};
      this.inputs = {};
      this.svg = document.createElementNS(SVG, "svg");
      this.svg.setAttribute("viewBox", "-150 -130 300 260");
      this.svg.setAttribute("role", "img");
      this.words = words;
      this.numbers = element("pre", { className: "numbers", tabIndex: 0 });
      this.numbers.setAttribute("aria-label", "Numbers");
      this.numbers.setAttribute("role", "group");
      this.controls = element("div", { className: "controls" });
      const bench = element("div", { className: "bench" }, this.controls, this.svg, this.numbers);
      stage.append(bench);
      stage.classList.add("live");
      if (turns) this.eye = new Eye(this.svg, -55, 22, () => this.show());
    }

    // A number to slide: its name, from, to, step, unit.
    number(key, name, from, to, step, suffix, value) {
      const input = element("input", { type: "range", min: from, max: to, step, value });
      const output = element("output");
      const digits = step < 0.1 ? 2 : step < 1 ? 1 : 0;
      const take = () => {
        this.values[key] = Number(input.value);
        const said = `${this.values[key].toFixed(digits).replace("-", "−")}${suffix}`;
        output.textContent = said;
        input.setAttribute("aria-valuetext", said);
      };
      input.addEventListener("input", () => { take(); this.show(); });
      this.inputs[key] = input;
      take();
      const label = element("label", {}, element("span", { textContent: name }), input, output);
      this.controls.append(label);
      return label;
    }

    // Slide a number from elsewhere.
    slide(key, value) {
      this.inputs[key].value = value;
      this.inputs[key].dispatchEvent(new Event("input"));
    }

    choice(key, name, options, value) {
      const select = element("select", {}, ...options.map((each) => element("option", { textContent: each, value: each })));
      select.value = value;
      this.values[key] = value;
      select.addEventListener("input", () => { this.values[key] = select.value; this.show(); });
      this.controls.append(element("label", {}, element("span", { textContent: name }), select));
    }

    box(key, name) {
      const input = element("input", { type: "checkbox" });
      this.values[key] = false;
      input.addEventListener("input", () => { this.values[key] = input.checked; this.show(); });
      this.controls.append(element("label", { className: "box" }, input, element("span", { textContent: name })));
    }

    // A button that plays what the label's input scrubs.
    plays(label, seconds = 4) {
      const row = element("div", { className: "plays" });
      label.replaceWith(row);
      row.append(player(label.querySelector("input"), seconds), label);
    }

    // Where a point in space is drawn.
    at(point) {
      return times(this.scale, this.eye.look()(point));
    }

    line(points, colour, more = {}) {
      const d = points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(2)} ${y.toFixed(2)}`).join("");
      return draw(this.svg, "path", { d, fill: "none", stroke: `var(--${colour})`, "stroke-width": 2.2, "stroke-linecap": "round", "stroke-linejoin": "round", ...more });
    }

    arrow(from, to, colour, more = {}) {
      this.line([from, to], colour, more);
      const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
      const length = hypot(dx, dy);
      if (length < 4) return;
      const [ux, uy] = [dx / length, dy / length];
      const head = [[-8, 3.4], [0, 0], [-8, -3.4]].map(([a, b]) => [to[0] + a * ux - b * uy, to[1] + a * uy + b * ux]);
      this.line(head, colour, { "stroke-opacity": more["stroke-opacity"] ?? 1 });
    }

    dot([x, y], colour, r = 4, more = {}) {
      draw(this.svg, "circle", { cx: x, cy: y, r, fill: `var(--${colour})`, ...more });
    }

    say([x, y], words, colour = "ink") {
      const label = draw(this.svg, "text", { x, y, "text-anchor": "middle", "dominant-baseline": "middle", style: `fill:var(--${colour})` });
      label.textContent = words;
    }

    // A frame in space, its axes told apart by dashes too.
    frame(R, p, name, length, faint = false) {
      ["x", "y", "z"].forEach((axis, i) => {
        const end = add(p, times(length, columns(R)[i]));
        const opacity = faint ? 0.45 : 1;
        this.arrow(this.at(p), this.at(end), COLOURS[axis], { "stroke-dasharray": DASHES[axis], "stroke-opacity": opacity });
        if (!faint) this.say(this.at(add(p, times(1.16 * length, columns(R)[i]))), axis + name, COLOURS[axis]);
      });
    }

    // Draw a two-link arm in the plane, with the edges of its workspace; where its tool is [m].
    arm(n, theta1, theta2, colour, opacity, edges = false) {
      const at = ([x, y]) => [this.scale * x, -this.scale * y];
      if (edges) {
        for (const r of [n.l1 + n.l2, abs(n.l1 - n.l2)]) {
          draw(this.svg, "circle", { cx: 0, cy: 0, r: this.scale * r, fill: "none", stroke: "var(--faint)", "stroke-dasharray": "3 3" });
        }
        this.line([at([-n.l1 - n.l2, 0]), at([n.l1 + n.l2, 0])], "faint", { "stroke-width": 1 });
        this.line([at([0, -n.l1 - n.l2]), at([0, n.l1 + n.l2])], "faint", { "stroke-width": 1 });
      }
      const [first, both] = [theta1 * RAD, (theta1 + theta2) * RAD];
      const elbow = [n.l1 * cos(first), n.l1 * sin(first)];
      const tool = add(elbow, [n.l2 * cos(both), n.l2 * sin(both)]);
      this.line([ORIGIN, elbow, tool].map(at), colour, { "stroke-width": 5, "stroke-opacity": opacity, ...(edges ? {} : { "stroke-dasharray": "9 7", "stroke-width": 3.5 }) });
      this.dot(at(ORIGIN), "sky", 5);
      this.dot(at(elbow), "sky", edges ? 7 : 5, edges ? { "data-handle": "elbow" } : {});
      this.dot(at(tool), edges ? "blue" : colour, edges ? 7 : 5, edges ? { "data-handle": "tool" } : {});
      return tool;
    }

    show() {
      this.svg.replaceChildren();
      const { numbers, words } = this.words.call(this, this.values);
      this.numbers.textContent = numbers;
      this.svg.setAttribute("aria-label", words);
    }
  }

  window.guide.Bench = Bench;
})();
