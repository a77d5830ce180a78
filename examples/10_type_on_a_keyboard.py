"""Type URC on a keyboard that stands upright: approach each key, push straight along its normal, retract."""

import numpy as np
from numpy.typing import NDArray
from play import play_if_asked

from twistarm import Approach, JointMove, LineMove, load_arm, plan

PITCH, TRAVEL, CLEARANCE, SPEED = 0.019, 0.004, 0.03, 0.1  # m: between keys, into a key, in front of one; m/s
ROWS = {"QWERTYUIOP": 0.0, "ASDFGHJKL": 0.25, "ZXCVBNM": 0.75}  # how far each row is moved right, in keys

arm = load_arm("rover_arm")

# The keyboard's pose in base axes, with its origin at Q: x along a row, y up, z out of it. It leans back by 10°.
lean = np.radians(10)
right, up = np.array([0.0, -1.0, 0.0]), np.array([np.sin(lean), 0.0, np.cos(lean)])
out, origin = np.cross(right, up), np.array([0.95, 0.1, 0.85])


def place(letter: str, height: float) -> NDArray[np.float64]:
    """The middle of a key (3,) [m], that high above its face."""
    row, (letters, shift) = next((i, row) for i, row in enumerate(ROWS.items()) if letter in row[0])
    on_face: NDArray[np.float64] = origin + PITCH * ((letters.index(letter) + shift) * right - row * up)
    return on_face + height * out


def facing(letter: str, height: float) -> Approach:
    """The tool's tip there, its axis along the keyboard's normal; turning about that axis is free."""
    return Approach(place(letter, height), -out)


segments: list[JointMove | LineMove] = []
for letter in "URC":
    to_it = LineMove if segments else JointMove
    segments += [
        to_it(facing(letter, CLEARANCE)),
        LineMove(facing(letter, -TRAVEL), linear_speed=SPEED, label=f"press {letter}"),
        LineMove(facing(letter, CLEARANCE), linear_speed=SPEED),
    ]
motion = plan(arm, [*segments, JointMove("ready")], start="ready")

# Each key was pressed at its middle, to its depth; labels tell when.
assert [label for _, label in motion.labels] == ["press U", "press R", "press C"]
for moment, label in motion.labels:
    pressed = arm.fk(motion(moment))[:3, 3]
    assert np.linalg.norm(pressed - place(label[-1], -TRAVEL)) < 1e-4, "to a tenth of a millimetre"

# No other key was touched: below half the clearance the tip is straight over its key, and points along the normal.
t = np.arange(0.0, motion.duration, 0.002)
g = arm.fk(motion(t))
low = (g[:, :3, 3] - origin) @ out < CLEARANCE / 2
tips = g[low, :3, 3] - ((g[low, :3, 3] - origin) @ out)[:, None] * out
aside = np.linalg.norm(tips[:, None] - [place(letter, 0.0) for letter in "URC"], axis=-1).min(axis=1)
tilted = np.linalg.norm(np.cross(g[low, :3, 2], out), axis=1).max()
assert aside.max() < 1e-4
assert tilted < np.radians(0.05)

rates = np.linalg.norm(np.diff(g[:, :3, 3], axis=0), axis=1) / np.diff(t)
assert rates[low[1:]].max() <= SPEED * (1 + 1e-3)
print(f"three keys in {motion.duration:.1f} s, at most {1e6 * aside.max():.2g} µm beside the middle of a key")
play_if_asked(arm, motion)
