// A copy of the arm, drawn faintly where it would stand.

import { styled } from "./element.js";
import { THREE } from "./view.js";

const BEHIND = 2; // units of depth: where the arm stands as asked, it is seen
export const ABOVE = 10; // drawn after the arm, before the handles

export class ArmCopy {
  // `colour` as the style sheet names it; `place` among several: where two coincide, the first is seen.
  constructor(view, colour, opacity, place = 0) {
    this.view = view;
    this.colour = colour;
    this.opacity = opacity;
    this.place = place;
    this.group = new THREE.Group();
    this.parts = [];
  }

  // `transforms`: {path: sixteen numbers} of the links. What is copied already takes other places.
  stand(transforms) {
    if (this.parts.length === 0) this.copy(Object.keys(transforms));
    this.view.viewer.scene.updateMatrixWorld(true);
    for (const { path, source, copy } of this.parts) {
      const inNode = this.view.node(path).matrixWorld.clone().invert().multiply(source.matrixWorld);
      copy.matrix.fromArray(transforms[path]).multiply(inNode);
    }
  }

  copy(paths) {
    const material = faint(coloured(this.colour), this.opacity, true);
    Object.assign(material, { polygonOffset: true, polygonOffsetFactor: BEHIND, polygonOffsetUnits: BEHIND * (1 + this.place) });
    for (const path of paths) {
      this.view.node(path).traverse((source) => {
        if (!source.isMesh || source.material.depthTest === false) return;
        const copy = new THREE.Mesh(source.geometry, material);
        Object.assign(copy, { matrixAutoUpdate: false, renderOrder: ABOVE - 1 });
        this.parts.push({ path, source, copy });
        this.group.add(copy);
      });
    }
  }

  clear() {
    this.parts[0]?.copy.material.dispose(); // the geometry is that of what is drawn
    this.parts = [];
    this.group.clear();
  }

  remove() {
    this.clear();
    this.group.removeFromParent();
  }
}

export const coloured = (name) => new THREE.Color(styled(name));

// `solid`: seen only where nothing stands before it, and one surface deep.
export function faint(color, opacity, solid) {
  return new THREE.MeshLambertMaterial({ color, emissive: color, emissiveIntensity: 0.35, transparent: true, opacity, depthTest: solid, depthWrite: solid });
}
