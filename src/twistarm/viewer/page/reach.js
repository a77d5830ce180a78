// A map of the reach: its surface, and a slice through the tool, coloured by the share of directions reached.

import { dispose } from "./disposal.js";
import { $, bytes } from "./element.js";
import { THREE } from "./view.js";

// From dark to light, so that the order is seen without the hues; neither end is lost on a light or a dark ground.
const COLOURS = ["#6a3d9a", "#3f62c4", "#1c8fae", "#35ab6a", "#a9b92c", "#eebf2a"];
const SURFACE = 0.14; // opacities
const SLICE = 0.42;
const FINE = 2; // points of the slice in the side of a cube
const SHADES = shades(COLOURS.map((text) => new THREE.Color(text)));

export class Reach {
  /** @type {InstanceType<typeof THREE.Mesh<any, any>>} */ slice;

  constructor(view) {
    this.view = view;
    this.group = view.node("/reach"); // which Fit view looks at
    this.group.visible = false;
    this.map = null;
    this.tool = new THREE.Vector3(1, 0, 0);
    this.bearing = 0; // of the tool about the base's z axis
    $("reach-bar").style.background = `linear-gradient(to right, ${COLOURS.join(", ")})`;
    $("reach-plane").addEventListener("change", () => this.cut());
  }

  clear() {
    dispose(this.group);
    this.map = null;
    this.show(false);
  }

  // `shares`: a byte for each cube, 255 the `best`; the cube (i, j, k) has its centre at `first` + (i, j, k) `voxel`.
  draw(map) {
    dispose(this.group);
    const points = new Float32Array(bytes(map.points).buffer);
    const surface = new THREE.BufferGeometry();
    surface.setAttribute("position", new THREE.BufferAttribute(points, 3));
    const colours = Float32Array.from([...bytes(map.values)].flatMap((value) => [...SHADES.slice(4 * value, 4 * value + 3)]), (part) => part / 255);
    surface.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    surface.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes(map.faces).buffer), 1));
    surface.computeVertexNormals();
    let radius = map.voxel;
    for (let i = 0; i < points.length; i += 3) radius = Math.max(radius, map.voxel + Math.hypot(points[i], points[i + 1]));
    this.map = { ...map, shares: bytes(map.shares), radius, box: new THREE.Box3().setFromArray(points).expandByScalar(map.voxel) };
    const look = { transparent: true, side: THREE.DoubleSide, depthWrite: false };
    this.slice = new THREE.Mesh(new THREE.PlaneGeometry().translate(0.5, 0.5, 0), new THREE.MeshBasicMaterial({ ...look, opacity: SLICE }));
    Object.assign(this.slice, { matrixAutoUpdate: false, renderOrder: 2 });
    const skin = new THREE.Mesh(surface, new THREE.MeshLambertMaterial({ ...look, opacity: SURFACE, vertexColors: true }));
    this.group.add(Object.assign(skin, { renderOrder: 1 }), this.slice);
    $("reach-best").textContent = `${Math.round(100 * map.best)} %`;
    $("reach-words").textContent = map.words;
    this.reveal();
    this.view.reframe();
  }

  show(on) {
    if (on === this.group.visible) return;
    this.group.visible = on;
    this.reveal();
  }

  reveal() {
    $("reach-legend").hidden = !this.group.visible || this.map === null; // the view makes room for it
    this.cut();
    this.view.viewer.set_dirty();
  }

  follow(position) {
    if (this.tool.equals(position)) return;
    this.tool.copy(position);
    if (Math.hypot(position.x, position.y) > 1e-6) this.bearing = Math.atan2(position.y, position.x);
    this.cut();
  }

  sides() {
    const { box, radius } = this.map;
    const k = ["x", "y", "z"].indexOf($("reach-plane").value);
    if (k < 0) {
      const along = new THREE.Vector3(Math.cos(this.bearing), Math.sin(this.bearing), 0);
      return [along.clone().multiplyScalar(-radius).setZ(box.min.z), along.multiplyScalar(2 * radius), new THREE.Vector3(0, 0, box.max.z - box.min.z)];
    }
    const size = box.getSize(new THREE.Vector3());
    const side = (i) => new THREE.Vector3().setComponent(i % 3, size.getComponent(i % 3));
    return [box.min.clone().setComponent(k, this.tool.getComponent(k)), side(k + 1), side(k + 2)];
  }

  cut() {
    if (this.map === null || !this.group.visible) return;
    const { first, voxel, shape, shares } = this.map;
    const [corner, along, up] = this.sides();
    this.slice.matrix.makeBasis(along, up, new THREE.Vector3().crossVectors(along, up).normalize()).setPosition(corner);
    const [width, height] = [along, up].map((side) => Math.ceil((FINE * side.length()) / voxel));
    const { data } = this.texture(width, height).image;
    const start = corner.toArray().map((part, k) => (part - first[k]) / voxel + 0.5);
    const [right, above] = [along.toArray().map((part) => part / voxel / width), up.toArray().map((part) => part / voxel / height)];
    const index = (k, i, row) => {
      const place = Math.floor(start[k] + (i + 0.5) * right[k] + (row + 0.5) * above[k]);
      return place < shape[k] && place >= 0 ? place : NaN;
    };
    for (let row = 0; row < height; row++) {
      for (let i = 0; i < width; i++) {
        const share = shares[(index(0, i, row) * shape[1] + index(1, i, row)) * shape[2] + index(2, i, row)] ?? 0; // none outside
        data.set(SHADES.subarray(4 * share, 4 * share + 4), 4 * (row * width + i));
      }
    }
    this.view.viewer.set_dirty();
  }

  texture(width, height) {
    const { material } = this.slice;
    if (material.map?.image.width !== width || material.map.image.height !== height) {
      material.map?.dispose();
      material.map = new THREE.DataTexture(new Uint8Array(4 * width * height), width, height, THREE.RGBAFormat);
      Object.assign(material.map, { magFilter: THREE.LinearFilter, minFilter: THREE.LinearFilter });
      material.needsUpdate = true;
    }
    material.map.needsUpdate = true;
    return material.map;
  }
}

function shades(table) {
  const colours = Array.from({ length: 256 }, (_, value) => {
    const place = (value / 255) * (table.length - 1);
    const low = Math.min(Math.floor(place), table.length - 2);
    const { r, g, b } = table[low].clone().lerp(table[low + 1], place - low);
    return [r, g, b, value > 0 ? 1 : 0].map((part) => Math.round(255 * part));
  });
  return Uint8Array.from(colours.flat());
}
