// Figures in space: their lines and letters have places in space, and move on the drawing as the reader turns it.
"use strict";

(() => {
  const { Eye, player } = window.guide;
  const SECONDS = 4; // of a motion
  const numbers = (text) => text.trim().split(" ").map(Number);
  const triples = (list) => Array.from({ length: list.length / 3 }, (_, i) => list.slice(3 * i, 3 * i + 3));
  // Moments of a motion (;), each of lines (|), each of points.
  const moments = (text) => text.split(";").map((moment) => moment.split("|").map((line) => triples(numbers(line))));

  class Figure {
    constructor(picture) {
      this.items = [...picture.querySelectorAll("[data-at]")].map((element) => ({
        element,
        paths: element.querySelectorAll(":scope > path"),
        markers: element.querySelectorAll("use"),
        letters: element.dataset.letters !== undefined,
        centre: numbers(element.closest("[data-centre]").dataset.centre),
        moments: moments(element.dataset.at),
      }));
      this.share = 1;
      const [azim, elev] = numbers(picture.querySelector("[data-eye]").dataset.eye);
      this.eye = new Eye(picture, azim, elev, () => this.show());
      this.first = this.eye.look();
      this.stacks(picture.querySelector("svg"), [...picture.querySelectorAll("[data-eye]")]);
      if (this.items.some((item) => item.moments.length > 1)) this.plays(picture);
    }

    // On a telephone the panels stand one below the other.
    stacks(svg, panels) {
      const narrow = matchMedia("(max-width: 36rem)");
      const [, , width, height] = numbers(svg.getAttribute("viewBox"));
      const stack = () => {
        const [rows, step] = narrow.matches ? [panels.length, width / panels.length] : [1, 0];
        svg.setAttribute("viewBox", `0 0 ${width - step * (rows - 1)} ${rows * height}`);
        panels.forEach((panel, i) => panel.setAttribute("transform", `translate(${-i * step} ${i * height * Number(rows > 1)})`));
      };
      narrow.addEventListener("change", stack);
      stack();
    }

    plays(picture) {
      const input = Object.assign(document.createElement("input"), { type: "range", min: 0, max: 1, step: "any", value: 1 });
      input.setAttribute("aria-label", "Moment of the motion");
      input.addEventListener("input", () => {
        this.share = Number(input.value);
        this.show();
      });
      const row = Object.assign(document.createElement("div"), { className: "player" });
      row.append(player(input, SECONDS), input);
      picture.after(row);
    }

    show() {
      const look = this.eye.look();
      for (const item of this.items) this.place(item, (point) => look(point).map((x, i) => x + item.centre[i]));
    }

    place({ element, paths, markers, letters, centre, ...item }, at) {
      const lines = between(item.moments, this.share).map((line) => line.map(at));
      if (letters) {
        const [x, y] = this.first(item.moments.at(-1)[0][0]).map((each, i) => lines[0][0][i] - each - centre[i]);
        element.setAttribute("transform", `translate(${x.toFixed(2)} ${y.toFixed(2)})`);
        return;
      }
      const written = (line) => line.map(([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`).join("L");
      paths.forEach((path, i) => path.setAttribute("d", `M${written(lines[i])}`));
      markers.forEach((marker, i) => {
        marker.setAttribute("x", lines[0][i][0]);
        marker.setAttribute("y", lines[0][i][1]);
      });
    }
  }

  // Lines at a share of the motion, between its moments.
  function between(all, share) {
    const [whole, part] = [Math.floor(share * (all.length - 1)), (share * (all.length - 1)) % 1];
    if (part === 0) return all[whole];
    return all[whole].map((line, i) => line.map((point, j) => point.map((x, k) => x + part * (all[whole + 1][i][j][k] - x))));
  }

  const pictures = [...document.querySelectorAll("[data-eye]")].map((panel) => panel.closest(".picture"));
  for (const picture of new Set(pictures)) if (!picture.closest(".stage, .still")) new Figure(picture);
})();
