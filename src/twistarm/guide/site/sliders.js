// What the reader moves by hand: each element with data-slider becomes controls, a drawing and its numbers.
"use strict";

(() => {
  const RAD = Math.PI / 180;
  const SVG = "http://www.w3.org/2000/svg";
  const COLOURS = { x: "orange", y: "green", z: "blue" };
  const DASHES = { x: "", y: "7 3", z: "2 3" };

  // ---- numbers -------------------------------------------------------------------------------------------------

  const { cos, sin, acos, atan2, hypot, abs, max, min, sqrt, PI } = Math;
  const add = (a, b) => a.map((x, i) => x + b[i]);
  const times = (s, a) => a.map((x) => s * x);
  const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
  const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
  const unit = (a) => times(1 / (hypot(...a) || 1), a);
  const columns = (M) => M[0].map((_, j) => M.map((row) => row[j]));
  const product = (A, B) => A.map((row) => columns(B).map((column) => dot(row, column)));
  const apply = (M, p) => M.map((row) => dot(row, p));

  // Rodrigues' formula for a unit vector w.
  function turned(w, angle) {
    const [x, y, z] = w;
    const K = [[0, -z, y], [z, 0, -x], [-y, x, 0]];
    const KK = product(K, K);
    const one = (i, j) => (i === j ? 1 : 0);
    return K.map((row, i) => row.map((k, j) => one(i, j) + sin(angle) * k + (1 - cos(angle)) * KK[i][j]));
  }

  const AXES = { X: [1, 0, 0], Y: [0, 1, 0], Z: [0, 0, 1] };
  const euler = (order, angles) => [...order].map((axis, i) => turned(AXES[axis], angles[i])).reduce(product);

  // e^{ξ̂θ} of a screw: a turn about the line through q along w, and h θ along it.
  function screwed(w, q, h, angle) {
    const R = turned(w, angle);
    return { R, p: add(add(q, times(-1, apply(R, q))), times(h * angle, w)) };
  }

  const text = (x, digits = 3) => ((x < 0 && Number(x.toFixed(digits)) !== 0 ? "−" : " ") + abs(x).toFixed(digits)).padStart(digits + 3);
  const row = (numbers, digits) => numbers.map((x) => text(x, digits)).join(" ");
  const matrix = (name, M) => M.map((line, i) => `${i === 0 ? name.padEnd(4) : "    "}${row(line)}`).join("\n");

  // ---- elements ------------------------------------------------------------------------------------------------

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
      this.eye = -55;
      this.inSpace = turns;
    }

    // A number to slide: its name, from, to, step, unit.
    number(key, name, from, to, step, unit, value) {
      const input = element("input", { type: "range", min: from, max: to, step, value });
      const output = element("output");
      const digits = step < 0.1 ? 2 : step < 1 ? 1 : 0;
      const take = () => {
        this.values[key] = Number(input.value);
        const said = `${this.values[key].toFixed(digits).replace("-", "−")}${unit}`;
        output.textContent = said;
        input.setAttribute("aria-valuetext", said);
      };
      input.addEventListener("input", () => { take(); this.show(); });
      take();
      const label = element("label", {}, element("span", { textContent: name }), input, output);
      this.controls.append(label);
      return label;
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

    // The eye goes round by its own slider, and by dragging the drawing.
    turns() {
      const label = this.number("eye", "eye", -180, 180, 5, "°", this.eye);
      const input = label.querySelector("input");
      this.svg.classList.add("turns");
      let last = null;
      this.svg.addEventListener("pointerdown", (event) => { last = event.clientX; this.svg.setPointerCapture(event.pointerId); });
      this.svg.addEventListener("pointermove", (event) => {
        if (last === null) return;
        let eye = Number(input.value) - (event.clientX - last) * 0.7;
        eye = eye > 180 ? eye - 360 : eye < -180 ? eye + 360 : eye;
        last = event.clientX;
        input.value = String(eye);
        input.dispatchEvent(new Event("input"));
      });
      for (const end of ["pointerup", "pointercancel"]) this.svg.addEventListener(end, () => { last = null; });
    }

    // Where a point in space is drawn: from 22° above, from the side of `eye`.
    at([x, y, z]) {
      const eye = (this.values.eye ?? this.eye) * RAD;
      const high = 22 * RAD;
      const right = -sin(eye) * x + cos(eye) * y;
      const away = cos(eye) * x + sin(eye) * y;
      return [this.scale * right, -this.scale * (cos(high) * z - sin(high) * away)];
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

    dot([x, y], colour, r = 4) {
      draw(this.svg, "circle", { cx: x, cy: y, r, fill: `var(--${colour})` });
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

    start() {
      if (this.inSpace) this.turns();
      this.show();
    }

    show() {
      this.svg.replaceChildren();
      const { numbers, words } = this.words.call(this, this.values);
      this.numbers.textContent = numbers;
      this.svg.setAttribute("aria-label", words);
    }
  }

  const UNITY = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const ORIGIN = [0, 0, 0];
  const trace = (R) => R[0][0] + R[1][1] + R[2][2];
  const angleOf = (R) => acos(max(-1, min(1, (trace(R) - 1) / 2))) / RAD;

  // ---- the seven -----------------------------------------------------------------------------------------------

  const SLIDERS = {
    frame(stage, n) {
      const proper = n.order[0] === n.order[2];
      const bench = new Bench(stage, function ({ alpha, beta, gamma }) {
        this.scale = 92;
        const R = euler(n.order, [alpha, beta, gamma].map((x) => x * RAD));
        this.frame(UNITY, ORIGIN, "A", 1, true);
        this.frame(R, ORIGIN, "B", 1);
        const fails = proper ? abs(sin(beta * RAD)) : abs(cos(beta * RAD));
        const numbers = [
          matrix("R", R), "",
          `angle of R ${text(angleOf(R), 1)}°`,
          `α + γ      ${text(alpha + gamma, 0)}°`,
          `α − γ      ${text(alpha - gamma, 0)}°`,
          `${proper ? "sin β" : "cos β"}      ${text(proper ? sin(beta * RAD) : cos(beta * RAD))}`,
          fails < 1e-9 ? "two axes in one line:\none freedom is lost" : "",
        ].join("\n");
        return { numbers, words: `Frame B, turned by ${n.order} angles ${alpha}, ${beta}, ${gamma} degrees` };
      }, true);
      bench.number("alpha", `α about ${n.order[0].toLowerCase()}`, -180, 180, 5, "°", n.alpha);
      bench.number("beta", `β about ${n.order[1].toLowerCase()}′`, proper ? 0 : -90, proper ? 180 : 90, 5, "°", n.beta);
      bench.number("gamma", `γ about ${n.order[2].toLowerCase()}″`, -180, 180, 5, "°", n.gamma);
      return bench;
    },

    axis_angle(stage, n) {
      const [x, y, z] = unit(n.axis);
      const bench = new Bench(stage, function ({ round, up, angle }) {
        this.scale = 80;
        const w = [cos(up * RAD) * cos(round * RAD), cos(up * RAD) * sin(round * RAD), sin(up * RAD)];
        const R = turned(w, angle * RAD);
        this.line([this.at(times(-1.35, w)), this.at(times(1.35, w))], "pink", { "stroke-dasharray": "9 3 2 3" });
        this.say(this.at(times(1.5, w)), "ω", "pink");
        this.frame(UNITY, ORIGIN, "A", 1, true);
        this.frame(R, ORIGIN, "B", 1);
        const path = Array.from({ length: 61 }, (_, i) => this.at(apply(turned(w, (angle * RAD * i) / 60), [1, 0, 0])));
        this.line(path, "grey", { "stroke-width": 1.4 });
        const Q = [cos((angle * RAD) / 2), ...times(sin((angle * RAD) / 2), w)];
        const numbers = [
          `ω   ${row(w)}`, matrix("R", R), "",
          `trace R ${text(trace(R))} = 1 + 2 cos θ`,
          `angle of R ${text(angleOf(R), 1)}°`,
          `Q   ${row(Q)}`,
        ].join("\n");
        return { numbers, words: `Frame B, turned by ${angle} degrees about an axis` };
      }, true);
      bench.number("angle", "angle θ", -360, 360, 5, "°", n.angle);
      bench.number("round", "axis: round", -180, 180, 5, "°", atan2(y, x) / RAD);
      bench.number("up", "axis: up", -90, 90, 5, "°", Math.asin(z) / RAD);
      return bench;
    },

    twist(stage, n) {
      const w = unit(n.axis);
      const bench = new Bench(stage, function ({ x, y, pitch, angle }) {
        this.scale = 72;
        const q = [x, y, n.point[2] ?? 0];
        const v = add(cross(q, w), times(pitch, w));
        const { R, p } = screwed(w, q, pitch, angle * RAD);
        const path = Array.from({ length: 121 }, (_, i) => this.at(screwed(w, q, pitch, (angle * RAD * i) / 120).p));
        this.line([this.at(add(q, times(-1.2, w))), this.at(add(q, times(1.6, w)))], "pink", { "stroke-dasharray": "9 3 2 3" });
        this.say(this.at(add(q, times(1.75, w))), "ξ", "pink");
        this.line(path, "grey", { "stroke-width": 1.4 });
        this.frame(UNITY, ORIGIN, "A", 0.7, true);
        this.frame(R, p, "B", 0.7);
        const g = R.map((line, i) => [...line, p[i]]);
        const numbers = [`v   ${row(v)}`, `ω   ${row(w)}`, "", matrix("g", [...g, [0, 0, 0, 1]]), "", `along the axis ${text(dot(p, w))} m`].join("\n");
        return { numbers, words: `A frame moved by ${angle} degrees along a screw of pitch ${pitch}` };
      }, true);
      bench.number("angle", "θ", -360, 720, 10, "°", n.angle);
      bench.number("pitch", "pitch h", -0.2, 0.2, 0.02, " m/rad", n.pitch);
      bench.number("x", "axis at x", -1, 1, 0.1, " m", n.point[0]);
      bench.number("y", "axis at y", -1, 1, 0.1, " m", n.point[1]);
      return bench;
    },

    joint(stage, n) {
      const Z = [0, 0, 1], X = [1, 0, 0], Y = [0, 1, 0];
      const turn = (w, name) => ({ w, name, unit: "°", v: ORIGIN, turns: true });
      const slide = (v, name) => ({ w: ORIGIN, name, unit: " m", v, turns: false });
      const TYPES = {
        revolute: [turn(Z, "turn about z")],
        prismatic: [slide(Z, "slide along z")],
        helical: [{ ...turn(Z, "screw along z"), v: times(0.15, Z) }],
        cylindrical: [turn(Z, "turn about z"), slide(Z, "slide along z")],
        planar: [slide(X, "slide along x"), slide(Y, "slide along y"), turn(Z, "turn about z")],
        spherical: [turn(Z, "turn about z"), turn(Y, "turn about y′"), turn(X, "turn about x″")],
      };
      const CUBE = [[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]];
      const bench = new Bench(stage, function (values) {
        this.scale = 88;
        const freedoms = TYPES[values.type];
        rows.forEach((label, i) => {
          label.hidden = i >= freedoms.length;
          label.style.display = label.hidden ? "none" : "";
          const freedom = freedoms[i];
          if (!freedom) return;
          label.firstChild.textContent = freedom.name;
          const share = values[`q${i}`];
          label.lastChild.textContent = freedom.turns ? `${(share * 180).toFixed(0)}°`.replace("-", "−") : `${(share * 0.5).toFixed(2)} m`.replace("-", "−");
          label.querySelector("input").setAttribute("aria-valuetext", label.lastChild.textContent);
        });
        let R = UNITY, p = ORIGIN;
        for (const [i, freedom] of freedoms.entries()) {
          const amount = values[`q${i}`] * (freedom.turns ? PI : 0.5);
          const step = freedom.turns ? turned(freedom.w, amount) : UNITY;
          p = add(p, apply(R, times(amount, freedom.v)));
          R = product(R, step);
        }
        const corner = ([a, b], c) => this.at(add(p, apply(R, [0.3 * a, 0.2 * b, 0.12 * c])));
        for (const side of [-1, 1]) this.line(CUBE.map((each) => corner(each, side)), "sky");
        for (const each of CUBE.slice(1)) this.line([corner(each, -1), corner(each, 1)], "sky");
        this.frame(UNITY, ORIGIN, "A", 0.75, true);
        this.frame(R, p, "B", 0.75);
        const twists = freedoms.map((f, i) => `ξ${i + 1}  ${row(f.v, 2)}  ${row(f.w, 2)}`);
        const count = `${freedoms.length} freedom${freedoms.length > 1 ? "s" : ""}, ${6 - freedoms.length} taken away`;
        const numbers = [count, "", `${" ".repeat(12)}v${" ".repeat(20)}ω`, ...twists, "", matrix("g", R.map((line, i) => [...line, p[i]]))].join("\n");
        return { numbers, words: `A ${values.type} joint with ${count}` };
      }, true);
      bench.choice("type", "joint", Object.keys(TYPES), n.type);
      const rows = [0, 1, 2].map((i) => bench.number(`q${i}`, "", -1, 1, 0.02, "", i ? 0.2 : 0.3));
      return bench;
    },

    two_link(stage, n) {
      const bench = new Bench(stage, function ({ theta1, theta2, flip, mixed }) {
        const [x, y] = this.arm(n, theta1, theta2, "ink", 1, true);
        const r = hypot(x, y);
        const clamp = (c) => acos(max(-1, min(1, c)));
        const alpha = clamp((n.l1 ** 2 + n.l2 ** 2 - r * r) / (2 * n.l1 * n.l2));
        const beta = r > 1e-9 ? clamp((r * r + n.l1 ** 2 - n.l2 ** 2) / (2 * n.l1 * r)) : 0;
        const here = sin(theta2 * RAD) < 0 ? 1 : -1; // the sign of the pair that the arm stands in
        const other = (a, b) => [(atan2(y, x) + b * beta) / RAD, wrapped((PI + a * alpha) / RAD)];
        const second = other(-here, -here);
        if (flip) this.arm(n, ...second, "green", 0.9);
        const wrong = other(here, -here);
        const missed = mixed ? this.arm(n, ...wrong, "orange", 0.9) : null;
        const numbers = [
          `x ${text(x)} m   y ${text(y)} m`, `r ${text(r)} m`, `α ${text(alpha / RAD, 1)}°  β ${text(beta / RAD, 1)}°`, "",
          `other solution`, `θ₁ ${text(wrapped(second[0]), 1)}°`, `θ₂ ${text(second[1], 1)}°`,
          missed ? `\nmixed signs miss by\n   ${text(hypot(missed[0] - x, missed[1] - y))} m` : "",
        ].join("\n");
        return { numbers, words: `A two-link arm, its tool at x ${x.toFixed(2)}, y ${y.toFixed(2)}` };
      });
      links(bench, n);
      bench.box("flip", "draw the other solution");
      bench.box("mixed", "draw what mixed signs give");
      return bench;
    },

    ellipsoid(stage, n) {
      const bench = new Bench(stage, function ({ theta1, theta2 }) {
        const [x, y] = this.arm(n, theta1, theta2, "ink", 1, true);
        const [ex, ey] = [n.l1 * cos(theta1 * RAD), n.l1 * sin(theta1 * RAD)];
        const J = [[-y, -(y - ey)], [x, x - ex]];
        const size = 0.4;
        const ring = Array.from({ length: 121 }, (_, i) => apply(J, [cos((i * PI) / 60), sin((i * PI) / 60)]));
        this.line(ring.map(([a, b]) => [this.scale * (x + size * a), -this.scale * (y + size * b)]), "orange");
        const sum = J.flat().reduce((all, each) => all + each * each, 0);
        const det = J[0][0] * J[1][1] - J[0][1] * J[1][0];
        const root = sqrt(max(0, sum * sum - 4 * det * det));
        const [most, least] = [sqrt((sum + root) / 2), sqrt(max(0, (sum - root) / 2))];
        const ratio = least > 1e-9 ? text(most / least, 2) : "      ∞";
        const numbers = [matrix("J", J), "", `σ₁ ${text(most)} m`, `σ₂ ${text(least)} m`, `det J  ${text(det, 4)} m²`, `σ₁/σ₂ ${ratio}`].join("\n");
        return { numbers, words: `The ellipse of velocities, its axes ${most.toFixed(2)} and ${least.toFixed(2)}` };
      });
      links(bench, n);
      return bench;
    },

    spline(stage, n) {
      const bench = new Bench(stage, function ({ kind, T, v0, v1 }) {
        const h = n.end - n.start;
        // In the share s = t/T; a quintic begins and ends without acceleration.
        const c = kind === "cubic"
          ? [n.start, v0 * T, 3 * h - (2 * v0 + v1) * T, -2 * h + (v0 + v1) * T]
          : [n.start, v0 * T, 0, 10 * h - (6 * v0 + 4 * v1) * T, -15 * h + (8 * v0 + 7 * v1) * T, 6 * h - 3 * (v0 + v1) * T];
        const derived = (p) => p.slice(1).map((x, i) => (x * (i + 1)) / T);
        const value = (p, s) => p.reduceRight((sum, x) => sum * s + x, 0);
        const lanes = [["θ [°]", c, "blue", ""], ["θ̇ [°/s]", derived(c), "orange", "7 3"], ["θ̈ [°/s²]", derived(derived(c)), "green", "2 3"]];
        const peaks = lanes.map(([name, p, colour, dash], k) => {
          const points = Array.from({ length: 201 }, (_, i) => value(p, i / 200));
          const [low, high] = [min(0, ...points), max(0, ...points)];
          const place = (y) => -125 + 84 * k + 70 * (1 - (y - low) / (high - low || 1)) + 4;
          this.line([[-100, place(0)], [140, place(0)]], "faint", { "stroke-width": 1 });
          this.line(points.map((y, i) => [-100 + 1.2 * i, place(y)]), colour, { "stroke-dasharray": dash });
          this.say([-125, -125 + 84 * k + 40], name, colour);
          return max(...points.map(abs));
        });
        const numbers = [`${T.toFixed(1)} s for ${h}°`, "", `fastest ${text(peaks[1], 1)} °/s`, `hardest ${text(peaks[2], 1)} °/s²`, "", `a(0) ${text(lanes[2][1][0] ?? 0, 1)} °/s²`].join("\n");
        return { numbers, words: `A ${kind} of ${T} seconds: ${peaks[1].toFixed(0)} degrees per second at most` };
      });
      bench.choice("kind", "kind", ["cubic", "quintic"], n.kind);
      bench.number("T", "duration", 0.5, 5, 0.1, " s", n.duration);
      bench.number("v0", "velocity at start", -100, 100, 5, " °/s", n.velocity_start);
      bench.number("v1", "velocity at end", -100, 100, 5, " °/s", n.velocity_end);
      return bench;
    },
  };

  const wrapped = (angle) => angle - 360 * Math.round(angle / 360);

  function links(bench, n) {
    bench.scale = 115 / (n.l1 + n.l2);
    bench.number("theta1", "θ₁", -180, 180, 1, "°", n.theta1);
    bench.number("theta2", "θ₂", -180, 180, 1, "°", n.theta2);
  }

  // Draw a two-link arm in the plane, with the edges of its workspace; where its tool is [m].
  Bench.prototype.arm = function (n, theta1, theta2, colour, opacity, edges = false) {
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
    [ORIGIN, elbow].forEach((each) => this.dot(at(each), "sky", 5));
    this.dot(at(tool), edges ? "blue" : colour, 5);
    return tool;
  };

  for (const stage of document.querySelectorAll("[data-slider]:not(.live)")) {
    SLIDERS[stage.dataset.slider]?.(stage, JSON.parse(stage.dataset.numbers)).start();
  }
})();
