// Lit solids of the theory's drawings; what stands before one lets it shine through.

import { THREE } from "./view.js";

const GHOST = 0.3; // opacity where something stands in front
const UP = new THREE.Vector3(0, 1, 0); // along which three.js's cylinders and cones stand

export const LINEAR = 0x7c5cff; // what is linear, and what is angular
export const ANGULAR = 0xf0642f;
export const AXIS = 0x2f86e0;

// Of what a layer shows.
export function hidden(view) {
  const group = Object.assign(new THREE.Group(), { visible: false });
  view.viewer.scene.add(group);
  return group;
}

// A mesh, and its copy that is seen through everything.
export function solid(geometry, color) {
  const look = { color, emissive: color, emissiveIntensity: 0.35 };
  const made = new THREE.Group();
  made.add(new THREE.Mesh(geometry, new THREE.MeshLambertMaterial(look)));
  made.add(new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ ...look, transparent: true, opacity: GHOST, depthTest: false })));
  return made;
}

export const rod = (color) => solid(new THREE.CylinderGeometry(1, 1, 1, 16), color);

export class Arrow {
  constructor(color, radius) {
    this.radius = radius;
    this.group = new THREE.Group();
    this.shaft = rod(color);
    this.head = solid(new THREE.ConeGeometry(1, 1, 20), color);
    this.group.add(this.shaft, this.head);
  }

  // `along` as long as it is drawn; one too short to be seen is not drawn.
  set(origin, along) {
    const length = along.length();
    this.group.visible = length > this.radius;
    if (!this.group.visible) return;
    const head = Math.min(6 * this.radius, 0.6 * length);
    this.group.position.copy(origin);
    this.group.quaternion.setFromUnitVectors(UP, along.clone().normalize());
    this.shaft.position.set(0, (length - head) / 2, 0);
    this.shaft.scale.set(this.radius, length - head, this.radius);
    this.head.position.set(0, length - head / 2, 0);
    this.head.scale.set(2.6 * this.radius, head, 2.6 * this.radius);
  }
}

export const vector = (numbers) => new THREE.Vector3(...numbers);

// Column `i` of a matrix given by rows, from row `first` on.
export const column = (rows, i, first = 0) => new THREE.Vector3(rows[first][i], rows[first + 1][i], rows[first + 2][i]);
