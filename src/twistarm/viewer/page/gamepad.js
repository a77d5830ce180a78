// A gamepad as a twist, while a shoulder button is held: its dead-man. Numbers of axes and buttons are those of the
// standard mapping (W3C Gamepad, section 9).

const DEAD_BAND = 0.12; // of a stick's way: worn sticks rest beside their middle
const SHOULDERS = [4, 5];
const [DOWN, UP] = [6, 7]; // the triggers
const [ROLL_LEFT, ROLL_RIGHT] = [14, 15]; // of the cross

export class Gamepad {
  armed = false;

  // Nothing moves before the shoulder buttons were seen let go: one held since before stands for nothing.
  clear() { this.armed = false; }

  // Six numbers in -1 … 1. A stick to the left and forward is y and x, for an arm that looks along x; the right one
  // forward turns its tool up.
  twist() {
    const pad = this.pad();
    const held = pad && SHOULDERS.some((button) => pressed(pad, button));
    if (!held) this.armed = pad !== undefined;
    if (!held || !this.armed) return [0, 0, 0, 0, 0, 0];
    const [left, ahead, turn, tilt] = [0, 1, 2, 3].map((axis) => -beyond(pad.axes[axis] ?? 0));
    const [up, down] = [UP, DOWN].map((button) => beyond(pad.buttons[button]?.value ?? 0));
    const roll = Number(pressed(pad, ROLL_LEFT)) - Number(pressed(pad, ROLL_RIGHT));
    return [ahead, left, up - down, roll, -tilt, turn];
  }

  pad() {
    return pads().find((pad) => pad?.mapping === "standard");
  }

  note() {
    if (!navigator.getGamepads) return "gamepad: only on https or localhost";
    if (pads().length === 0) return "";
    return this.pad() ? "gamepad: hold LB or RB" : "gamepad: unknown layout";
  }
}

const pads = () => [...(navigator.getGamepads?.() ?? [])].filter((pad) => pad?.connected);
const pressed = (pad, button) => pad.buttons[button]?.pressed ?? false;
const beyond = (value) => (Math.sign(value) * Math.max(0, Math.abs(value) - DEAD_BAND)) / (1 - DEAD_BAND);
