// The clock of a motion: which moment of it [s], at what speed, and whether it runs.

export class Playback {
  constructor(duration, { time, running, speed, loop }) {
    this.duration = duration;
    this.time = time;
    this.speed = speed;
    this.loop = loop;
    this.running = false;
    this.last = 0;
    if (running) this.play();
  }

  play() {
    if (this.time >= this.duration) this.time = 0;
    this.running = true;
    this.last = performance.now();
  }

  pause() { this.running = false; }

  seek(time) {
    this.running = false;
    this.time = Math.max(0, Math.min(time, this.duration));
  }

  // Up to now; at the end again from the start with `loop`, else no further.
  advance() {
    if (!this.running) return;
    const now = performance.now();
    this.time += (this.speed * (now - this.last)) / 1000;
    this.last = now;
    if (this.time < this.duration) return;
    this.running = this.loop && this.duration > 0;
    this.time = this.running ? this.time % this.duration : this.duration;
  }
}
