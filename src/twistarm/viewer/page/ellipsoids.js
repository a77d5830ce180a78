// A manipulability ellipsoid at the tool: how fast it moves, or turns, in each direction.

import { dispose } from "./disposal.js";
import { hidden, rod } from "./solids.js";
import { THREE } from "./view.js";

const FLAT = 0.002; // half a thickness, in sizes of the arm, at which a disc or a line is still seen

export class Ellipsoid {
  /** @type {InstanceType<typeof THREE.Mesh>} */ body;
  /** @type {InstanceType<typeof THREE.Group>[]} */ rods;

  constructor(view, color) {
    this.color = color;
    this.group = hidden(view);
  }

  build(axes) {
    dispose(this.group);
    this.size = axes.size;
    this.body = new THREE.Mesh(new THREE.SphereGeometry(1, 48, 32), new THREE.MeshLambertMaterial({
      color: this.color, emissive: this.color, emissiveIntensity: 0.25,
      transparent: true, opacity: 0.32, side: THREE.DoubleSide, depthWrite: false,
    }));
    this.body.matrixAutoUpdate = false;
    this.body.renderOrder = 1;
    this.rods = [0, 1, 2].map(() => Object.assign(rod(this.color), { matrixAutoUpdate: false }));
    this.group.add(this.body, ...this.rods);
  }

  // Semi-axes and their directions, columns in base axes; `scale`: drawn length of 1.
  show({ semi_axes: semiAxes, directions }, scale) {
    const along = [0, 1, 2].map((k) => new THREE.Vector3().fromArray(directions.map((row) => row[k])));
    const long = semiAxes.map((length) => Math.max(scale * length, FLAT * this.size));
    const [x, y, z] = along.map((axis, k) => axis.clone().multiplyScalar(long[k]));
    this.body.matrix.makeBasis(x, y, z);
    const thin = 0.0022 * this.size;
    this.rods.forEach((axis, k) => {
      const scaled = [1, 2, 0].map((step) => along[(k + step) % 3].clone());
      axis.visible = semiAxes[k] * scale > FLAT * this.size;
      axis.matrix.makeBasis(scaled[0].multiplyScalar(thin), scaled[2].multiplyScalar(2 * long[k]), scaled[1].multiplyScalar(thin));
    });
  }

  stand({ position }) { this.group.position.copy(position); }
}
