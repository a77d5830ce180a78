"""The rover pitches and rolls while the tool keeps its pose in the world: the pose to hold moves, and says how fast."""

import numpy as np
from numpy.typing import NDArray

from twistarm import Arm, load_arm, rotations, screws
from twistarm.control.servo import PoseCommand, ServoState, servo_step

Array = NDArray[np.float64]

dt, seconds, pitch, roll = 0.01, 4.0, np.radians(8), np.radians(5)
times: Array = dt * np.arange(round(seconds / dt) + 1.0)


def base(t: Array) -> Array:
    """g_world_base at times t: the deck tilts about the arm's base, at rest at both ends."""
    share = 0.5 - 0.5 * np.cos(np.pi * t / seconds)
    g = np.tile(np.eye(4), (len(t), 1, 1))
    g[:, :3, :3] = rotations.from_rpy(share[:, None] * [roll, pitch, 0])
    return g


def gyro(t: Array, h: float = 1e-5) -> Array:
    """Angular velocities of the base in its own axes [rad/s]: what an IMU on the deck measures."""
    before, after = base(t - h)[:, :3, :3], base(t + h)[:, :3, :3]
    return rotations.log(before.swapaxes(1, 2) @ after) / (2 * h)


def hold(arm: Arm, start: Array, feed_forward: bool) -> tuple[Array, Array]:
    """How far off the tool is from its first pose in the world after each step: positions [m] and angles [rad]."""
    state, theta = ServoState.at(arm, start), [start]
    wanted = screws.inverse(base(times)) @ arm.fk(start)
    for g, w in zip(wanted[:-1], gyro(times), strict=False):
        # What stands in the world turns about the base against the base's own turn.
        velocity = np.r_[-np.cross(w, g[:3, 3]), -w] if feed_forward else np.zeros(6)
        state, _ = servo_step(arm, state, PoseCommand(g, velocity), dt)
        theta.append(state.theta)
    reached = base(times) @ arm.fk(theta)
    turned = rotations.log(reached[:, :3, :3] @ reached[0, :3, :3].T)
    return np.linalg.norm(reached[:, :3, 3] - reached[0, :3, 3], axis=1), np.linalg.norm(turned, axis=1)


six = load_arm("rover_arm_6dof")
start = np.array([0, -0.6, 1.2, 0, -0.6, 0])  # farther out than `ready`: the elbow has to bend on the way
position, angle = hold(six, start, feed_forward=True)
behind, angle_behind = hold(six, start, feed_forward=False)
print(f"six joints: at most {1e3 * position.max():.3f} mm and {np.degrees(angle.max()):.4f}° off")
print(f"  without feed-forward {1e3 * behind.max():.2f} mm and {np.degrees(angle_behind.max()):.2f}°")
assert position.max() < 1e-3
assert angle.max() < np.radians(0.1)
assert behind.max() > 5 * position.max()
assert angle_behind.max() > 5 * angle.max()

# Five joints keep the position. The tool cannot leave the upright plane of the arm, out of which the tilt turns its
# axis: by arcsin(sin pitch · sin roll) in the end.
five = load_arm("rover_arm")
position, angle = hold(five, five.ready, feed_forward=True)
print(f"five joints: at most {1e3 * position.max():.3f} mm off, in the end turned by {np.degrees(angle[-1]):.3f}°")
assert position.max() < 1e-3
assert np.isclose(angle[-1], np.arcsin(np.sin(pitch) * np.sin(roll)), rtol=0.01)
