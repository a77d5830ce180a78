// One link or joint that stands out: copies of what is drawn of it shine through everything before it, and an arrow
// with its name points at it.

import { coloured } from "./arm_copy.js";
import { dispose } from "./disposal.js";
import { styled } from "./element.js";
import { cut } from "./names.js";
import { THREE } from "./view.js";

const THICK = 2; // a screw's axis, beside how it is drawn
const LENGTH = 0.2; // of the arrow, beside the arm's radius
const LONGEST = 40; // letters
const HEIGHT = 24; // of the name, px

export class Highlight {
  /** @type {InstanceType<typeof THREE.Box3>} of the node, in its own axes */ box;
  /** @type {ReturnType<typeof arrow>} */ arrow;
  /** @type {ReturnType<typeof label>} */ label;

  constructor(view) {
    this.view = view;
    this.node = null;
    this.copies = [];
    this.group = new THREE.Group();
    view.viewer.scene.add(this.group);
  }

  // Point at the node `path`, called `name`; null: at nothing.
  point(path, name) {
    this.clear();
    if (path !== null) this.begin(path, name);
    this.view.viewer.set_dirty();
  }

  clear() {
    for (const { copy } of this.copies) {
      copy.material.dispose(); // the geometry is that of what is drawn
      this.group.remove(copy);
    }
    dispose(this.group);
    this.copies = [];
    this.node = null;
  }

  begin(path, name) {
    this.view.viewer.scene.updateMatrixWorld(true);
    this.node = this.view.node(path);
    this.copies = copies(this.node, path.startsWith("/screws/") ? THICK : 1);
    this.box = extent(this.node);
    this.arrow = arrow(LENGTH * this.view.radius);
    this.label = label(name, this.view);
    this.group.add(...this.copies.map(({ copy }) => copy), this.arrow, this.label);
    this.follow();
  }

  follow() {
    if (this.node === null) return;
    const { scene } = this.view.viewer;
    scene.updateMatrixWorld(true);
    const toScene = scene.matrixWorld.clone().invert();
    for (const { source, copy, thick } of this.copies) {
      copy.matrix.multiplyMatrices(toScene, source.matrixWorld).scale(new THREE.Vector3(thick, 1, thick));
    }
    this.stand(this.box.clone().applyMatrix4(this.node.matrixWorld).applyMatrix4(toScene));
    this.view.viewer.set_dirty();
  }

  // The arrow comes from above, or from below where its name would leave the view.
  stand(box) {
    const { scene, camera } = this.view.viewer;
    const middle = box.getCenter(new THREE.Vector3());
    const far = LENGTH * this.view.radius;
    const tail = new THREE.Vector3(middle.x, middle.y, box.max.z + far);
    const side = scene.localToWorld(tail.clone()).project(camera).y < 0.85 ? 1 : -1;
    if (side < 0) tail.z = box.min.z - far;
    this.arrow.position.copy(tail);
    this.arrow.scale.set(1, 1, side);
    this.label.position.copy(tail);
    this.label.center.set(0.5, side > 0 ? 0 : 1);
  }
}

// Of every mesh below `node`, thickened across its own y axis, along which Meshcat's cylinders stand.
function copies(node, thick) {
  const made = [];
  node.traverse((source) => {
    if (!source.isMesh || source.material.depthTest === false) return; // an axis' own copy that shines through
    const copy = new THREE.Mesh(source.geometry, shining(0.6));
    Object.assign(copy, { matrixAutoUpdate: false, renderOrder: 1 });
    made.push({ source, copy, thick });
  });
  return made;
}

function shining(opacity) {
  const color = coloured("--accent");
  const light = { emissive: color, emissiveIntensity: 0.4 };
  return new THREE.MeshLambertMaterial({ color, ...light, transparent: true, opacity, depthTest: false, depthWrite: false });
}

// The box around what is drawn of `node`, in its own frame; around its origin where that is nothing.
function extent(node) {
  const box = new THREE.Box3();
  const toNode = node.matrixWorld.clone().invert();
  node.traverse(({ isMesh, geometry, matrixWorld }) => {
    if (!isMesh) return;
    if (geometry.boundingBox === null) geometry.computeBoundingBox();
    box.union(geometry.boundingBox.clone().applyMatrix4(matrixWorld).applyMatrix4(toNode));
  });
  return box.isEmpty() ? new THREE.Box3(new THREE.Vector3(), new THREE.Vector3()) : box;
}

function arrow(length) {
  const made = new THREE.Group();
  const shaft = new THREE.CylinderGeometry(0.035 * length, 0.035 * length, 0.7 * length).rotateX(Math.PI / 2);
  const head = new THREE.ConeGeometry(0.13 * length, 0.3 * length).rotateX(-Math.PI / 2);
  made.add(...[shaft.translate(0, 0, -0.35 * length), head.translate(0, 0, -0.85 * length)].map((geometry) =>
    Object.assign(new THREE.Mesh(geometry, shining(1)), { renderOrder: 2 })));
  return made;
}

// A name that always faces the eye, HEIGHT high at any distance.
function label(name, { viewer }) {
  const text = cut(name, LONGEST);
  const canvas = document.createElement("canvas");
  const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const font = `600 ${HEIGHT}px ${getComputedStyle(document.body).fontFamily}`;
  pen.font = font;
  Object.assign(canvas, { width: Math.ceil(pen.measureText(text).width) + HEIGHT, height: 2 * HEIGHT });
  pen.fillStyle = styled("--accent");
  pen.fillRect(0, 0, canvas.width, canvas.height);
  Object.assign(pen, { font, fillStyle: styled("--surface"), textAlign: "center", textBaseline: "middle" });
  pen.fillText(text, canvas.width / 2, HEIGHT);
  const map = new THREE.CanvasTexture(canvas);
  map.minFilter = THREE.LinearFilter;
  const made = new THREE.Sprite(new THREE.SpriteMaterial({ map, sizeAttenuation: false, depthTest: false, transparent: true }));
  const height = (2 * HEIGHT * Math.tan((viewer.camera.fov * Math.PI) / 360)) / viewer.renderer.domElement.clientHeight;
  made.scale.set((height * canvas.width) / canvas.height, height, 1);
  made.renderOrder = 3;
  return made;
}
