"""Unscrew a cap: grip it, turn it one and a half times about its axis while it comes out along its thread."""

import numpy as np
from play import play_if_asked

from twistarm import Approach, Dwell, JointMove, LineMove, ScrewMove, load_arm, plan, screws

TURNS, THREAD = 1.5, 0.003  # turns to the end of the thread; m that the cap advances with each
CLEARANCE = 0.05  # m

arm = load_arm("rover_arm")

# The cap: a point on its axis, and the axis, out of it, tilted up by 20°.
cap = np.array([0.9, 0.05, 0.8])
axis = np.array([-np.cos(np.radians(20)), 0.0, np.sin(np.radians(20))])
angle, pitch = 2 * np.pi * TURNS, THREAD / (2 * np.pi)  # counter-clockwise seen from outside, as caps come off

motion = plan(
    arm,
    [
        JointMove(Approach(cap + CLEARANCE * axis, -axis), label="open gripper"),
        LineMove(Approach(cap, -axis), linear_speed=0.1),
        Dwell(0.5, label="close gripper"),
        ScrewMove.about(axis, cap, angle, pitch, angular_speed=1.5, label="off the thread"),
        LineMove.by(CLEARANCE * axis, frame="base"),
    ],
    start="ready",
)

# From "close gripper" to "off the thread" the tool turns as the cap does: g(t) g0⁻¹ = exp(ξ̂ φ) with the cap's own twist
# ξ = (−ω × q + h ω, ω), MLS §2.3.3, and φ from 0 to the whole angle.
gripped, off = (moment for moment, label in motion.labels if label in ("close gripper", "off the thread"))
t = np.linspace(gripped + 0.5, off, 2000)
g = arm.fk(motion(t))
xi = np.concatenate([-np.cross(axis, cap) + pitch * axis, axis])
# φ is counted on from instant to instant: a rotation by itself does not tell whole turns.
steps = screws.log(g[1:] @ np.linalg.inv(g[:-1]))
phi = np.concatenate([[0.0], np.cumsum(steps[:, 3:] @ axis)])
expected = np.array([screws.exp(xi, each) @ g[0] for each in phi])
assert np.abs(g - expected)[:, :3, 3].max() < 1e-4, "on the axis to a tenth of a millimetre"
assert np.abs(g - expected)[:, :3, :3].max() < np.radians(0.05)
assert np.isclose(phi[-1], angle)
assert np.all(np.diff(phi) > -1e-12), "never back"
assert np.isclose((g[-1] - g[0])[:3, 3] @ axis, TURNS * THREAD, atol=1e-4)
assert np.max(np.diff(phi) / np.diff(t)) <= 1.5 * (1 + 1e-3)
print(f"{TURNS} turns in {off - gripped - 0.5:.1f} s; the cap came out by {1e3 * (g[-1] - g[0])[:3, 3] @ axis:.2f} mm")
play_if_asked(arm, motion)
