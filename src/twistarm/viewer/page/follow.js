// The camera follows tool and target: none of them leaves the picture by its own motion.

import { inside, kept } from "./framing.js";
import { eases } from "./glide.js";
import { THREE } from "./view.js";

const TIME = 120; // ms in which the rest of the way shrinks to a third
const LEAVES = 0.94; // of the way from the middle of the picture to its edge: from here the camera follows
const STAYS = 0.8; // how far inside the camera brings them
const THERE = 1e-3; // of the arm's radius
const NEAREST = 0.1; // of it, from the camera

export class Follow {
  // While one of the `presets` moves the camera, it does not follow.
  constructor(view, presets) {
    this.view = view;
    this.presets = presets;
    this.places = new Map(); // of tool and target, in the world
    this.moving = 0;
    this.held = false; // by a hand that turns the view
    view.follow = this;
    view.viewer.controls.addEventListener("start", () => this.stop(true));
    view.viewer.controls.addEventListener("end", () => (this.held = false));
  }

  hello() {
    this.places.clear();
    this.stop(this.held);
  }

  placed({ transforms }) {
    this.put("tool", new THREE.Vector3().fromArray(transforms["/frames/tool"], 12));
  }

  // `name` stands at `place` [m, in base axes] now; null: there is none. What was out of the picture before it moved is
  // not followed: somebody looks at something else.
  put(name, place) {
    const before = this.places.get(name);
    this.places.delete(name);
    if (!place) return;
    const now = this.view.viewer.scene.localToWorld(place.clone());
    this.places.set(name, now);
    if (before?.equals(now) || this.moving !== 0 || this.held || this.view.radius === undefined) return;
    if ((!before || this.sees(before, 1)) && !this.sees(now, LEAVES)) this.step(performance.now());
  }

  sees(place, share) {
    return inside(place, this.view.viewer.camera, this.view.free, share);
  }

  step(last) {
    const { view, places } = this;
    this.stop(this.held);
    if (this.presets.moving !== 0 || places.size === 0) return;
    const { camera, controls } = view.viewer;
    const base = new THREE.Vector3();
    const points = [...places.values(), ...(this.sees(base, 1) ? [base] : [])];
    const towards = camera.position.clone().sub(controls.target).normalize();
    const way = kept(points, towards, camera, view.free, STAYS, NEAREST * view.radius).sub(camera.position);
    const now = performance.now();
    const rest = eases() ? Math.exp((last - now) / TIME) : 0; // of the way
    if (rest * way.length() > THERE * view.radius) this.moving = requestAnimationFrame(() => this.step(now));
    way.multiplyScalar(1 - rest);
    camera.position.add(way);
    controls.target.add(way.clone().projectOnPlane(towards)); // it goes back from what it looks at
    controls.update();
    camera.updateMatrixWorld();
    view.viewer.set_dirty();
  }

  stop(held) {
    cancelAnimationFrame(this.moving);
    this.moving = 0;
    this.held = held;
  }
}
