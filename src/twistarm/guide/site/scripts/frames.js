// Frames of arms start when the reader comes to them, one after the other.
"use strict";

{
  const near = new Set(); // frames in reach of the reader that have not started
  let starting = false;

  const start = () => {
    const [frame] = near;
    if (starting || !frame) return;
    near.delete(frame);
    eye.unobserve(frame);
    starting = true;
    frame.addEventListener("load", () => { starting = false; start(); }, { once: true });
    frame.src = frame.dataset.src;
  };
  const eye = new IntersectionObserver((seen) => {
    for (const { target, isIntersecting } of seen) near[isIntersecting ? "add" : "delete"](target);
    start();
  }, { rootMargin: "100px" });
  for (const frame of document.querySelectorAll("iframe[data-src]")) eye.observe(frame);
}
