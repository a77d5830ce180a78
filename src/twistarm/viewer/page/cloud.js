// The reachable workspace: a cloud of points where the tool can be, coloured by how evenly it moves there.

import { dispose } from "./disposal.js";
import { THREE } from "./view.js";

// From dark to light, so that the order is seen without the hues; neither end is lost on a light or a dark ground.
export const COLOURS = ["#6a3d9a", "#3f62c4", "#1c8fae", "#35ab6a", "#a9b92c", "#eebf2a"];
const DOT = 0.017; // of the arm's size

export class Cloud {
  constructor(view) {
    this.view = view;
    this.group = new THREE.Group();
    this.group.visible = false;
    view.viewer.scene.add(this.group);
  }

  clear() {
    dispose(this.group);
    this.view.viewer.set_dirty();
  }

  // `points`: float32 x, y, z of each in the base frame; `values`: a byte each, 255 the best; both base64.
  draw({ points, values }, size) {
    this.clear();
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(bytes(points).buffer), 3));
    const table = COLOURS.map((text) => new THREE.Color(text));
    const shades = Array.from({ length: 256 }, (_, value) => shade(table, value / 255));
    const colours = Float32Array.from(Array.from(bytes(values), (value) => shades[value]).flat());
    geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    const look = { size: DOT * size, vertexColors: true, transparent: true, opacity: 0.9, depthWrite: false, alphaMap: disc(), alphaTest: 0.3 };
    this.group.add(new THREE.Points(geometry, new THREE.PointsMaterial(look)));
    this.view.viewer.set_dirty();
  }
}

function shade(table, share) {
  const place = share * (table.length - 1);
  const low = Math.min(Math.floor(place), table.length - 2);
  return table[low].clone().lerp(table[low + 1], place - low).toArray();
}

export function bytes(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

// White on black: a point is round.
function disc() {
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { width: 32, height: 32 });
  const pen = canvas.getContext("2d");
  pen.fillRect(0, 0, 32, 32);
  pen.fillStyle = "#fff";
  pen.beginPath();
  pen.arc(16, 16, 14, 0, 2 * Math.PI);
  pen.fill();
  return new THREE.CanvasTexture(canvas);
}
