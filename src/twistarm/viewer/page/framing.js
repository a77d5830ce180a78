// Where the camera stands so that all of what is drawn fills what is free of the view.

import { $$ } from "./element.js";

const { Box3, Vector3 } = MeshCat.THREE;

const MARGIN = 1.06;
const MOST = 0.3; // of the view's height that is left free for what stands over it, above and below
const BESIDE = "#cube, #legend, #reach-legend, #collides, #missed, #jog"; // and what no text is put on
const CUBE = 56; // px from its middle to its letters' ends
export const OVER = "#switches, #reach-legend, #player, #plots"; // what stands over the view

// The corners (world) of the boxes around all that is drawn below a node; `seen`: only of what is shown.
export function corners(node, seen = false) {
  if (seen && !node.visible) return [];
  return [...own(node), ...node.children.flatMap((child) => corners(child, seen))];
}

function own({ geometry, matrixWorld }) {
  if (!geometry) return [];
  if (geometry.boundingBox === null) geometry.computeBoundingBox();
  const ends = [geometry.boundingBox.min, geometry.boundingBox.max];
  return [0, 1, 2, 3, 4, 5, 6, 7].map((bits) =>
    new Vector3(...["x", "y", "z"].map((axis, k) => ends[(bits >> k) & 1][axis])).applyMatrix4(matrixWorld));
}

// The shares of the pane's height that are covered at its top and bottom.
export function covered(pane) {
  const { top, bottom, height } = pane.getBoundingClientRect();
  const shares = { top: 0, bottom: 0 };
  for (const cover of $$(OVER)) {
    const over = cover.getBoundingClientRect();
    if (over.height === 0) continue;
    const [side, depth] = over.top + over.bottom < top + bottom ? ["top", over.bottom - top] : ["bottom", bottom - over.top];
    shares[side] = Math.min(MOST, Math.max(shares[side], depth / height));
  }
  return shares;
}

// The boxes of what stands over the pane besides, in its pixels: no text is put there.
export function occupied(pane) {
  const { left, top } = pane.getBoundingClientRect();
  const boxes = $$(BESIDE).filter((box) => box.getClientRects().length > 0).map((box) => [box.getBoundingClientRect(), box.id === "cube" ? CUBE : 0]);
  return boxes.map(([box, grow]) => ({
    left: box.left - left - grow, right: box.right - left + grow, top: box.top - top - grow, bottom: box.bottom - top + grow,
  }));
}

// Position and target (world) of a camera as near as it can be, seen from it `towards` itself: {top, bottom} shares of the
// picture stay free. The four sides of what it sees each pass through the outermost of the points.
export function framed(points, towards, lens, free) {
  const { right, up, across, along } = sides(points, towards, lens, free);
  const depth = Math.max(across.depth, along.depth);
  const [x, y] = [across, along].map(({ least, most }) => (least(depth) + most(depth)) / 2);
  const position = new Vector3().addScaledVector(right, x).addScaledVector(up, y).addScaledVector(towards, depth);
  const middle = new Box3().setFromPoints(points).getCenter(new Vector3()).dot(towards);
  return { position, target: position.clone().addScaledVector(towards, middle - depth) };
}

function sides(points, towards, { fov, aspect }, { top, bottom }) {
  const right = new Vector3(0, 1, 0).cross(towards).normalize();
  const up = new Vector3().crossVectors(towards, right);
  const slope = Math.tan((fov * Math.PI) / 360);
  const [middle, half] = [bottom - top, (1 - top - bottom) / MARGIN];
  const across = between(points, right, towards, slope * aspect / MARGIN, slope * aspect / MARGIN);
  return { right, up, across, along: between(points, up, towards, slope * (half + middle), slope * (half - middle)) };
}

// How far out a camera must be for all points to lie between two planes through it, of these slopes, and the least and
// most that it may be aside at a depth.
function between(points, axis, towards, more, less) {
  const high = Math.max(...points.map((point) => point.dot(axis) + more * point.dot(towards)));
  const low = Math.min(...points.map((point) => point.dot(axis) - less * point.dot(towards)));
  return { depth: (high - low) / (more + less), least: (depth) => high - more * depth, most: (depth) => low + less * depth };
}
