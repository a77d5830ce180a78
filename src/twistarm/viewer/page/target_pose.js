// Poses of the tool as the page holds them, {position, quaternion} in base axes [m], and as six numbers x y z roll pitch yaw.

import { read, written } from "./orientation.js";
import { THREE } from "./view.js";

export function poseOf(matrix) {
  const [position, quaternion] = [new THREE.Vector3(), new THREE.Quaternion()];
  new THREE.Matrix4().fromArray(matrix).decompose(position, quaternion, new THREE.Vector3());
  return { position, quaternion };
}

// What the next target departs from: the given one, where it is not reached; else the tool, in all that the target leaves free.
export function startPose(given, tool) {
  if (!given) return tool;
  const fixed = given.kind === "pose" || (given.kind === "approach" && !given.converged);
  return {
    position: new THREE.Vector3(...given.position),
    quaternion: fixed ? new THREE.Quaternion(...given.xyzw) : tool.quaternion,
  };
}

// Roll, pitch and yaw about fixed axes are yaw, pitch and roll about the turned ones.
export const numbersOf = ({ position, quaternion }, last) => [...position.toArray(), ...written("rpy", quaternion, last?.slice(-3))];
export const turned = (numbers) => ({ position: new THREE.Vector3(...numbers.slice(0, 3)), quaternion: read("rpy", numbers.slice(3)) });
