"""Type URC on a keyboard in front of the rover's own wheel: free moves to each key, straight strokes, proven free."""

import numpy as np
from numpy.typing import NDArray
from play import play_if_asked

from twistarm import Approach, FreeMove, JointMove, LineMove, Position, Scene, assert_free, load_arm, plan, solve_ik

PITCH, TRAVEL, CLEARANCE, SPEED = 0.019, 0.004, 0.03, 0.1  # m: between keys, into a key, above one; m/s
ROWS = {"QWERTYUIOP": 0.0, "ASDFGHJKL": 0.25, "ZXCVBNM": 0.75}  # how far each row is moved right, in keys
DOWN, ORIGIN = np.array([0.0, 0.0, -1.0]), np.array([0.42, 0.47, 0.12])  # the face of the key Q, in base axes

# The description draws the rover's chassis and wheels on `base_link`, so the arm avoids them in every scene.
arm = load_arm("rover_arm")
scene = Scene(arm, margin=0.004)
scene.add_plane("ground")
scene.add_cylinder("mast", 0.02, 0.6, (0.42, 0.22, 0.3))  # between the keyboard and the middle of the rover
scene.add_box("keyboard", (0.09, 0.22, 0.1), ORIGIN + [-0.02, -0.09, -0.066])  # its body, below the keys


def place(letter: str) -> NDArray[np.float64]:
    """The middle of a key's face (3,) [m]: rows lead along −y, and the next row is nearer to the rover."""
    row, (letters, shift) = next((i, row) for i, row in enumerate(ROWS.items()) if letter in row[0])
    key: NDArray[np.float64] = ORIGIN - [PITCH * row, PITCH * (letters.index(letter) + shift), 0.0]
    return key


def above(letter: str, height: float) -> Approach:
    """The tool's tip over a key, pointing down; turning about the vertical is free."""
    return Approach(place(letter) - height * DOWN, DOWN)


# The tool's place in the front wheel is found, and it collides: the wheel is a shape of `base_link`.
hit = solve_ik(arm, Position([0.0, 0.45, 0.25])).require()
assert "base_link" in {name for contact in scene.contacts(hit) for name in contact.links}

# From a pose low in front of the rover, straight in joint space, the arm would knock against the mast.
straight = plan(arm, JointMove(above("U", CLEARANCE)), start="reach")
knock = scene.first_collision(straight.breakpoints, straight.coefficients)
assert knock is not None
assert "mast" in knock.contacts[0].links

segments: list[FreeMove | LineMove] = []
for letter in "URC":
    segments += [
        FreeMove(above(letter, CLEARANCE)),
        LineMove(above(letter, -TRAVEL), linear_speed=SPEED, label=f"press {letter}"),
        LineMove(above(letter, CLEARANCE), linear_speed=SPEED),
    ]
motion = plan(arm, [*segments, FreeMove("stowed")], start="reach", scene=scene)

# Each key was pressed at its middle, to its depth.
assert [label for _, label in motion.labels] == ["press U", "press R", "press C"]
for moment, label in motion.labels:
    pressed = arm.fk(motion(moment))[:3, 3]
    assert np.linalg.norm(pressed - place(label[-1]) - TRAVEL * DOWN) < 1e-4, "to a tenth of a millimetre"

# Nothing is touched between samples either, as a team's test would ask. At the robot's rate of 100 Hz: the same.
assert_free(arm, motion, scene)
setpoints = motion(np.arange(0.0, motion.duration, 0.01))
assert not scene.collides(setpoints).any()
nearest = scene.clearance(motion.breakpoints, motion.coefficients)
assert nearest.metres > 0.004, "the margin of the scene"
print(f"three keys in {motion.duration:.1f} s; nearest: {nearest}")
play_if_asked(arm, motion)
