// The links as a tree. Each can be hidden or seen through, and has a frame and its shapes that are checked for collisions.

import { hang, made, stand } from "./collision.js";
import { dispose } from "./disposal.js";
import { $, button, element } from "./element.js";
import { COLORS, rod } from "./gizmo_shapes.js";
import { writeName } from "./names.js";
import { THREE } from "./view.js";

const FAINTEST = 0.1;
const FAINT = 0.25; // opacity of a link that is seen through
const FRAME = 0.15; // of the axes, in radii of the arm
const MARKS = { hidden: "Hide", faint: "See through", frame: "Frame of", shapes: "Collision shapes of" }; // the switches of a link
const NAMES = Object.keys(MARKS);

export class LinkTree {
  // `need(on)`: whether the process is to tell the shapes.
  constructor(view, need = (on) => on) {
    this.view = view;
    this.need = need;
    this.nodes = {};
    this.parents = {}; // the parent of each link, null of the root
    this.frame = null;
    this.buttons = [];
    this.marks = marksOf({});
    this.opacity = 1;
    this.shapes = [];
    this.bodies = [];
    this.messages = { shapes: ({ bodies }) => this.fade(this.opacity, bodies) };
    $("opacity").min = FAINTEST;
    $("opacity").addEventListener("input", () => this.fade(Number($("opacity").value)));
    $("all-links").addEventListener("click", () => this.recall({ opacity: 1 }));
    view.onDrawn.push(() => this.apply());
  }

  // `links`: the node of each by its name. One that was hidden stays so on an arm that comes in this one's place.
  hello({ links, kinematics }) {
    Object.assign(this, { nodes: links, parents: kinematics.parents ?? {}, frame: null, buttons: [] });
    $("links").replaceChildren(...this.below(null));
    $("links-part").hidden = Object.keys(links).length === 0;
    this.apply();
  }

  // The rows of the links that `parent` carries, each with those that it carries itself.
  below(parent) {
    return Object.keys(this.parents).filter((name) => this.parents[name] === parent).map((name) => {
      const [item, row, carried] = [element("li"), element("div", "link"), this.below(name)];
      row.append(writeName(element("span"), name), ...NAMES.map((mark) => this.toggle(mark, name)));
      item.append(row);
      if (carried.length > 0) item.append(element("ul"));
      item.querySelector("ul")?.append(...carried);
      return item;
    });
  }

  toggle(mark, name) {
    const press = button("", "", `${MARKS[mark]} ${name}`, () => {
      this.marks[mark][this.marks[mark].has(name) ? "delete" : "add"](name);
      this.apply();
    });
    const sign = $(`sign-${mark}`).cloneNode(true); // drawn: few machines have a font with it
    sign.removeAttribute("id");
    press.append(sign);
    this.buttons.push(Object.assign(press, { ariaLabel: press.title, marked: () => this.marks[mark].has(name) }));
    return press;
  }

  update(frame) {
    this.frame = frame;
    stand(this.bodies, frame);
  }

  fade(opacity, shapes = this.shapes) {
    Object.assign(this, { opacity, shapes });
    this.apply();
  }

  remembered() {
    return { opacity: this.opacity, ...Object.fromEntries(NAMES.map((mark) => [mark, [...this.marks[mark]]])) };
  }

  recall({ opacity, ...marks }) {
    this.marks = marksOf(marks);
    this.fade(opacity);
  }

  apply() {
    const { viewer } = this.view;
    const { hidden, faint, shapes } = this.marks;
    $("opacity").value = this.opacity;
    for (const press of this.buttons) press.setAttribute("aria-pressed", press.marked());
    for (const [name, path] of Object.entries(this.nodes)) {
      viewer.set_property(this.view.split(path), "visible", !hidden.has(name));
      this.view.node(path).traverse(({ material }) => material && soften(material, this.opacity * (faint.has(name) ? FAINT : 1)));
    }
    this.need(shapes.size > 0);
    if (this.view.radius !== undefined) this.draw();
    viewer.set_dirty();
  }

  // The frames and collision shapes of links. They stay visible where the link itself is hidden.
  draw() {
    const { frame, shapes } = this.marks;
    const named = (names) => Object.keys(this.nodes).filter((name) => names.has(name));
    dispose(this.view.node("/links"));
    this.bodies = [
      ...named(frame).map((name) => ({
        node: this.nodes[name], matrix: new THREE.Matrix4().elements, mesh: Object.assign(axes(FRAME * this.view.radius), { matrixAutoUpdate: false }),
      })),
      ...this.shapes.filter(({ node }) => named(shapes).some((name) => this.nodes[name] === node))
        .map((body) => ({ ...body, mesh: made(body, true, this.view.radius) })),
    ];
    hang(this.view, this.bodies, "/links");
    if (this.frame) stand(this.bodies, this.frame);
  }
}

const marksOf = (lists) => Object.fromEntries(NAMES.map((mark) => [mark, new Set(lists[mark] ?? [])]));

function axes(length) {
  const group = new THREE.Group();
  COLORS.forEach((color, axis) => group.add(solid(rod(0.02 * length, 0.02 * length, 0, length, axis), color, 1)));
  return group;
}

function solid(geometry, color, opacity) {
  const material = new THREE.MeshBasicMaterial({ color, opacity, transparent: true, depthTest: false, depthWrite: false });
  return Object.assign(new THREE.Mesh(geometry, material), { renderOrder: 6 });
}

// Multiply the opacity of a material by `opacity`. You see through to what lies behind the arm, not to its own back.
export function soften(material, opacity) {
  material.userData.drawn ??= { opacity: material.opacity, transparent: material.transparent };
  const { drawn } = material.userData;
  material.opacity = opacity * drawn.opacity;
  material.transparent = drawn.transparent || opacity < 1;
}
