// A button that plays what a range input scrubs, by the clock of twistarm's view.
/* global of_playback */
"use strict";

(() => {
  const CALM = matchMedia("(prefers-reduced-motion: reduce)");
  const STEPS = 8; // of a motion for readers who want little of it

  window.guide.player = (input, seconds) => {
    const clock = new of_playback.Playback(seconds, { time: 0, running: false, speed: 1, loop: false });
    const button = document.createElement("button");
    const [from, to] = [Number(input.min), Number(input.max)];
    let ours = false;

    function tell() {
      button.textContent = clock.running ? "❚❚" : "▶";
      button.setAttribute("aria-label", clock.running ? "Pause" : "Play");
    }

    function step() {
      if (!clock.running) return;
      clock.advance();
      const share = clock.time / clock.duration;
      ours = true;
      input.value = String(from + (to - from) * (CALM.matches ? Math.floor(STEPS * share) / STEPS : share));
      input.dispatchEvent(new Event("input"));
      ours = false;
      tell();
      requestAnimationFrame(step);
    }

    input.addEventListener("input", () => {
      if (ours) return;
      clock.pause();
      tell();
    });
    button.type = "button";
    button.className = "play";
    button.addEventListener("click", () => {
      if (clock.running) clock.pause();
      else {
        clock.time = (clock.duration * (Number(input.value) - from)) / (to - from);
        clock.play();
        requestAnimationFrame(step);
      }
      tell();
    });
    tell();
    return button;
  };
})();
