"""The six joint types, each as an arm of its own: moved, its claim checked, and the way of its tool drawn on a page."""

import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistarm import ArmBuilder, crosscheck, joints, plan_joint, save_html

home = np.eye(4)
home[:3, 3] = [0.3, 0.0, 0.4]  # m
up, origin, pitch = [0, 0, 1], [0, 0, 0.2], 0.02  # the helical joint advances 0.02 m per radian

# The same joint twice: built into an arm, and as the product of twists that it stands for.
arms = {
    "revolute": (ArmBuilder("revolute").revolute("j", up, origin), joints.revolute(up, origin)),
    "prismatic": (ArmBuilder("prismatic").prismatic("j", up), joints.prismatic(up)),
    "helical": (ArmBuilder("helical").helical("j", up, origin, pitch), joints.helical(up, origin, pitch)),
    "cylindrical": (ArmBuilder("cylindrical").cylindrical("j", up, origin), joints.cylindrical(up, origin)),
    "spherical": (ArmBuilder("spherical").spherical("j", origin), joints.spherical(origin)),
    "planar": (ArmBuilder("planar").planar("j", up, origin), joints.planar(up, origin)),
}
farthest = {
    "revolute": [np.pi],
    "prismatic": [0.25],
    "helical": [4 * np.pi],
    "cylindrical": [np.pi, 0.25],
    "spherical": [np.pi, 0.6, -0.8],
    "planar": [0.3, 0.2, np.pi],
}


def claim(kind: str, theta: NDArray[np.float64], p: NDArray[np.float64]) -> bool:
    """What the path p (k, 3) of the tool must be, seen from geometry alone."""
    radius, height = np.linalg.norm(p[:, :2], axis=1), p[:, 2]
    if kind == "revolute":
        return np.allclose(radius, 0.3) and np.allclose(height, 0.4)  # a circle
    if kind == "prismatic":
        return np.allclose(p - p[:1], theta * [0, 0, 1])  # a straight line
    if kind == "helical":
        return np.allclose(radius, 0.3) and np.allclose(height, 0.4 + pitch * theta[:, 0])  # a helix
    if kind == "cylindrical":
        return np.allclose(radius, 0.3) and np.allclose(height, 0.4 + theta[:, 1])  # on a cylinder
    if kind == "spherical":
        return np.allclose(np.linalg.norm(p - origin, axis=1), np.hypot(0.3, 0.2))  # on a sphere
    return np.allclose(height, 0.4) and np.allclose(np.linalg.norm(p[:, :2] - theta[:, :2], axis=1), 0.3)  # in a plane


with tempfile.TemporaryDirectory() as scratch:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else scratch)
    for kind, (builder, twists) in arms.items():
        arm = builder.tool(home).build()
        assert np.allclose(arm.screws @ arm.coupling.A, twists)

        # Against Pinocchio twice, as it reads the URDF and by its own joint of this type, and against differences.
        worst = crosscheck(arm, samples=200).require().worst("pinocchio")
        assert worst < 1e-12

        bounds = {"velocity": 2.0, "acceleration": 4.0}
        motion = plan_joint(arm, [np.zeros(arm.n), farthest[kind]], limits=bounds)
        theta = motion(np.linspace(0.0, motion.duration, 200))
        assert claim(kind, theta, arm.fk(theta)[:, :3, 3])

        page = save_html(arm, folder / f"{kind}.html", trajectory=motion)
        print(f"{kind:<11} {', '.join(arm.joint_names):<16} {worst:.0e} from Pinocchio   {page.name}")
