// The 3D view: Meshcat's viewer with our own light, floor and camera.

import { $$ } from "./element.js";
import { Floor } from "./floor.js";
import { corners, covered, framed, OVER } from "./framing.js";
import { Rim } from "./rim.js";

export const THREE = MeshCat.THREE;
/** From the arm towards the camera, in the arm's base axes. @type {[number, number, number]} */
export const DIRECTION = [0.95, -1.15, 0.62];
const NOTHING = [new THREE.Vector3(-0.5, 0, -0.5), new THREE.Vector3(0.5, 1, 0.5)]; // where nothing is drawn
const SOON = 300; // ms until what has come to be drawn is
const REST = 400; // ms without a motion after which the arm rests
const WELL = 0.8; // of half the picture: what lies within is well in it

// Call `act(renderer, scene, camera)` before every picture, whichever camera it is, and wherever it has gone.
export function beforeRender({ viewer: { scene } }, act) {
  const before = scene.onBeforeRender;
  scene.onBeforeRender = (...drawn) => {
    before.apply(scene, drawn);
    act(...drawn);
  };
}

// Tell `hand`, which has grab, follow, release and escape, of the pointer before the view takes it for itself.
export function followHand({ viewer: { dom_element: pane } }, hand) {
  const listen = (target, type, act) => target.addEventListener(type, (event) => hand[act](event), { capture: true });
  listen(pane, "pointerdown", "grab");
  listen(pane, "pointermove", "follow");
  for (const type of ["pointerup", "pointercancel", "lostpointercapture"]) listen(pane, type, "release");
  listen(window, "keydown", "escape");
}

export class View {
  /** @type {any} of all that is shown [m]; undefined until it is known */ radius;
  /** @type {InstanceType<typeof THREE.DirectionalLight>} */ sun;

  constructor(pane) {
    this.viewer = new MeshCat.Viewer(pane);
    // Meshcat takes the window's height for the pane's.
    const resize = this.viewer.set_3d_pane_size.bind(this.viewer);
    this.viewer.set_3d_pane_size = () => resize(pane.offsetWidth, pane.offsetHeight);
    // A picture before it is known where to look shows nothing, and holds up what it waits for.
    const render = this.viewer.render.bind(this.viewer);
    this.viewer.render = () => this.radius !== undefined && render();
    this.segments = new Map();
    this.soon = null;
    this.rim = new Rim();
    this.onDrawn = [() => this.rim.give(this.node("/arm")), () => this.layer()]; // done with what is new
    for (const name of ["Lights", "Grid", "Axes"]) this.viewer.delete_path([name]);
    this.viewer.set_property(["Background"], "visible", false);
    this.light();
    this.free = { top: 0, bottom: 0 }; // see `covered`
    this.target = null; // where the target stands, in base axes: to be seen
    this.handles = null; // of the tool, where there are any: their corners(eye, height) are to be seen
    this.turned = false; // by somebody's hand
    this.viewer.controls.addEventListener("start", () => (this.turned = true));
    if (window.parent !== window) pane.addEventListener("wheel", leaveToThePage, { capture: true });
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    this.dark.addEventListener("change", () => this.furnish());
    this.obstructed = null; // of the picture, by what stands over it and by handles, then by text
    this.gizmos = []; // each with square(), what its handles take of the picture
    this.held = false; // by a film, for which the camera stays
    this.widened = false; // the picture shows a target away from the arm
    this.afterRender(() => (this.obstructed = null));
    this.floor = new Floor(this);
    beforeRender(this, (renderer, scene, camera) => {
      if (this.radius === undefined) return;
      this.reach(camera);
      this.floor.measure(scene, camera);
    });
    const room = new ResizeObserver(() => this.reframe());
    for (const box of [pane, ...$$(OVER)]) room.observe(box);
  }

  light() {
    const { scene } = this.viewer;
    scene.add(new THREE.HemisphereLight(0xffffff, 0xb9c2cf, 0.55));
    scene.children.at(-1).position.set(0, 0, 1);
    const fill = new THREE.DirectionalLight(0xffffff, 0.14);
    fill.position.set(-1, 0.6, 0.4);
    scene.add(fill);
    this.sun = new THREE.DirectionalLight(0xffffff, 0.46);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    scene.add(this.sun, this.sun.target);
  }

  // One of Meshcat's own messages, packed: something to draw. Many come at once: a picture of each would hold up the next.
  draw(bytes) {
    const { needs_render } = this.viewer;
    this.viewer.handle_command_bytearray(bytes);
    this.viewer.needs_render = needs_render;
    this.soon ??= setTimeout(() => {
      this.soon = null;
      for (const act of this.onDrawn) act();
      this.viewer.set_dirty();
    }, SOON);
  }

  // Faces of two shapes in one plane would flicker: each shape lies by a hair before the one drawn before it.
  layer() {
    let shape = 0;
    this.node("/arm").traverse(({ isMesh, material }) => {
      if (isMesh) Object.assign(material, { polygonOffset: true, polygonOffsetUnits: -16 * (shape++ % 4) });
    });
  }

  // Take away what was drawn: another process may answer after a reconnection.
  clear() {
    for (const layer of ["arm", "beside", "screws", "frames", "path", "drawn"]) this.viewer.delete_path([layer]);
  }

  // {path: sixteen numbers, column by column}
  place(transforms) {
    for (const [path, matrix] of Object.entries(transforms)) this.viewer.set_transform(this.split(path), matrix);
    this.viewer.set_dirty();
    this.settle();
  }

  // Once all rests, a view that nobody has turned sees the whole arm again, and only the room that a target needs.
  settle() {
    clearTimeout(this.resting);
    this.resting = setTimeout(() => {
      if (this.radius === undefined || this.turned || this.held || !this.viewer.controls.enabled) return;
      if (this.widened || !this.solidCorners().every((point) => this.within(point, 1))) this.reframe();
    }, REST);
  }

  // The corners (world) of what stands on the floor.
  solidCorners() {
    return ["/arm", "/obstacles"].flatMap((path) => corners(this.node(path), true));
  }

  // Whether a point (world) is within this share of what is free of the picture.
  within(point, share) {
    const { x, y, z } = point.clone().project(this.viewer.camera);
    const { top, bottom } = this.free;
    return Math.abs(x) <= share && Math.abs(y - bottom + top) <= share * (1 - top - bottom) && z < 1;
  }

  // Whether a place in base axes is well in the picture.
  sees(place) { return this.within(this.viewer.scene.localToWorld(place.clone()), WELL); }

  // The place in base axes at which the camera looks.
  middle() { return this.viewer.scene.worldToLocal(this.viewer.controls.target.clone()); }

  split(path) {
    if (!this.segments.has(path)) this.segments.set(path, path.split("/").filter(Boolean));
    return this.segments.get(path);
  }

  afterRender(act) {
    const { scene } = this.viewer;
    const before = scene.onAfterRender;
    scene.onAfterRender = (...drawn) => {
      before.apply(scene, drawn);
      act();
    };
  }

  // A point of the window on the view, from -1 to 1 in both directions.
  onScreen({ clientX, clientY }) {
    const { left, top, width, height } = this.viewer.renderer.domElement.getBoundingClientRect();
    return new THREE.Vector2((2 * (clientX - left)) / width - 1, 1 - (2 * (clientY - top)) / height);
  }

  // The ray of the pointer, in base axes; beyond the picture, that of its edge: what is dragged there stays in the picture.
  ray(event) {
    const caster = new THREE.Raycaster();
    caster.setFromCamera(this.onScreen(event).clampScalar(-1, 1), this.viewer.camera);
    return caster.ray.applyMatrix4(this.viewer.scene.matrixWorld.clone().invert());
  }

  setVisible(layer, visible) {
    this.viewer.set_property([layer], "visible", visible);
    this.viewer.set_dirty();
  }

  node(path) { return this.viewer.scene_tree.find(this.split(path)).object; }

  // The matrix of a node seen from the arm's base, as it is drawn.
  drawn(path) {
    const { scene } = this.viewer;
    scene.updateMatrixWorld(true);
    return new THREE.Matrix4().copy(scene.matrixWorld).invert().multiply(this.node(path).matrixWorld).toArray();
  }

  // Where somebody has put the camera, in the arm's base frame; null: where it sees all, in a window of any shape.
  remembered() {
    if (!this.turned) return null;
    const { camera, controls } = this.viewer;
    return { position: camera.position.toArray(), target: controls.target.toArray(), zoom: camera.zoom };
  }

  recall(put) {
    if (put === null) return;
    const { position, target, zoom } = put;
    const { camera, controls } = this.viewer;
    camera.position.fromArray(position);
    controls.target.fromArray(target);
    camera.zoom = zoom;
    camera.updateProjectionMatrix();
    controls.update();
    this.turned = true;
    this.viewer.set_dirty();
  }

  // There is more room than before, or less: whose view nobody has turned sees the whole arm still.
  reframe() {
    this.free = covered(this.viewer.dom_element);
    if (this.radius === undefined || this.turned) this.viewer.set_3d_pane_size();
    else this.fit();
  }

  // Look at the whole arm, and give floor and light its size. `more`: other points (world) to be seen.
  fit(more = []) {
    this.turned = false;
    const { camera, controls } = this.viewer;
    const { position, target } = this.standpoint(DIRECTION, more);
    camera.position.copy(position);
    controls.target.copy(target);
    controls.update();
    this.viewer.set_dirty();
  }

  // Where the camera must stand, and what it must look at, to see all that is shown from a direction in base axes.
  standpoint([x, y, z], swept = []) {
    const { scene, camera, renderer, dom_element } = this.viewer;
    this.free = covered(dom_element);
    this.viewer.set_3d_pane_size();
    scene.updateMatrixWorld(true);
    scene.onBeforeRender(renderer, scene, camera); // what keeps its size on the screen
    const arm = corners(this.node("/arm"));
    // The tool and its way may lie away from what is drawn.
    const beside = ["/frames/space", "/frames/tool", "/path", "/obstacles", "/beside"].flatMap((path) => corners(this.node(path)));
    const all = [...(arm.length ? arm : NOTHING), ...beside];
    const box = new THREE.Box3().setFromPoints(all);
    const { center, radius } = box.getBoundingSphere(new THREE.Sphere());
    this.radius = Math.max(radius, 1e-3);
    this.ground = Math.min(0, box.min.y);
    this.furnish();
    this.aim(center);
    camera.fov = 32;
    this.reach(camera);
    const seen = ["/arm", "/beside", "/frames", "/path", "/screws", "/solutions", "/obstacles", "/reach", "/drawn"].flatMap((path) => corners(this.node(path), true)).concat(swept);
    const target = this.target ? [this.viewer.scene.localToWorld(this.target.clone())] : [];
    this.widened = target.some((point) => !box.containsPoint(point));
    const towards = new THREE.Vector3(x, z, -y).normalize();
    const frame = (more) => framed([...(seen.length ? seen : all), ...target, ...more], towards, camera, this.free);
    // Handles keep their size on the screen: from farther away they reach farther.
    return [1, 2, 3].reduce((found) => frame(this.handles?.corners(found.position, dom_element.offsetHeight) ?? []), frame([]));
  }

  // The nearest and the farthest that is drawn, for an arm of any size, seen from nearby or from far away.
  reach(camera) {
    const away = camera.position.distanceTo(this.viewer.controls.target);
    camera.near = Math.min(away, 4 * this.radius) / 100;
    camera.far = 2 * away + 20 * this.radius;
    camera.updateProjectionMatrix();
  }

  aim(center) {
    const target = new THREE.Vector3(center.x, -center.z, center.y);
    this.sun.target.position.copy(target);
    this.sun.position.copy(target).add(new THREE.Vector3(1.2, -0.7, 2.4).multiplyScalar(this.radius));
    Object.assign(this.sun.shadow.camera, {
      left: -2 * this.radius, right: 2 * this.radius, bottom: -2 * this.radius, top: 2 * this.radius,
      near: 0.1 * this.radius, far: 8 * this.radius,
    });
    this.sun.shadow.camera.updateProjectionMatrix();
    this.sun.shadow.bias = -0.0004;
    this.sun.shadow.normalBias = 0.004 * this.radius;
    for (const layer of ["/screws", "/frames"]) {
      this.node(layer).traverse((part) => Object.assign(part, { castShadow: false, receiveShadow: false }));
    }
  }

  furnish() {
    const furniture = `${this.radius} ${this.ground} ${this.dark.matches}`;
    if (this.radius === undefined || furniture === this.furnished) return;
    this.furnished = furniture; // thousands of lines, and a look from another side needs no others
    this.rim.show(this.dark.matches);
    this.floor.lay(this.radius, this.ground);
    this.viewer.set_dirty();
  }
}

// In a frame the wheel scrolls the page around it; with Ctrl or ⌘ it zooms.
function leaveToThePage(event) {
  if (!event.ctrlKey && !event.metaKey) event.stopPropagation();
}
