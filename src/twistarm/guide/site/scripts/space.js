// Sliders in space: frames, an axis and an angle, a screw, the six types of joint.
"use strict";

(() => {
  const { Bench, numbers: helpers } = window.guide;
  const { RAD, UNITY, ORIGIN, add, times, dot, cross, unit, product, apply, turned, euler, screwed, trace, angleOf, text, row, matrix } = helpers;
  const { cos, sin, abs, atan2, PI } = Math;

  window.guide.space = {
    frame(stage, n) {
      const proper = n.order[0] === n.order[2];
      const bench = new Bench(stage, function ({ alpha, beta, gamma }) {
        this.scale = 92;
        const R = euler(n.order, [alpha, beta, gamma].map((x) => x * RAD));
        this.frame(UNITY, ORIGIN, "S", 1, true);
        this.frame(R, ORIGIN, "T", 1);
        const fails = proper ? abs(sin(beta * RAD)) : abs(cos(beta * RAD));
        const numbers = [
          matrix("R", R), "",
          `angle of R ${text(angleOf(R), 1)}°`,
          `α + γ      ${text(alpha + gamma, 0)}°`,
          `α − γ      ${text(alpha - gamma, 0)}°`,
          `${proper ? "sin β" : "cos β"}      ${text(proper ? sin(beta * RAD) : cos(beta * RAD))}`,
          fails < 1e-9 ? "two axes in one line:\none freedom is lost" : "",
        ].join("\n");
        return { numbers, words: `Frame T, turned by ${n.order} angles ${alpha}, ${beta}, ${gamma} degrees` };
      }, true);
      bench.plays(bench.number("alpha", `α about ${n.order[0].toLowerCase()}`, -180, 180, 5, "°", n.alpha));
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
        this.frame(UNITY, ORIGIN, "S", 1, true);
        this.frame(R, ORIGIN, "T", 1);
        const path = Array.from({ length: 61 }, (_, i) => this.at(apply(turned(w, (angle * RAD * i) / 60), [1, 0, 0])));
        this.line(path, "grey", { "stroke-width": 1.4 });
        const Q = [cos((angle * RAD) / 2), ...times(sin((angle * RAD) / 2), w)];
        const numbers = [
          `ω   ${row(w)}`, matrix("R", R), "",
          `trace R ${text(trace(R))} = 1 + 2 cos θ`,
          `angle of R ${text(angleOf(R), 1)}°`,
          `Q   ${row(Q)}`,
        ].join("\n");
        return { numbers, words: `Frame T, turned by ${angle} degrees about an axis` };
      }, true);
      bench.plays(bench.number("angle", "angle θ", -360, 360, 5, "°", n.angle));
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
        this.frame(UNITY, ORIGIN, "S", 0.7, true);
        this.frame(R, p, "T", 0.7);
        const g = R.map((line, i) => [...line, p[i]]);
        const numbers = [`v   ${row(v)}`, `ω   ${row(w)}`, "", matrix("g", [...g, [0, 0, 0, 1]]), "", `along the axis ${text(dot(p, w))} m`].join("\n");
        return { numbers, words: `A frame moved by ${angle} degrees along a screw of pitch ${pitch}` };
      }, true);
      bench.plays(bench.number("angle", "θ", -360, 720, 10, "°", n.angle));
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
        this.frame(UNITY, ORIGIN, "S", 0.75, true);
        this.frame(R, p, "T", 0.75);
        const twists = freedoms.map((f, i) => `ξ${i + 1}  ${row(f.v, 2)}  ${row(f.w, 2)}`);
        const count = `${freedoms.length} freedom${freedoms.length > 1 ? "s" : ""}, ${6 - freedoms.length} taken away`;
        const numbers = [count, "", `${" ".repeat(12)}v${" ".repeat(20)}ω`, ...twists, "", matrix("g", R.map((line, i) => [...line, p[i]]))].join("\n");
        return { numbers, words: `A ${values.type} joint with ${count}` };
      }, true);
      bench.choice("type", "joint", Object.keys(TYPES), n.type);
      const rows = [0, 1, 2].map((i) => bench.number(`q${i}`, "", -1, 1, 0.02, "", i ? 0.2 : 0.3));
      bench.plays(rows[0]);
      return bench;
    },
  };
})();
