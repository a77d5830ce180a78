// A link taken hold of with the mouse: the joint that moves it follows the pointer. A press without a drag selects it.

import { Motion } from "./gizmo_motion.js";
import { THREE, followHand } from "./view.js";

const STILL = 4; // px that a press may slip
const END_ON = 0.97; // cosine to the eye from which a slide is seen from its end
const NEAREST = 0.05; // of the arm's radius: seen from the edge, a link nearer to its axis turns no faster

export class LinkDrag {
  // `page.names` finds the link under the pointer. Handles that were made before take the pointer first.
  constructor(page) {
    this.page = page; // view, panel, names, findings, theory
    this.held = null;
    this.hello = this.offline = () => this.drop();
    followHand(page.view, this);
  }

  // A finger turns the view.
  grab(event) {
    const { view, panel, names } = this.page;
    const { controls } = view.viewer;
    const plain = event.pointerType === "mouse" && event.button === 0 && !(event.shiftKey || event.ctrlKey || event.metaKey);
    const found = plain && controls.enabled && !this.held ? names.at(event) : null;
    const carrier = found && names.carriers.of(found.path);
    const row = carrier && panel.rows.get(carrier.joint.name);
    if (!row || row.slider.disabled) return;
    controls.enabled = false;
    event.target.setPointerCapture(event.pointerId);
    this.held = { ...carrier, row, controls, pressed: event, from: row.number, followed: 0, moved: false };
    this.held.motion = this.motion(event, found, carrier.turns);
  }

  // A turn is followed in the plane across the axis through the point that is held; a slide seen from its end, upwards.
  motion(event, { path, point }, turns) {
    const { view, names } = this.page;
    const { scene, camera } = view.viewer;
    const toBase = scene.matrixWorld.clone().invert();
    const at = point.clone().applyMatrix4(toBase);
    const { axis, point: on } = names.carriers.axis(path, view.drawn(path));
    const foot = at.clone().sub(on).projectOnVector(axis).add(on);
    const eye = camera.getWorldPosition(new THREE.Vector3()).applyMatrix4(toBase).sub(at).normalize();
    const radius = Math.max(at.distanceTo(foot), NEAREST * view.radius);
    if (!turns && Math.abs(axis.dot(eye)) > END_ON) axis.setFromMatrixColumn(camera.matrixWorld, 1).transformDirection(toBase);
    const [kind, position] = turns ? ["turn", foot] : ["move", at];
    return new Motion({ kind, axis, frame: null, pose: { position }, ray: view.ray(event), eye, radius });
  }

  follow(event) {
    const { held } = this;
    if (held?.pressed.pointerId !== event.pointerId) return;
    const { clientX, clientY } = held.pressed;
    held.moved ||= Math.hypot(event.clientX - clientX, event.clientY - clientY) > STILL;
    const amount = held.moved ? held.motion.amount(this.page.view.ray(event)) : null;
    if (amount === null) return;
    const by = amount - held.followed; // an angle goes on beyond half a turn
    held.followed += held.turns ? by - 2 * Math.PI * Math.round(by / (2 * Math.PI)) : by;
    const [lower, upper] = held.joint.limits;
    held.row.move(Math.min(Math.max(held.from + held.factor * held.followed, lower ?? -Infinity), upper ?? Infinity));
  }

  release(event) {
    if (this.held?.pressed.pointerId !== event.pointerId) return;
    const { moved, joint, place, node } = this.held;
    this.drop();
    if (moved || event.type !== "pointerup") return;
    const { findings, theory } = this.page;
    const key = `joint ${joint.name}`;
    findings.choose(findings.chosen === key ? null : key, { node, name: joint.name });
    if (theory.looking && place < theory.names.length) theory.recall({ joint: place, all: theory.switches.all });
  }

  escape(event) {
    if (!this.held || event.key !== "Escape") return;
    event.stopPropagation(); // what is selected stays so
    const { moved, row, from } = this.held;
    this.drop();
    if (moved) row.move(from);
  }

  drop() {
    if (!this.held) return;
    for (const controls of [this.held.controls, this.page.view.viewer.controls]) controls.enabled = true;
    this.held = null;
  }
}
