// What was asked and is not met: the tool's frame there, as far as the target names it, and the arm as it would have to
// stand without its limits, faintly.

import { dispose } from "./disposal.js";
import { THREE } from "./view.js";

const SIZE = 0.22; // of the frame, beside the arm's radius
const THIN = 0.018; // of its rods, beside their length
const COLORS = [0xe0352b, 0x1f9d3a, 0x2f6fe4]; // x, y, z
const FRAME = 0.55; // opacities
const ARM = 0.22;
const NAMED = { pose: [0, 1, 2], approach: [2], position: [] }; // the axes of which a target speaks
const BEHIND = { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2 }; // where the arm stands as asked, it is seen
const ABOVE = 10; // drawn after the arm, before the handles

export class Ghost {
  constructor(view) {
    this.view = view;
    this.copies = [];
    this.late = null;
    this.frame = new THREE.Group();
    this.arm = new THREE.Group();
    view.viewer.scene.add(this.frame, this.arm);
    this.messages = { target: (message) => this.show(message) };
  }

  hello() {
    this.clear();
  }

  // The arm stands, and its size is known.
  placed() {
    if (this.late) this.show(this.late);
  }

  clear() {
    dispose(this.frame);
    for (const { copy } of this.copies) copy.material.dispose(); // the geometry is that of what is drawn
    this.copies = [];
    this.arm.clear();
  }

  show(message) {
    this.late = this.view.radius === undefined ? message : null;
    if (this.late) return;
    const { given, met, ghost } = message;
    const stood = this.copies.length > 0 && ghost !== null;
    if (!stood) this.clear();
    dispose(this.frame);
    if (given !== null && !met) this.drawFrame(given);
    if (ghost !== null) this.drawArm(ghost, stood);
    this.view.viewer.set_dirty();
  }

  drawFrame({ kind, position, xyzw }) {
    const length = SIZE * this.view.radius;
    this.frame.position.fromArray(position);
    this.frame.quaternion.fromArray(xyzw);
    const axes = NAMED[kind].map((axis) => rod(axis, length));
    const ball = new THREE.Mesh(new THREE.SphereGeometry(2.2 * THIN * length, 20, 12), faint(warning(), FRAME, false));
    for (const part of [...axes, ball]) this.frame.add(Object.assign(part, { renderOrder: ABOVE }));
  }

  // `stood`: copies are there already, and take other places.
  drawArm(transforms, stood) {
    const { scene } = this.view.viewer;
    if (!stood) this.copy(Object.keys(transforms));
    scene.updateMatrixWorld(true);
    for (const { path, source, copy } of this.copies) {
      const inNode = this.view.node(path).matrixWorld.clone().invert().multiply(source.matrixWorld);
      copy.matrix.fromArray(transforms[path]).multiply(inNode);
    }
  }

  copy(paths) {
    for (const path of paths) {
      this.view.node(path).traverse((source) => {
        if (!source.isMesh || source.material.depthTest === false) return;
        const copy = new THREE.Mesh(source.geometry, faint(warning(), ARM, true));
        Object.assign(copy, { matrixAutoUpdate: false, renderOrder: ABOVE - 1 });
        this.copies.push({ path, source, copy });
        this.arm.add(copy);
      });
    }
  }
}

function warning() {
  return new THREE.Color(getComputedStyle(document.documentElement).getPropertyValue("--warn").trim());
}

// `solid`: seen only where nothing stands before it, and one surface deep.
function faint(color, opacity, solid) {
  return new THREE.MeshLambertMaterial({ color, emissive: color, emissiveIntensity: 0.35, transparent: true, opacity, depthTest: solid, depthWrite: solid, ...(solid && BEHIND) });
}

function rod(axis, length) {
  const made = new THREE.CylinderGeometry(THIN * length, THIN * length, length, 12).translate(0, length / 2, 0);
  const to = new THREE.Vector3().setComponent(axis, 1);
  made.applyQuaternion(new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), to));
  return new THREE.Mesh(made, faint(new THREE.Color(COLORS[axis]), FRAME, false));
}
