// A list of poses as a file: joints, and poses with name, theta in rad and m, and how the arm moves there.

const LARGEST_FILE = 2 ** 20; // bytes, with whatever spaces and other entries it may have
const LARGEST_LIST = 56 * 1024; // bytes, as in pose_list.py

export function written(joints, poses) {
  const rows = poses.map(({ name, theta, by }) => `    ${JSON.stringify({ name, theta, by })}`);
  return `{\n  "joints": ${JSON.stringify(joints)},\n  "poses": [\n${rows.join(",\n")}\n  ]\n}\n`;
}

// {joints, poses} of a file that somebody chose; an Error with the reason where it is no such list.
export async function read(file) {
  if (file.size > LARGEST_FILE) throw new Error(`${file.name} has ${file.size} bytes; a list of poses has at most 56 kB`);
  const found = parsed(file.name, await file.text());
  if (!names(found?.joints)) throw new Error(`${file.name}: "joints" must be a list of joint names`);
  if (!Array.isArray(found.poses)) throw new Error(`${file.name}: "poses" must be a list of poses, each with name and theta`);
  const poses = found.poses.map((pose, i) => checked(file.name, pose, i));
  const list = { joints: found.joints, poses };
  const size = new TextEncoder().encode(JSON.stringify(list)).length;
  if (size > LARGEST_LIST) throw new Error(`${file.name}: ${poses.length} poses have ${size} bytes; at most ${LARGEST_LIST} (56 kB)`);
  return list;
}

function parsed(name, text) {
  try {
    return JSON.parse(text);
  } catch (error) {
    throw new Error(`${name} is not JSON: ${error.message}`);
  }
}

function checked(file, pose, i) {
  const { name, theta, by } = pose ?? {};
  if (typeof name !== "string") throw new Error(`${file}: pose ${i + 1} needs a name, as text`);
  const numbers = Array.isArray(theta) && theta.every((value) => Number.isFinite(value));
  if (!numbers) throw new Error(`${file}: theta of pose ${i + 1} must be a list of numbers, in rad and m`);
  if (by === undefined) return { name, theta };
  if (typeof by !== "string") throw new Error(`${file}: by of pose ${i + 1} must be joint, line, screw, via, free, level, direction or orientation`);
  return { name, theta, by };
}

const names = (joints) => Array.isArray(joints) && joints.every((joint) => typeof joint === "string");
