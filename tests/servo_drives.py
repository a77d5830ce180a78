"""Random arms and drives for the servo, and what no drive may do."""

from dataclasses import replace

import numpy as np

from twistarm import Actuators, JointLimits, arm_from_screws, joints
from twistarm.control.servo import JogCommand, PoseCommand, ServoState, TwistCommand, servo_step

DT = 0.01

# Of the way: how far the tool may be from where the twist would have carried it, away from singularities.
TRACKING = 1e-3
# so101 with its tool level, so that going sideways turns it: the wrist cannot take that back.
LEVEL = np.array([-0.02, -0.1, 1.09, -1.08, 2.01])
# Rounding of a sum: θ + dt θ̇ against the limits, and rates against theirs.
POSITION_TOL, RATE_TOL = 1e-12, 1e-9


def random_arm(rng, n, unlimited=False):
    """n joints on axes that are square to each other or not, a slide now and then, and limits on everything."""
    screws, point = [], np.zeros(3)
    for _ in range(n):
        axis = np.eye(3)[rng.integers(3)] if rng.random() < 0.6 else rng.normal(size=3)
        screws.append(joints.prismatic(axis) if rng.random() < 0.15 else joints.revolute(axis, point))
        point = point + rng.uniform(-0.3, 0.3, 3)
    home = np.eye(4)
    home[:3, 3] = point
    if unlimited:
        return arm_from_screws(np.hstack(screws), home, name=f"random{n}")
    most = np.full(n, np.inf)
    lower, upper = -rng.uniform(0.2, 3.0, n), rng.uniform(0.2, 3.0, n)
    limits = JointLimits(lower, upper, rng.uniform(0.5, 3.0, n), rng.uniform(1.0, 20.0, n), most, most)
    return arm_from_screws(np.hstack(screws), home, limits=limits, name=f"random{n}")


WRIST = np.array([[0.0, 0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 0.0, 2.0, -2.0]])
"""Two motors of a differential wrist, on an arm of five joints."""


def with_motors(arm, G, position=np.inf, velocity=np.inf, acceleration=np.inf):
    """The arm with motors x = G theta, all with these limits."""
    k = len(G)
    bounds = (np.full(k, value) for value in (-position, position, velocity, acceleration, np.inf, np.inf))
    names, unit = tuple(f"motor_{i}" for i in range(k)), ("rad",) * k
    motors = Actuators(names, arm.joint_names, G, np.zeros(k), unit, np.full(k, np.nan), JointLimits(*bounds))
    return replace(arm, actuators=motors)


def random_twist(rng):
    return rng.normal(size=6) * [0.3, 0.3, 0.3, 0.8, 0.8, 0.8] * (rng.random(6) < 0.6)


def next_command(rng, arm, last):
    """A jog, a pose, a twist, the last twist back, or one with held components."""
    choice = rng.integers(6)
    if choice == 0:
        return JogCommand(rng.normal(size=arm.n))
    if choice == 1:
        return PoseCommand(arm.fk(arm.random_theta(rng)))
    if choice == 2 and isinstance(last, TwistCommand):
        return TwistCommand(-last.twist, last.frame, last.hold)
    frame = ("tool", "base")[rng.integers(2)]
    if choice == 3:
        return TwistCommand([*random_twist(rng)[:3], 0, 0, 0], frame, "orientation")
    return TwistCommand(random_twist(rng), frame)


def broken(arm, before, after, dt):
    """Which of the limits a step breaks, in words."""
    limits, faults = arm.limits, []
    if not np.isfinite(after.theta).all() or not np.isfinite(after.theta_dot).all():
        faults.append("not finite")
    if (after.theta < limits.lower - POSITION_TOL).any() or (after.theta > limits.upper + POSITION_TOL).any():
        faults.append("position")
    if (np.abs(after.theta_dot) > limits.velocity * (1 + RATE_TOL)).any():
        faults.append("velocity")
    if (np.abs(after.theta_dot - before.theta_dot) > limits.acceleration * dt * (1 + 1e-6) + RATE_TOL).any():
        faults.append("acceleration")
    return faults


def drive(seed, steps=200):
    """One random drive through whatever comes; the faults found, with the step."""
    rng = np.random.default_rng(seed)
    arm = random_arm(rng, seed[-2])
    start = (
        arm.random_theta(rng) if rng.random() < 0.7 else np.clip(np.zeros(arm.n), arm.limits.lower, arm.limits.upper)
    )
    state, command, faults = ServoState.at(arm, start), None, []
    for k in range(steps):
        if k % 25 == 0:
            command = next_command(rng, arm, command)
        dt = rng.choice([0.003, 0.01, 0.02])
        after, _ = servo_step(arm, state, command, dt)
        faults += [(k, fault) for fault in broken(arm, state, after, dt)]
        state = after
    return arm, state, faults


def travelled(arm, state, twist, seconds, dt=0.02):
    """How far the tool gets under a twist in base axes: metres over the reach, plus |R − R'|; and the state there."""
    g = arm.fk(state.theta)
    for _ in range(round(seconds / dt)):
        state, _ = servo_step(arm, state, TwistCommand(twist, "base"), dt)
    h = arm.fk(state.theta)
    return np.linalg.norm(h[:3, 3] - g[:3, 3]) / arm.reach + np.linalg.norm(h[:3, :3] - g[:3, :3]), state


def pose(arm, state):
    """Where the tool is, by Pinocchio."""
    return arm.by_pinocchio(state.theta)[0]


def driven(arm, state, command, steps, dt=DT, **settings):
    """The state after some steps, and the last output."""
    for _ in range(steps):
        state, output = servo_step(arm, state, command, dt, **settings)
    return state, output


def up_to_speed(arm, command, theta=None, dt=DT):
    """A state from theta (ready) in which the arm moves as commanded."""
    state = ServoState.at(arm, arm.ready if theta is None else theta)
    for _ in range(500):
        state, output = servo_step(arm, state, command, dt)
        if output.scale > 1.0 - 1e-9:
            return state
    raise AssertionError("the command was never reached")
