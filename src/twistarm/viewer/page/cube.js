// A cube that turns with the view and says from which side the arm is seen; a press on a face goes to that side. Made of
// the page's own elements: it takes no pixel of the view's to draw.

import { $, button, element } from "./element.js";
import { SIDES } from "./presets.js";
import { THREE } from "./view.js";

const HALF = 27; // of an edge, px
const FAR = 1.8; // of an axis' letter from the middle, in half edges of the face that it goes through
const UP = { top: [0, 1, 0], bottom: [0, 1, 0] }; // on the face; z on the others

export class Cube {
  constructor(view, go) {
    this.view = view;
    this.box = element("div");
    this.box.id = "cube";
    Object.assign(this.box, { role: "group", ariaLabel: "Look from" });
    this.body = element("div", "body");
    this.body.append(...Object.keys(SIDES).filter((name) => name !== "iso").map((name) => face(name, go)));
    this.letters = ["x", "y", "z"].map((name) => element("span", `axis ${name}`, name));
    this.box.append(this.body, ...this.letters);
    $("top").append(this.box);
    view.afterRender(() => this.follow());
  }

  // With every picture. CSS has y down, hence the mirror, which each face undoes.
  follow() {
    const { scene, camera } = this.view.viewer;
    const base = camera.matrixWorldInverse.clone().multiply(scene.matrixWorld);
    const turn = new THREE.Matrix4().makeScale(1, -1, 1).multiply(new THREE.Matrix4().extractRotation(base));
    this.body.style.transform = `matrix3d(${turn.elements.map((number) => number.toFixed(5))})`;
    this.letters.forEach((letter, i) => {
      const at = new THREE.Vector3().setComponent(i, FAR * HALF).applyMatrix4(turn);
      letter.style.transform = `translate(${at.x.toFixed(1)}px, ${at.y.toFixed(1)}px)`;
      letter.style.zIndex = at.z > 0 ? 1 : -1;
      letter.hidden = Math.hypot(at.x, at.y) < HALF / 2; // over the name of the face
    });
  }
}

function face(name, go) {
  const made = button("", name, `Look from the ${name}`, () => go(name));
  const out = new THREE.Vector3(...SIDES[name].map(Math.round));
  const up = new THREE.Vector3(...(UP[name] ?? [0, 0, 1]));
  const right = new THREE.Vector3().crossVectors(up, out);
  const place = new THREE.Matrix4().makeBasis(right, up.negate(), out).setPosition(out.clone().multiplyScalar(HALF));
  made.style.transform = `matrix3d(${place.elements})`;
  return made;
}
