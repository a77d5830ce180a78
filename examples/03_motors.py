"""Motors that are not joints: a differential wrist in the arm.toml, its counts, speeds and torques, and its wiring."""

import shutil
import tempfile
from pathlib import Path

import numpy as np

from twistarm import check_wiring, load_arm
from twistarm.calibration import Measurements
from twistarm.control.servo import JogCommand, ServoState, servo_step

ROBOT = Path(__file__).parents[1] / "robots" / "rover_arm"
WRIST = "unit = 'tick'\nticks_per_turn = 4096\nlimits = { velocity = 90.0, effort = 0.2 }\n"  # rad/s, N m
MOTORS = f"""
[actuators.rail]
ratio = {{ slide = 400.0 }}
[actuators.shoulder]
ratio = {{ shoulder = 100.0 }}
[actuators.elbow]
ratio = {{ elbow = -80.0 }}
[actuators.left]
ratio = {{ wrist_pitch = 60.0, wrist_roll = 60.0 }}
{WRIST}
[actuators.right]
ratio = {{ wrist_pitch = 60.0, wrist_roll = -60.0 }}
{WRIST}"""

with tempfile.TemporaryDirectory() as folder:
    file = shutil.copytree(ROBOT, Path(folder) / "our_arm") / "arm.toml"
    file.write_text(file.read_text() + MOTORS)
    arm = load_arm(file)
motors = arm.actuators
assert motors is not None

# There and back: for a turn of the roll the two drives count 60 turns, against each other.
turn = arm.theta_from({**arm.theta_to_dict(arm.ready), "wrist_roll": 2 * np.pi})
counts = motors.to_counts(motors.to_motor([arm.ready, turn]))
assert np.allclose(np.diff(counts, axis=0)[0, 3:], [60 * 4096, -60 * 4096])
assert np.allclose(motors.to_theta(motors.from_counts(counts)), [arm.ready, turn])

# Both motors carry the pitch, half each; the power is the same on both sides of the gears.
tau = arm.inverse_dynamics(arm.ready, payload=1.0)
tau_motor, rates = motors.torque_to_motor(tau), np.array([0.1, 0.2, -0.3, 0.4, 0.5])
assert np.allclose(tau_motor[3:], (tau[3] + [tau[4], -tau[4]]) / 120)
assert np.isclose(tau_motor @ motors.velocity_to_motor(rates), tau @ rates)

# 1.2 rad/s are within the limits of pitch and of roll. Of both at once, the left motor would make 144 rad/s.
wanted = JogCommand.of(arm, {"wrist_pitch": 1.2, "wrist_roll": 1.2})
assert (wanted.theta_dot <= arm.limits.velocity).all()
state = ServoState.at(arm, arm.ready)
for _ in range(50):
    state, output = servo_step(arm, state, wanted, dt=0.01)
assert (output.status, output.joint) == ("SLOWED_LIMIT", "left")
assert np.isclose(output.scale, 90 / 144)
print(f"{output.explain()}: {output.scale:.1%} of the jog")

# The right encoder counts backwards. Fifteen configurations, with the tool measured to a millimetre, show which one.
rng = np.random.default_rng(0)
theta = arm.random_theta(rng, 15)
measured = arm.fk(theta)
measured[:, :3, 3] += rng.normal(scale=0.001, size=(15, 3))
counts = motors.to_counts(motors.to_motor(theta))
counts[:, 4] *= -1
report = check_wiring(arm, Measurements(counts, measured[:, :3, 3], measured[:, :3, :3]))
assert {each.name: each.faults for each in report.motors if each.faults} == {"right": ("flipped sign",)}
print(f"right: {report.motors[4].what}; {report.motors[4].remedy}")
