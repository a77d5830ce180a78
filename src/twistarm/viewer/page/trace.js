// Where the tool has been since the trace was switched on, on this page.

import { dispose } from "./disposal.js";
import { hidden } from "./solids.js";
import { THREE } from "./view.js";

const STEP = 0.006; // of the arm's size, between points
const JUMP = 0.25; // a step of this size is no way that the tool took
const LONGEST = 50; // points of a piece: only the last piece is made again with every point
const MOST = 60; // pieces; then the oldest goes
const COLOR = 0x7aa61c;

export class Trace {
  constructor(view) {
    this.view = view;
    this.group = hidden(view);
    this.holder = new THREE.Group(); // of the last piece
    this.pieces = []; // lists of points, each with a mesh in the group once it has two
    this.piece = []; // the last of them
  }

  build(axes) {
    this.size = axes.size;
    this.clear();
  }

  clear() {
    dispose(this.group);
    this.pieces = [];
    this.piece = [];
    this.view.viewer.set_dirty();
  }

  follow(position) {
    if (!this.group.visible) return;
    const last = this.piece[this.piece.length - 1];
    const step = last ? last.distanceTo(position) : Infinity;
    if (step < STEP * this.size) return;
    if (step > JUMP * this.size) this.begin([]);
    else if (this.piece.length === LONGEST) this.begin([last]);
    this.piece.push(position.clone());
    this.draw();
  }

  begin(points) {
    this.piece = points;
    this.pieces.push(points);
    this.holder = new THREE.Group();
    this.group.add(this.holder);
    if (this.pieces.length <= MOST) return;
    this.pieces.shift();
    dispose(this.group.children[0]);
    this.group.remove(this.group.children[0]);
  }

  draw() {
    const points = this.piece;
    if (points.length < 2) return;
    dispose(this.holder);
    const tube = new THREE.TubeGeometry(new THREE.CatmullRomCurve3(points), 3 * points.length, 0.0032 * this.size, 6);
    this.holder.add(new THREE.Mesh(tube, new THREE.MeshLambertMaterial({ color: COLOR, emissive: COLOR, emissiveIntensity: 0.4 })));
  }
}
