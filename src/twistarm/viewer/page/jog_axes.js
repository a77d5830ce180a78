// The axes that a jog goes along: those of the base, of the tool, or of the view as it is turned at that moment.

import { THREE } from "./view.js";

export const AXES = ["base", "tool", "view"];

// What keys and sticks push, (ahead, left, up), as components along the axes of `frame`: x, y and z, as for a tool that
// looks along x; in view axes, which point right, up and towards the viewer, what is ahead, left and up on the screen.
export const ofHands = (push, frame) => frame === "view" ? halves(push, ([ahead, left, up]) => [-left, up, -ahead]) : push;

// A twist along the view's axes, along those of the base: both halves turned by the camera's orientation.
export function inBase(twist, { viewer: { scene, camera } }) {
  camera.updateMatrixWorld();
  scene.updateMatrixWorld();
  const turn = new THREE.Matrix4().copy(scene.matrixWorld).invert().multiply(camera.matrixWorld);
  const rotation = new THREE.Matrix4().extractRotation(turn);
  return halves(twist, (half) => new THREE.Vector3(...half).applyMatrix4(rotation).toArray());
}

const halves = (twist, turned) => [...turned(twist.slice(0, 3)), ...turned(twist.slice(3))];
