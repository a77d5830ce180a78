"""Push 0.3 m straight along the normal of a tilted panel with five joints: the orientation is held on the way."""

import numpy as np

from twistarm import load_arm, rotations, solve_ik
from twistarm.control.servo import ServoState, TwistCommand, servo_step

arm, dt, speed, length = load_arm("rover_arm"), 0.01, 0.1, 0.3  # s, m/s, m

# A panel that leans back by 10°: the tool turns with it about y, and its z axis is the normal.
g = arm.fk(arm.ready)
g[:3, :3] = rotations.exp(np.radians([0, 10, 0])) @ g[:3, :3]
g[:3, 3] = [0.65, 0.2, 0.68]
normal = g[:3, 2]

# Both ends must be within reach, on the same branch: that is known before anything moves.
beyond = g.copy()
beyond[:3, 3] += length * normal
begin = solve_ik(arm, g).require()
end = solve_ik(arm, beyond, begin).require()
assert np.sign(begin[2]) == np.sign(end[2]), "the elbow is on one side all the way"

state, poses = ServoState.at(arm, begin), [arm.fk(begin)]
for _ in range(600):
    left = length - float(normal @ (poses[-1] - poses[0])[:3, 3])
    command = TwistCommand([0, 0, min(speed, 3 * left), 0, 0, 0], hold="orientation")
    state, output = servo_step(arm, state, command, dt)
    poses.append(arm.fk(state.theta))

way = np.array(poses)[:, :3, 3] - poses[0][:3, 3]
off_line = np.linalg.norm(way - np.outer(way @ normal, normal), axis=1).max()
turned = np.linalg.norm(rotations.log(np.array(poses)[:, :3, :3] @ poses[0][:3, :3].T), axis=1).max()
assert off_line < 1e-4, "straight to a tenth of a millimetre"
assert turned < 1e-4, "and parallel to 0.1 mrad"
assert abs(way[-1] @ normal - length) < 1e-3
assert np.allclose(state.theta, end, atol=0.01), "where inverse kinematics said that it ends"
print(f"{1e3 * way[-1] @ normal:.2f} mm along the normal, {1e6 * off_line:.2f} µm off, {1e6 * turned:.2f} µrad turned")
