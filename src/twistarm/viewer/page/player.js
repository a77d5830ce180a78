// The player below the view: play, pause, scrub, speed, again and again.

const $ = (id) => document.getElementById(id);

export class Player {
  // `act` holds play(), pause(), seek(time), pace(speed, loop).
  constructor(act) {
    this.act = act;
    this.running = this.driven = false;
    this.duration = 0; // of the trajectory, s; the scrubber runs from 0 to 1
    this.messages = { player: (message) => this.show(message), servo: ({ driven }) => this.disable(driven) };
    $("play").addEventListener("click", () => (this.running ? act.pause() : act.play()));
    $("scrub").addEventListener("input", ({ target }) => act.seek(Number(target.value) * this.duration));
    for (const id of ["speed", "loop"]) {
      $(id).addEventListener("change", () => act.pace(Number($("speed").value), $("loop").checked));
    }
  }

  // The trajectory that is loaded; duration null: none.
  show({ duration, speed, loop }) {
    $("player").hidden = duration === null;
    this.duration = duration ?? 0;
    $("loop").checked = loop;
    if (![...$("speed").options].some(({ value }) => Number(value) === speed)) {
      $("speed").append(new Option(`${speed} ×`, speed)); // Python may play at any
    }
    for (const option of $("speed").options) option.selected = Number(option.value) === speed;
  }

  placed({ time, running }) {
    this.running = running;
    $("play").disabled = this.driven && !running;
    $("play").textContent = running ? "❚❚" : "▶";
    $("play").setAttribute("aria-label", running ? "Pause" : "Play");
    $("scrub").value = this.duration > 0 ? time / this.duration : 0;
    const text = `${time.toFixed(2)} / ${this.duration.toFixed(2)} s`;
    $("time").textContent = text;
    $("scrub").setAttribute("aria-valuetext", text);
  }

  // A servo drives the arm: what runs may be stopped, and that is all.
  disable(driven) {
    this.driven = driven;
    $("scrub").disabled = driven;
    $("play").disabled = driven && !this.running;
  }
}
