// What the reader moves by hand: each element with data-slider becomes a bench.
"use strict";

for (const stage of document.querySelectorAll("[data-slider]:not(.live)")) {
  const slider = { ...window.guide.space, ...window.guide.plane }[stage.dataset.slider];
  slider?.(stage, JSON.parse(stage.dataset.numbers)).show();
}
