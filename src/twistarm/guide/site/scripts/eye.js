// The eye on a drawing in space, moved by hand: pointer, fingers, keys, wheel.
"use strict";

(() => {
  const { RAD, dot } = window.guide.numbers;
  const { cos, sin, exp, hypot, max, min } = Math;
  const STEP = 5; // degrees by a key
  const PACE = 0.5; // degrees by a pixel
  const KEYS = {
    ArrowLeft: (eye) => eye.turn(STEP, 0), ArrowRight: (eye) => eye.turn(-STEP, 0), ArrowUp: (eye) => eye.turn(0, -STEP), ArrowDown: (eye) => eye.turn(0, STEP),
    "+": (eye) => eye.near(1.2), "-": (eye) => eye.near(1 / 1.2), 0: (eye) => eye.back(),
  };

  window.guide.Eye = class {
    // Degrees about z and above the floor; `show` draws anew.
    constructor(element, azim, elev, show) {
      Object.assign(this, { start: { azim, elev, zoom: 1 }, show, fingers: new Map() });
      Object.assign(this, this.start);
      element.tabIndex = 0;
      element.classList.add("turns");
      element.setAttribute("aria-roledescription", "drawing to turn");
      element.setAttribute("aria-keyshortcuts", Object.keys(KEYS).join(" "));
      element.title = "Drag or arrow keys: turn. Ctrl and wheel, two fingers, + or −: zoom. 0: as at first.";
      element.addEventListener("pointerdown", (event) => this.grab(element, event));
      element.addEventListener("pointermove", (event) => this.pull(event));
      for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, ({ pointerId }) => this.fingers.delete(pointerId));
      // Without a key the wheel scrolls the page.
      element.addEventListener("wheel", (event) => {
        if (!event.ctrlKey && !event.metaKey) return;
        event.preventDefault();
        this.near(exp(-event.deltaY / 300));
      }, { passive: false });
      element.addEventListener("keydown", (event) => {
        if (!Object.hasOwn(KEYS, event.key) || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        KEYS[event.key](this);
      });
    }

    grab(element, { button, pointerId, clientX, clientY }) {
      if (button !== 0) return;
      element.setPointerCapture(pointerId);
      this.fingers.set(pointerId, [clientX, clientY]);
    }

    pull({ pointerId, clientX, clientY }) {
      if (!this.fingers.has(pointerId)) return;
      const [x, y] = this.fingers.get(pointerId);
      const before = this.apart();
      this.fingers.set(pointerId, [clientX, clientY]);
      if (this.fingers.size > 1) this.near(this.apart() / before);
      else this.turn(PACE * (x - clientX), PACE * (clientY - y));
    }

    apart() {
      const [[a, b], [c, d]] = [...this.fingers.values(), [0, 0]];
      return hypot(a - c, b - d) || 1;
    }

    turn(about, above) {
      this.azim += about;
      this.elev = max(-90, min(90, this.elev + above));
      this.show();
    }

    near(factor) {
      this.zoom = max(0.5, min(5, this.zoom * factor));
      this.show();
    }

    back() {
      Object.assign(this, this.start);
      this.show();
    }

    // A function from points to their places on the drawing, y downwards.
    look() {
      const [a, e] = [this.azim * RAD, this.elev * RAD];
      const right = [-sin(a), cos(a), 0];
      const down = [sin(e) * cos(a), sin(e) * sin(a), -cos(e)];
      return (point) => [this.zoom * dot(right, point), this.zoom * dot(down, point)];
    }
  };
})();
