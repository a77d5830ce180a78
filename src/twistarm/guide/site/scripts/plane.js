// Sliders in the plane: the two-link arm, its ellipse of velocities, splines.
"use strict";

(() => {
  const { Bench, numbers: helpers } = window.guide;
  const { RAD, apply, text, matrix, wrapped } = helpers;
  const { cos, sin, acos, atan2, hypot, abs, max, min, sqrt, PI } = Math;

  const HINT = [[110, 123], "drag the dots", "grey"];

  function links(bench, n) {
    bench.scale = 115 / (n.l1 + n.l2);
    bench.plays(bench.number("theta1", "θ₁", -180, 180, 1, "°", n.theta1));
    bench.number("theta2", "θ₂", -180, 180, 1, "°", n.theta2);
    handles(bench, n);
  }

  // The joint angles [°] that bring the tool to (x, y), or next to it, with the elbow on a side, 1 or -1.
  function angles({ l1, l2 }, x, y, side) {
    const r = max(abs(l1 - l2), min(l1 + l2, hypot(x, y)));
    const bend = side * acos(max(-1, min(1, (r * r - l1 * l1 - l2 * l2) / (2 * l1 * l2))));
    return [wrapped((atan2(y, x) - atan2(l2 * sin(bend), l1 + l2 * cos(bend))) / RAD), bend / RAD];
  }

  // The elbow and the tool are dragged, and the sliders follow: the elbow turns θ₁, the tool keeps the elbow's side.
  function handles(bench, n) {
    const { svg } = bench;
    let [held, side] = [undefined, 1];
    svg.addEventListener("pointerdown", ({ button, pointerId, target }) => {
      if (button !== 0 || !(held = target.dataset.handle)) return;
      side = bench.values.theta2 < 0 ? -1 : 1;
      svg.setPointerCapture(pointerId);
    });
    for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, () => { held = undefined; });
    svg.addEventListener("pointermove", ({ clientX, clientY }) => {
      if (!held) return;
      const at = new DOMPoint(clientX, clientY).matrixTransform(svg.getScreenCTM().inverse());
      const [x, y] = [at.x / bench.scale, -at.y / bench.scale];
      const [theta1, theta2] = held === "tool" ? angles(n, x, y, side) : [atan2(y, x) / RAD, bench.values.theta2];
      bench.slide("theta1", theta1);
      bench.slide("theta2", theta2);
    });
  }

  window.guide.plane = {
    two_link(stage, n) {
      const bench = new Bench(stage, function ({ theta1, theta2, flip, mixed }) {
        const [x, y] = this.arm(n, theta1, theta2, "ink", 1, true);
        this.say(...HINT);
        const r = hypot(x, y);
        const place = [`x ${text(x)} m   y ${text(y)} m`, `r ${text(r)} m`];
        const words = `A two-link arm, its tool at x ${x.toFixed(2)}, y ${y.toFixed(2)}`;
        if (!n.inverse) return { numbers: place.join("\n"), words };
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
          ...place, `α ${text(alpha / RAD, 1)}°  β ${text(beta / RAD, 1)}°`, "",
          `other solution`, `θ₁ ${text(wrapped(second[0]), 1)}°`, `θ₂ ${text(second[1], 1)}°`,
          missed ? `\nmixed signs miss by\n   ${text(hypot(missed[0] - x, missed[1] - y))} m` : "",
        ].join("\n");
        return { numbers, words };
      });
      links(bench, n);
      if (n.inverse) {
        bench.box("flip", "draw the other solution");
        bench.box("mixed", "draw what mixed signs give");
      }
      return bench;
    },

    ellipsoid(stage, n) {
      const bench = new Bench(stage, function ({ theta1, theta2 }) {
        const [x, y] = this.arm(n, theta1, theta2, "ink", 1, true);
        this.say(...HINT);
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
        // In the share of the time, u = t/T; a quintic begins and ends without acceleration.
        const c = kind === "cubic"
          ? [n.start, v0 * T, 3 * h - (2 * v0 + v1) * T, -2 * h + (v0 + v1) * T]
          : [n.start, v0 * T, 0, 10 * h - (6 * v0 + 4 * v1) * T, -15 * h + (8 * v0 + 7 * v1) * T, 6 * h - 3 * (v0 + v1) * T];
        const derived = (p) => p.slice(1).map((x, i) => (x * (i + 1)) / T);
        const value = (p, u) => p.reduceRight((sum, x) => sum * u + x, 0);
        const lanes = [["θ [°]", c, "blue", ""], ["θ̇ [°/s]", derived(c), "orange", "7 3"], ["θ̈ [°/s²]", derived(derived(c)), "green", "2 3"]];
        const peaks = lanes.map(([name, p, colour, dash], k) => {
          const points = Array.from({ length: 201 }, (_, i) => value(p, i / 200));
          const [low, high] = [min(0, ...points), max(0, ...points)];
          const place = (y) => -125 + 84 * k + 70 * (1 - (y - low) / (high - low || 1)) + 4;
          this.line([[-78, place(0)], [142, place(0)]], "faint", { "stroke-width": 1 });
          this.line(points.map((y, i) => [-78 + 1.1 * i, place(y)]), colour, { "stroke-dasharray": dash });
          this.say([-125, -125 + 84 * k + 40], name, colour);
          for (const y of [low, high]) if (y) this.say([-100, place(y)], y.toFixed(0).replace("-", "−"), "grey");
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
})();
