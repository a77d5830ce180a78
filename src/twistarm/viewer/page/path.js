// The way of the tool: as it is followed, the ideal beside it, the arm faintly at the poses, and where it comes no farther.

import { ArmCopy, coloured } from "./arm_copy.js";
import { dispose } from "./disposal.js";
import { element } from "./element.js";
import { Pins } from "./pins.js";
import { THREE } from "./view.js";

const FOLLOWED = 0xe8850c;
const IDEAL = "--quiet";
const STOP = "--warn";
const THIN = 0.55; // the ideal, beside what is followed: within it, seen where the two part
const BALL = 3.2; // the end, beside the line's radius
const POSE = 0.13; // opacities
const STOPPED = 0.3;
/** @type {any} */
const NOTHING = { points: [], ideal: [], radius: 0, waypoints: [], ids: [], stopped: null };

export class Path {
  constructor({ view, links }) {
    this.view = view;
    this.links = links;
    this.data = NOTHING;
    this.lines = new THREE.Group();
    this.arms = [];
    this.hit = []; // numbers of the poses in collision
    this.listed = null; // those of the list, where there is one
    this.pins = new Pins(view, "stops");
    this.messages = { path: (message) => this.show(message), colliding: ({ poses }) => this.collide(poses), program: ({ poses }) => this.list(poses) };
    view.onDrawn.push(() => this.drawArms()); // what they are copies of has changed
  }

  hello() { this.show(NOTHING); }

  show(message) {
    this.data = message;
    this.view.node("/path").add(this.lines);
    this.drawLines();
    this.drawArms();
    this.mark();
    if (this.shown && this.view.radius !== undefined) this.view.reframe();
    this.view.viewer.set_dirty();
  }

  get shown() {
    const { points, ideal, stopped } = this.data;
    return points.length + ideal.length > 0 || stopped !== null;
  }

  drawLines() {
    const { points, ideal, radius, stopped } = this.data;
    dispose(this.lines);
    if (points.length > 1) this.lines.add(tube(points, radius, new THREE.Color(FOLLOWED)));
    if (ideal.length > 1) this.lines.add(tube(ideal, THIN * radius, coloured(IDEAL)));
    if (stopped === null) return;
    const ball = new THREE.Mesh(new THREE.SphereGeometry(BALL * radius, 20, 12), lit(coloured(STOP)));
    ball.position.fromArray(stopped.position);
    this.lines.add(ball);
  }

  drawArms() {
    const { waypoints, ids, stopped } = this.data;
    for (const arm of this.arms) arm.remove();
    const stood = waypoints.filter((_, i) => this.listed?.includes(ids[i]) ?? true);
    const hit = waypoints.filter((_, i) => this.hit.includes(ids[i]));
    this.arms = stood.map((theta) => this.stood(theta, ...(hit.includes(theta) ? [STOP, STOPPED] : [IDEAL, POSE])));
    if (stopped !== null) this.arms.push(this.stood(stopped.arm, STOP, STOPPED));
  }

  // A pose that is gone has no arm.
  list(poses) {
    const ids = poses.map(({ id }) => id);
    if (ids.join() === this.listed?.join()) return;
    this.listed = ids;
    this.drawArms();
    this.view.viewer.set_dirty();
  }

  collide(poses) {
    if (poses.join() === this.hit.join()) return;
    this.hit = poses;
    this.drawArms();
    this.view.viewer.set_dirty();
  }

  stood(theta, colour, opacity) {
    const arm = new ArmCopy(this.view, colour, opacity);
    arm.stand(this.links(theta));
    this.view.node("/path").add(arm.group);
    return arm;
  }

  mark() {
    const { stopped } = this.data;
    const pin = () => ({ layer: "path", node: "/path", at: new THREE.Vector3(...stopped.position), text: element("span", "", stopped.words), whole: true });
    this.pins.show(stopped === null ? [] : [pin()]);
  }
}

function tube(points, radius, colour) {
  const curve = new THREE.CatmullRomCurve3(points.map((point) => new THREE.Vector3(...point)));
  return new THREE.Mesh(new THREE.TubeGeometry(curve, 2 * points.length, radius, 8), lit(colour));
}

const lit = (color) => new THREE.MeshLambertMaterial({ color, emissive: color, emissiveIntensity: 0.4 });
