// The floor: a grid of 1, 2 or 5 times a power of ten metres, a bar of that length with its label, and the arm's shadow.

import { dispose } from "./disposal.js";
import { element, styled } from "./element.js";
import { Pins } from "./pins.js";

const { THREE } = MeshCat;
const REACH = 5; // how far the grid reaches, in radii of the arm
const CELL = 0.4; // of a wide cell, in radii
const FINER = { 1: 5, 2: 4, 5: 5 }; // narrow cells in a wide one, by its first digit
const THICK = 0.02; // of the bar, beside its length
const PLACE = [-0.65, 0.25]; // of the bar: from the middle, and above the lower edge of what is free of the picture
const LONGEST = 0.5; // of the bar, beside the width of the picture

export class Floor {
  /** @type {number} in m */ cell;

  constructor(view) {
    this.view = view;
    this.group = new THREE.Group();
    this.lines = new THREE.Group();
    this.bar = new THREE.Mesh(new THREE.BoxGeometry(1, 1, 1), new THREE.MeshBasicMaterial());
    this.group.add(this.lines, this.bar);
    view.viewer.scene.add(this.group);
    this.text = element("span");
    this.middle = new THREE.Vector3();
    this.pins = new Pins(view, "scale");
    this.pins.show([{ layer: "floor", node: "/floor", at: this.middle, text: this.text }]);
  }

  // Under an arm of this size, at the height z [m], in the colours of the page.
  lay(radius, z) {
    dispose(this.lines);
    const colour = new THREE.Color(styled("--grid"));
    const reach = REACH * radius;
    this.cell = nice(CELL * radius);
    const fine = this.cell / FINER[this.cell.toExponential()[0]];
    this.lines.add(grid(fine, reach, colour, 0.45), grid(this.cell, reach, colour, 0.9), shade(reach));
    this.group.position.z = z - 1e-4 * radius;
    this.bar.material.color.set(styled("--quiet"));
  }

  // Put the bar along the edge of a cell that is seen at its place, across the picture.
  measure(scene, camera) {
    const { group, bar, middle, text } = this;
    const seen = (point) => scene.localToWorld(point.clone()).project(camera);
    const caster = new THREE.Raycaster();
    caster.setFromCamera(new THREE.Vector2(PLACE[0], -1 + 2 * this.view.free.bottom + PLACE[1]), camera);
    const ray = caster.ray.applyMatrix4(scene.matrixWorld.clone().invert());
    const found = ray.intersectPlane(new THREE.Plane(new THREE.Vector3(0, 0, 1), -group.position.z), new THREE.Vector3());
    const near = found && Math.hypot(found.x, found.y) < REACH * this.view.radius;
    bar.visible = Boolean(near);
    this.pins.layer.hidden = !near;
    if (!near) return;
    const right = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0).transformDirection(scene.matrixWorld.clone().invert());
    const axis = Math.abs(right.x) > Math.abs(right.y) ? "x" : "y";
    const stretched = (length) => {
      const start = new THREE.Vector3(...["x", "y"].map((side) => length * Math.round(found[side] / length)), group.position.z);
      const end = start.clone();
      end[axis] += length;
      middle.addVectors(start, end).multiplyScalar(0.5);
      bar.scale.set(THICK * length, THICK * length, THICK * length / 4)[axis] = length;
      return seen(start).distanceTo(seen(end)) / (2 * LONGEST);
    };
    const share = stretched(this.cell);
    const length = share > 1 ? nice(this.cell / share / 1.5) : this.cell;
    if (share > 1) stretched(length);
    const words = `${Number(length.toPrecision(1))} m`;
    if (text.textContent !== words) text.textContent = words; // else each picture would lay the page out anew
    bar.position.copy(middle).setZ(0);
    bar.updateMatrixWorld();
  }
}

function nice(length) {
  const ten = 10 ** Math.floor(Math.log10(length));
  const off = (step) => Math.abs(Math.log((step * ten) / length));
  return Number((ten * [1, 2, 5, 10].reduce((best, step) => (off(step) < off(best) ? step : best))).toPrecision(1));
}

function grid(cell, reach, { r, g, b }, opacity) {
  const count = Math.floor(reach / cell);
  const steps = Array.from({ length: 2 * count + 1 }, (_, i) => (i - count) * cell);
  const places = [];
  for (const across of steps) {
    for (const along of steps.slice(0, -1)) {
      const [here, there] = [along, along + cell];
      places.push([across, here], [across, there], [here, across], [there, across]);
    }
  }
  const alpha = (x, y) => opacity * Math.max(0, 1 - Math.hypot(x, y) / reach) ** 1.5;
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(places.flatMap(([x, y]) => [x, y, 0]), 3));
  geometry.setAttribute("color", new THREE.Float32BufferAttribute(places.flatMap(([x, y]) => [r, g, b, alpha(x, y)]), 4));
  const material = new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false });
  return new THREE.LineSegments(geometry, material);
}

function shade(reach) {
  const plane = new THREE.PlaneGeometry(2 * reach, 2 * reach);
  const floor = new THREE.Mesh(plane, new THREE.ShadowMaterial({ opacity: 0.2, depthWrite: false }));
  floor.receiveShadow = true;
  return floor;
}
