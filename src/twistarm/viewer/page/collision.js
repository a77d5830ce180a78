// Collisions: the shapes that are checked, the obstacles, the links in collision in red, and the nearest pair.

import { coloured } from "./arm_copy.js";
import { dispose } from "./disposal.js";
import { $, bytes, element } from "./element.js";
import { Pins } from "./pins.js";
import { THREE } from "./view.js";

const SHAPE = 0.28; // opacities
const OBSTACLE = 0.92;
const WOOD = 0xb89a6a;
const SHADE = 0x35b5e8;
const RED = 0xd32f2f; // in both themes
const PLANE = 6; // the side of a plane as it is drawn, beside the arm's radius
const THIN = 0.006; // the line between the nearest pair, beside the arm's radius
const UP = new THREE.Vector3(0, 1, 0); // along which three.js's cylinders stand

export class Collision {
  // `page` holds view, state and layers.
  constructor(page) {
    this.page = page;
    this.view = page.view;
    this.shapes = [];
    this.obstacles = [];
    this.links = {};
    this.hit = new Set(); // names of links and obstacles
    this.nearest = new THREE.Group();
    this.pins = new Pins(page.view, "distance");
    this.messages = {
      shapes: ({ bodies }) => this.draw("shapes", "/collision", bodies),
      obstacles: ({ obstacles }) => this.draw("obstacles", "/obstacles", obstacles),
      collision: (message) => this.report(message),
    };
    this.view.onDrawn.push(() => this.paint()); // what is drawn anew
    $("show-collision").addEventListener("change", ({ target }) => page.layers.show({ collision: target.checked }));
  }

  hello({ links }) {
    this.links = links;
    const bare = Object.keys(links).length === 0; // an arm without shapes
    for (const control of [$("show-collision").parentElement, $("tab-scene")]) control.hidden = bare;
    this.view.node("/collision").add(this.nearest);
    this.report({ links: [], words: [], nearest: null });
  }

  layered({ collision }) { $("show-collision").checked = collision; }

  // Bodies are made again only if others come, not if they have moved.
  draw(kind, layer, bodies) {
    const before = this[kind];
    this[kind] = bodies.map((body) => {
      const old = before.find(({ name, key }) => kind === "obstacles" && name === body.name && key === keyOf(body));
      return { ...body, key: keyOf(body), mesh: old?.mesh ?? made(body, kind === "shapes", this.view.radius) };
    });
    for (const { mesh } of before) {
      if (this[kind].some((kept) => kept.mesh === mesh)) continue;
      mesh.removeFromParent();
      dispose(mesh);
    }
    hang(this.view, this[kind], layer);
    this.update();
    this.paint();
  }

  update() {
    stand([...this.shapes, ...this.obstacles], this.page.state.frame);
    this.view.viewer.set_dirty();
  }

  report({ links, words, nearest }) {
    const same = links.length === this.hit.size && links.every((name) => this.hit.has(name));
    this.hit = new Set(links);
    if (!same) this.paint();
    $("collides").textContent = words.length === 0 ? "" : `Collision: ${words[0]}${words.length > 1 ? `, and ${words.length - 1} more` : ""}`;
    $("collides").title = words.join("\n");
    this.connect(nearest);
  }

  paint() {
    const red = new THREE.Color(RED);
    for (const [name, path] of Object.entries(this.links)) {
      this.view.node(path).traverse(({ material }) => material?.isMeshLambertMaterial && tint(material, this.hit.has(name) ? red : null));
    }
    for (const { name, mesh } of [...this.shapes, ...this.obstacles]) tint(mesh.material, this.hit.has(name) ? red : null);
    this.view.viewer.set_dirty();
  }

  // The line between the nearest points, and its length.
  connect(nearest) {
    dispose(this.nearest);
    this.pins.show([]);
    if (nearest !== null) {
      const [from, to] = nearest.points.map((point) => new THREE.Vector3(...point));
      const thick = THIN * (this.view.radius ?? 1);
      const material = new THREE.MeshBasicMaterial({ color: coloured(nearest.metres > 0 ? "--accent" : "--warn"), depthTest: false, transparent: true });
      const line = new THREE.Mesh(new THREE.CylinderGeometry(thick, thick, from.distanceTo(to), 12), material);
      line.position.lerpVectors(from, to, 0.5);
      line.quaternion.setFromUnitVectors(UP, to.clone().sub(from).normalize());
      const ends = [from, to].map(({ x, y, z }) => new THREE.Mesh(new THREE.SphereGeometry(2 * thick, 16, 10).translate(x, y, z), material));
      this.nearest.add(...[line, ...ends].map((part) => Object.assign(part, { renderOrder: 5 })));
      const far = `${(1000 * Math.abs(nearest.metres)).toFixed(Math.abs(nearest.metres) < 0.01 ? 1 : 0)} mm`;
      const text = element("span", nearest.metres < 0 ? "overlap" : "", nearest.metres < 0 ? `overlap ${far}` : far);
      this.pins.show([{ layer: "collision", node: "/collision", at: line.position.clone(), text, whole: true }]);
    }
    this.view.viewer.set_dirty();
  }
}

// A body as it is drawn: a shape that is checked, faintly, or an obstacle. `radius` is the arm's.
export function made(body, faint, radius) {
  if (body.kind === "points") return cloud(body);
  const material = new THREE.MeshLambertMaterial({ color: faint ? SHADE : WOOD, transparent: true, opacity: faint ? SHAPE : OBSTACLE, side: THREE.DoubleSide, depthWrite: !faint });
  Object.assign(material, { polygonOffset: faint, polygonOffsetFactor: -1, polygonOffsetUnits: -1 });
  if (body.kind === "plane") material.opacity = 0.6 * SHAPE;
  const mesh = new THREE.Mesh(geometryOf(body, PLANE * (radius ?? 1)), material);
  const edges = new THREE.EdgesGeometry(mesh.geometry, 25);
  const color = material.color.clone().multiplyScalar(0.6);
  if (edges.attributes.position.count > 0) mesh.add(new THREE.LineSegments(edges, new THREE.LineBasicMaterial({ color, transparent: true, opacity: 0.5 })));
  return Object.assign(mesh, { matrixAutoUpdate: false });
}

const LENS = 1 / Math.tan((16 * Math.PI) / 180); // three.js sizes points for a view of 90°; ours has 32°

// A cloud of 100,000 voxels as boxes would take a picture too long: a square stands for each.
function cloud({ points, size: [voxel], low, step }) {
  const geometry = new THREE.BufferGeometry();
  const places = Float32Array.from(new Uint16Array(bytes(points).buffer), (cell, i) => low[i % 3] + step * cell);
  geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
  return Object.assign(new THREE.Points(geometry, new THREE.PointsMaterial({ color: WOOD, size: LENS * voxel })), { matrixAutoUpdate: false });
}

export function hang(view, bodies, layer) {
  for (const { mesh, kind } of bodies) view.node(kind === "plane" ? "/planes" : layer).add(mesh);
}

export function stand(bodies, frame) {
  for (const body of bodies) body.mesh.matrix.copy(matrixOf(body, frame));
}

// The matrix of a body in the arm's base frame.
export function matrixOf({ node, matrix }, frame) {
  const carrier = frame?.transforms[node];
  const own = new THREE.Matrix4().fromArray(matrix);
  return carrier ? own.premultiply(new THREE.Matrix4().fromArray(carrier)) : own;
}

const keyOf = ({ kind, size, points }) => `${kind} ${size.join()} ${points}`;

function tint(material, colour) {
  material.userData.plain ??= material.color.clone();
  material.color.copy(colour ?? material.userData.plain);
}

function geometryOf({ kind, size, points, faces }, side) {
  if (kind === "box") return new THREE.BoxGeometry(...size);
  if (kind === "sphere") return new THREE.SphereGeometry(size[0], 40, 24);
  if (kind === "plane") return new THREE.PlaneGeometry(side, side);
  if (kind === "cylinder") return new THREE.CylinderGeometry(size[0], size[0], size[1], 40).rotateX(Math.PI / 2);
  if (kind === "capsule") return new THREE.LatheGeometry(profile(...size), 40).rotateX(Math.PI / 2);
  const mesh = new THREE.BufferGeometry();
  mesh.setAttribute("position", new THREE.BufferAttribute(new Float32Array(bytes(points).buffer), 3));
  mesh.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes(faces).buffer), 1));
  const flat = mesh.toNonIndexed();
  flat.computeVertexNormals();
  return flat;
}

function profile(radius, length) {
  const quarter = Array.from({ length: 13 }, (_, i) => (Math.PI * i) / 24);
  const end = quarter.map((angle) => new THREE.Vector2(radius * Math.cos(angle), radius * Math.sin(angle) + 0.5 * length));
  return [...end.map(({ x, y }) => new THREE.Vector2(x, -y)).reverse(), ...end];
}
