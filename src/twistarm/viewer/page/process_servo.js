// Drive on a saved page: the core's servo on simulated joints, a hundred times a second. A command counts for a moment:
// whoever moves the arm says it again and again. As driver.py.

const PERIOD = 10; // ms between two steps
const MOST = 50; // steps at once, after a pause of the page; what is longer is not caught up
const HOLD = 200; // ms for which a command counts
const STOP_TIMEOUT = 3000; // ms until a drive ends although the arm still moves
const NOTABLE = 0.02; // least lost share of a command that is mentioned
const ALL = 0.95; // a larger share counts as all of it
const STANDSTILL = 1e-3; // an arm that does less than this share of a command stands
const NO_REPORT = { status: null, joint: null, reason: "", share: null };
const TURNED = "the tool turns otherwise than commanded, because the arm has too few joints";

export class Drive {
  /** @type {any} while it drives */ state = null;
  /** @type {any} the command that came last, {twist, frame} or {rates}; null: to stop */ command = null;
  /** @type {any} */ servo = null;
  onUnreachable = "slide";
  now = 0; // when the arm stood where it stands [ms]
  heard = -Infinity; // when the command came [ms]
  ending = Infinity; // when the end was asked for [ms]

  // `core`; `length` [m] that counts as 1 rad; the `note` about limits; `moved(theta)`: the arm is here now.
  constructor({ core, length, note }, moved) {
    this.core = core;
    this.length = length;
    this.note = note;
    this.moved = moved;
    this.end();
  }

  get driven() { return this.state !== null; }

  messages() {
    const { driven, report } = this;
    return [
      { type: "drive", on: driven, note: driven ? this.note : "", on_unreachable: this.onUnreachable, free: false },
      { type: "servo", jog: driven, driven, ...report },
    ];
  }

  // On begins at theta, inside the limits; off brings the arm to rest and ends.
  switch(on, theta) {
    if (this.driven) this.ending = on ? Infinity : Math.min(this.ending, this.now);
    if (this.driven || !on) return;
    this.choose(this.onUnreachable);
    this.state = this.servo.rest(theta);
    this.now = performance.now();
    requestAnimationFrame(() => this.tick());
  }

  end() {
    this.state = null;
    this.report = NO_REPORT;
    this.command = null;
    this.heard = -Infinity;
    this.ending = Infinity;
  }

  // What the arm does where it cannot follow: "slide" or "stop".
  choose(onUnreachable) {
    if (this.core.driven) this.servo = this.core.servo({ onUnreachable });
    this.onUnreachable = onUnreachable;
  }

  take(command) {
    if (!this.driven) throw new Error("Turn on Drive in the Jog panel first.");
    this.command = command;
    this.heard = performance.now();
  }

  tick() {
    const now = performance.now();
    if (now - this.now > MOST * PERIOD) this.now = now - MOST * PERIOD;
    while (this.driven && this.now + PERIOD <= now) this.step();
    if (!this.driven) return this.moved(null);
    this.moved(this.state.theta);
    requestAnimationFrame(() => this.tick());
  }

  step() {
    this.now += PERIOD;
    const ended = this.now >= this.ending;
    const stale = this.now - this.heard > HOLD;
    const command = ended || stale ? null : this.command;
    const answer = this.servo.step(this.state, command, PERIOD / 1000);
    this.state = answer.state;
    const still = this.state.thetaDot.every((rate) => rate === 0);
    if (ended && (still || this.now - this.ending > STOP_TIMEOUT)) return this.end();
    if (command !== null) this.report = reported(answer, command, this.length, this.onUnreachable === "stop");
    else if (ended || this.command === null) this.report = NO_REPORT; // nothing is asked of the arm
    else this.report = { ...NO_REPORT, status: "STALE", reason: `the last command is more than ${HOLD / 1000} s old` };
  }
}

// Status, joint, the executed share of the command, and the reason in words.
function reported({ cause, status, words, joint, scale, lost, lostShare, halted }, command, length, stops) {
  const share = scale * (1 - missing(command, lost, lostShare, length));
  const nowhere = joint === null && lostShare > ALL && share < 1 - ALL;
  const side = { LOWER_LIMIT: "lower", UPPER_LIMIT: "upper" }[cause];
  let reason = words;
  if (side) reason = halted ? `${joint} is at its ${side} position limit` : `slowed by the ${side} position limit of ${joint}`;
  else if (cause === "VELOCITY_LIMIT") reason = `slowed by the velocity limit of ${joint}`;
  else if (nowhere) reason = "the arm cannot move or turn its tool that way from here";
  else if (cause === "MOVING" && lostShare >= NOTABLE) reason = TURNED;
  else if (cause === "MOVING" && scale < ALL) reason = "changing speed, as fast as the acceleration limits allow";
  else if (joint) reason += `; ${joint} would have to move most for it`;
  if (stops && cause !== "MOVING" && scale * (1 - lostShare) < STANDSTILL) reason = `stopped on its course: ${reason}`;
  const code = halted ? "HALTED_LIMIT" : nowhere ? "IMPOSSIBLE_DIRECTION" : status;
  return { status: code, joint, reason, share: Math.round(100 * share) / 100 };
}

// The share of a twist that is lost along it, metres measured in the length: turns that only serve the way do not count.
function missing({ twist }, lost, lostShare, length) {
  const scaled = (parts) => parts.map((part, i) => (i < 3 ? part / length : part));
  const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
  const commanded = twist && scaled(twist);
  const share = commanded && dot(commanded, commanded) > 0 ? dot(commanded, scaled(lost)) / dot(commanded, commanded) : lostShare;
  return Math.min(Math.max(share, 0), 1);
}
