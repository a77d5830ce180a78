// The columns of a Jacobian, each as two arrows: v and w, at the origin of the frame they are written in.

import { dispose } from "./disposal.js";
import { ANGULAR, Arrow, LINEAR, column, hidden } from "./solids.js";
import { THREE } from "./view.js";

const THICK = 0.006; // of the arm's size

export class Twists {
  constructor(view) {
    this.group = hidden(view);
    this.arrows = [];
  }

  // `slides` says of each coordinate whether it is one: its column then counts per axes.length.
  build(axes, slides) {
    dispose(this.group);
    this.axes = axes;
    this.slides = slides;
    this.arrows = slides.map(() => [new Arrow(LINEAR, THICK * axes.size), new Arrow(ANGULAR, THICK * axes.size)]);
    for (const arrow of this.arrows.flat()) this.group.add(arrow.group);
  }

  show(matrix, columns) {
    const { linear, angular, length } = this.axes;
    const origin = new THREE.Vector3();
    this.arrows.forEach(([v, w], i) => {
      const counted = this.slides[i] ? length : 1;
      v.set(origin, column(matrix, i).multiplyScalar(linear * counted));
      w.set(origin, column(matrix, i, 3).multiplyScalar(angular * counted));
      for (const arrow of [v, w]) arrow.group.visible = arrow.group.visible && columns.includes(i);
    });
  }

  stand(frame) {
    this.group.position.copy(frame.position);
    this.group.quaternion.copy(frame.quaternion);
  }
}
