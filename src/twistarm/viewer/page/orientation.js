// Three ways to write an orientation in numbers, each nearest to the numbers before it.

import { THREE } from "./view.js";

const POLE = 1e-5; // cosine of the pitch below which roll and yaw turn about one axis
const TOUCHED = 0.5; // rad by which roll and yaw change at most where they stay
const SAME = 1e-4; // rad, above the solver's tolerance
const NEAR = 0.5; // rad, within which an angle goes on beyond half a turn

// Of each number its name and unit.
export const WAYS = {
  rpy: { roll: "rad", pitch: "rad", yaw: "rad" },
  quaternion: { qx: "1", qy: "1", qz: "1", qw: "1" },
  axis: { "axis x": "1", "axis y": "1", "axis z": "1", angle: "rad" },
};

export const ZERO = {
  quaternion: "This quaternion is zero. Give at least one number other than 0.",
  axis: "This axis is zero. Give at least one number other than 0.",
};

// The numbers of a rotation; `rpy` where they are known.
export function written(way, quaternion, last, rpy) {
  if (way === "rpy") {
    const { x, y, z } = rpy ? { x: rpy[0], y: rpy[1], z: rpy[2] } : new THREE.Euler().setFromQuaternion(quaternion, "ZYX");
    return steady([x, y, z], last);
  }
  const xyzw = quaternion.toArray();
  const [vector, turn] = way === "quaternion" ? [xyzw, 0] : axisOf(xyzw, last);
  const before = last?.slice(0, vector.length) ?? [0, 0, 0, 1].slice(-vector.length);
  const flip = vector.reduce((sum, value, i) => sum + value * before[i], 0) < 0 ? -1 : 1;
  const pointed = vector.map((value) => flip * value);
  if (way === "quaternion") return pointed;
  const whole = 2 * Math.PI * Math.round(((last?.[3] ?? 0) - flip * turn) / (2 * Math.PI));
  return [...pointed, flip * turn + (Math.abs(flip * turn + whole - last?.[3]) < NEAR ? whole : 0)];
}

// Unit axis, and angle from 0 to π; without a turn the axis stays.
function axisOf(xyzw, last) {
  const [x, y, z, w] = xyzw[3] < 0 ? xyzw.map((value) => -value) : xyzw;
  const sine = Math.hypot(x, y, z);
  if (sine > 1e-9) return [[x / sine, y / sine, z / sine], 2 * Math.atan2(sine, w)];
  const length = Math.hypot(...(last ?? []).slice(0, 3));
  return [length > 0 ? last.slice(0, 3).map((value) => value / length) : [0, 0, 1], 0];
}

// The rotation of such numbers; null for zeros.
export function read(way, numbers) {
  if (way === "rpy") return new THREE.Quaternion().setFromEuler(new THREE.Euler(numbers[0], numbers[1], numbers[2], "ZYX"));
  const count = way === "quaternion" ? 4 : 3;
  const length = Math.hypot(...numbers.slice(0, count));
  if (length === 0) return null;
  const unit = numbers.slice(0, count).map((value) => value / length);
  if (way === "quaternion") return new THREE.Quaternion(...unit);
  return new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(...unit), numbers[3]);
}

// Whether numbers that somebody is typing mean this rotation.
export function means(way, numbers, quaternion) {
  const meant = read(way, numbers);
  return meant !== null && meant.angleTo(quaternion) < SAME;
}

// Of the two ways to say a rotation by roll, pitch and yaw the one in which roll and yaw stay near the `last`; at a
// pitch of ±90°, where one of them is free, the yaw stays.
function steady([roll, pitch, yaw], last) {
  if (!last) return [roll, pitch, yaw];
  if (Math.cos(pitch) < POLE) return [wrapped(roll + Math.sign(pitch) * (last[2] - yaw)), pitch, last[2]];
  const other = [roll + Math.PI, Math.PI - pitch, yaw + Math.PI].map(wrapped);
  const stays = (angles) => [0, 2].every((i) => Math.abs(wrapped(angles[i] - last[i])) < TOUCHED);
  return stays(other) && !stays([roll, pitch, yaw]) ? other : [roll, pitch, yaw];
}

const wrapped = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
