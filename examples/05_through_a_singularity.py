"""Jog the tool outward until the arm is stretched, go through the straight elbow to the other branch, and come back."""

import numpy as np
from numpy.typing import NDArray

from twistarm import load_arm
from twistarm.control.servo import (
    AnyCommand,
    JogCommand,
    PoseCommand,
    ServoOutput,
    ServoState,
    TwistCommand,
    servo_step,
)

Array = NDArray[np.float64]

arm, dt, speed = load_arm("rover_arm_6dof"), 0.01, 0.1  # s, m/s
rest = JogCommand.of(arm, {})
longest = 0.35 + np.hypot(0.12 + 0.51, 0.03)  # from the shoulder to the wrist, m: the README of the robot


def outward(theta: Array) -> tuple[float, Array]:
    """From the shoulder to the wrist, in the upright plane of the arm: (distance, direction)."""
    way = (arm.pose(theta, "wrist") - arm.pose(theta, "upper_arm"))[:3, 3] * [1, 0, 1]
    distance = float(np.linalg.norm(way))
    return distance, way / distance


def drive(state: ServoState, command: AnyCommand, seconds: float) -> tuple[ServoState, Array, list[ServoOutput]]:
    """The last state, the velocities of the tool (k, 3) and the outputs; the joints' limits hold, whatever happens."""
    states, outputs = [state], []
    for _ in range(round(seconds / dt)):
        state, output = servo_step(arm, state, command, dt)
        states.append(state)
        outputs.append(output)
    theta, rates = (np.array([getattr(each, name) for each in states]) for name in ("theta", "theta_dot"))
    assert arm.limits.contains(theta).all()
    assert (np.abs(rates) <= arm.limits.velocity * (1 + 1e-9)).all()
    assert (np.abs(np.diff(rates, axis=0)) <= arm.limits.acceleration * dt * (1 + 1e-9)).all()
    return state, np.diff(arm.fk(theta)[:, :3, 3], axis=0) / dt, outputs


def jog_tool(state: ServoState, v: Array, seconds: float) -> tuple[ServoState, ServoOutput]:
    """A straight jog of the tool: as asked where nothing is slowed, and from one speed to the next without a shake."""
    state, velocities, outputs = drive(state, TwistCommand([*v, 0, 0, 0], frame="base"), seconds)
    steady = [output.status == "OK" and output.scale > 1 - 1e-6 for output in outputs]
    assert sum(steady) > 50
    assert np.linalg.norm(velocities[steady] - v, axis=1).max() < 1e-3 * speed
    # It speeds up once and slows down once: the changes from cycle to cycle add up to no more than that.
    assert np.linalg.norm(np.diff(velocities, axis=0), axis=1).sum() < 2.1 * speed
    return drive(state, rest, 0.5)[0], outputs[-1]


def jog_elbow(state: ServoState, rate: float, seconds: float) -> ServoState:
    state, _, _ = drive(state, JogCommand.of(arm, {"elbow_pitch": rate}), seconds)
    return drive(state, rest, 0.5)[0]


start = ServoState.at(arm, arm.ready)
state, output = jog_tool(start, speed * outward(arm.ready)[1], 6.0)
assert output.status == "SLOWED_SINGULARITY"
assert longest - outward(state.theta)[0] < 1e-4, "stretched to the tenth of a millimetre"
print(f"stretched, {1e3 * outward(state.theta)[0]:.1f} of {1e3 * longest:.1f} mm: {output.explain()}")

# No twist says on which side of straight the elbow should be. A jog of the joint does.
state = jog_elbow(state, -0.4, 1.2)
assert state.theta[2] < -0.3 < 0.3 < start.theta[2], "the other branch"
state, output = jog_tool(state, -speed * outward(state.theta)[1], 1.0)
assert output.status == "OK", "inside it moves as asked on this branch too"

# Out again, back through straight, and to the pose where it began: the same pose, on the same branch.
state, output = jog_tool(state, speed * outward(state.theta)[1], 4.0)
assert output.status == "SLOWED_SINGULARITY"
state = jog_elbow(state, 0.4, 1.2)
state, _, outputs = drive(state, PoseCommand(arm.fk(arm.ready)), 5.0)
assert outputs[-1].status == "OK"
assert np.allclose(state.theta, arm.ready, atol=1e-4)
print("through the straight elbow, back, and at the start again, without a jump")
