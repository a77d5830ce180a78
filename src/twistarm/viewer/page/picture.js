// The view as a picture of any size, drawn piece by piece: a WebGL canvas has its limits, and shrinks without a word.

import { styled } from "./element.js";

const PIECE = 2048; // pixels

// A canvas of `width` x `height` pixels with all that the view shows but the handles, and more where the shape is another.
export function painted(view, width, height) {
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  const context = canvas.getContext("2d");
  paintSky(context, width, height);
  const { renderer, camera } = view.viewer;
  const handles = view.handles?.group ?? {};
  const before = { ratio: renderer.getPixelRatio(), zoom: camera.zoom, handles: handles.visible };
  try {
    handles.visible = false;
    renderer.setPixelRatio(1);
    renderer.setSize(Math.min(width, PIECE), Math.min(height, PIECE), false);
    camera.zoom *= Math.min(1, width / height / camera.aspect); // what was seen at the sides stays in
    for (let x = 0; x < width; x += PIECE) {
      for (let y = 0; y < height; y += PIECE) paintPiece(view, context, [width, height], [x, y]);
    }
  } finally {
    camera.clearViewOffset();
    camera.zoom = before.zoom;
    handles.visible = before.handles;
    renderer.setPixelRatio(before.ratio);
    view.viewer.set_3d_pane_size();
    view.viewer.render();
  }
  return canvas;
}

function paintPiece({ viewer }, context, [width, height], [x, y]) {
  const { renderer, scene, camera } = viewer;
  const { width: across, height: down } = renderer.domElement;
  camera.setViewOffset(width, height, x, y, across, down);
  renderer.render(scene, camera);
  context.drawImage(renderer.domElement, x, y);
}

// What the page has behind the view: style.css, main.
function paintSky(context, width, height) {
  const sky = context.createLinearGradient(0, 0, 0, height);
  sky.addColorStop(0, styled("--sky"));
  sky.addColorStop(0.7, styled("--ground"));
  context.fillStyle = sky;
  context.fillRect(0, 0, width, height);
}

export function asBlob(canvas) {
  return new Promise((resolve, reject) => {
    const done = (blob) => (blob ? resolve(blob) : reject(new Error("This browser cannot draw a picture of that size. Choose a smaller one.")));
    canvas.toBlob(done, "image/png");
  });
}
