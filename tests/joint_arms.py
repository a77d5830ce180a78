"""Random chains of the six joint types, written three ways, and the same chain of Pinocchio's own joint models.

The reference takes nothing from twistarm: rotations come from SciPy, motions and Jacobians from Pinocchio, the maps
from coordinates to Pinocchio's velocities from the textbooks.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from twistarm import Arm, ArmBuilder, arm_from_screws, joints, load_arm

DEGREES = {"revolute": 1, "prismatic": 1, "helical": 1, "cylindrical": 2, "spherical": 3, "planar": 3}
KINDS = tuple(DEGREES)

ZERO = '<limit lower="-9" upper="9" velocity="1" effort="1"/>'


@dataclass(frozen=True)
class Joint:
    """One joint in the base frame at rest: z of `R` is its axis or normal, and a ball's or plane's whole frame `R`."""

    kind: str
    R: np.ndarray
    point: np.ndarray
    pitch: float

    @property
    def axis(self):
        return self.R[:, 2]


def random_rotation(rng):
    return Rotation.from_quat(rng.normal(size=4)).as_matrix()


def random_chain(kinds, seed):
    """Joints of those kinds at random places, and a random home pose."""
    rng = np.random.default_rng(seed)
    chain = [Joint(kind, random_rotation(rng), rng.uniform(-1, 1, 3), rng.uniform(-0.2, 0.2)) for kind in kinds]
    home = np.eye(4)
    home[:3, :3], home[:3, 3] = random_rotation(rng), rng.uniform(-1, 1, 3)
    return chain, home


# three ways to write it -----------------------------------------------------------------------------------------


def screws_of(j, length=1.0):
    """The screws (6, k) of one joint. Its axis or normal may have any length."""
    axis = length * j.axis
    return {
        "revolute": lambda: joints.revolute(axis, j.point),
        "prismatic": lambda: joints.prismatic(axis),
        "helical": lambda: joints.helical(axis, j.point, j.pitch),
        "cylindrical": lambda: joints.cylindrical(axis, j.point),
        "spherical": lambda: joints.spherical(j.point, j.R),
        "planar": lambda: joints.planar(axis, j.point, j.R[:, 0]),
    }[j.kind]()


def by_hand(chain, home, folder=None) -> Arm:
    return arm_from_screws(np.hstack([screws_of(j) for j in chain]), home)


def by_builder(chain, home, folder=None) -> Arm:
    builder = ArmBuilder("built")
    for i, j in enumerate(chain):
        name = f"j{i}"
        builder = {
            "revolute": lambda b=builder, n=name, j=j: b.revolute(n, j.axis, j.point),
            "prismatic": lambda b=builder, n=name, j=j: b.prismatic(n, j.axis),
            "helical": lambda b=builder, n=name, j=j: b.helical(n, j.axis, j.point, j.pitch),
            "cylindrical": lambda b=builder, n=name, j=j: b.cylindrical(n, j.axis, j.point),
            "spherical": lambda b=builder, n=name, j=j: b.spherical(n, j.point, j.R),
            "planar": lambda b=builder, n=name, j=j: b.planar(n, j.axis, j.point, j.R[:, 0]),
        }[j.kind]()
    return builder.tool(home).build()


def from_urdf(chain, home, folder: Path) -> Arm:
    """The documented ways, joint frames turned as the joint is: every axis is one of the frame's own."""
    path = folder / "arm.urdf"
    path.write_text(urdf(chain, home))
    return load_arm(path, tip="tool")


def urdf(chain, home) -> str:
    text, last, parent = ['<robot name="written"><link name="base_link"/>'], np.eye(4), "base_link"
    for i, j in enumerate(chain):
        here = np.eye(4)
        here[:3, :3], here[:3, 3] = j.R, j.point
        origin = np.linalg.inv(last) @ here
        for name, kind, axis, inside in written(j, f"j{i}"):
            text.append(element(name, kind, parent, f"{name}_body", origin, axis, inside))
            parent, origin = f"{name}_body", np.eye(4)
        last = here
    text.append(element("mount", "fixed", parent, "tool", np.linalg.inv(last) @ home, "0 0 1", ""))
    return "\n".join([*text, "</robot>"])


def written(j, name):
    """(name, type, axis, what else) of the URDF joints that make up a joint."""
    z = "0 0 1"
    if j.kind == "helical":
        mimic = f'<mimic joint="{name}" multiplier="{j.pitch!r}"/>'
        return [(name, "continuous", z, ""), (f"{name}_z", "prismatic", z, ZERO.replace("9", "1e9") + mimic)]
    if j.kind == "cylindrical":
        return [(f"{name}_rz", "continuous", z, ""), (f"{name}_z", "prismatic", z, ZERO)]
    if j.kind == "spherical":
        axes = {"rz": z, "ry": "0 1 0", "rx": "1 0 0"}
        return [(f"{name}_{suffix}", "continuous", axis, "") for suffix, axis in axes.items()]
    kind = "continuous" if j.kind == "revolute" else j.kind
    return [(name, kind, z, ZERO if kind == "prismatic" else "")]


def element(name, kind, parent, child, origin, axis, inside):
    rpy = Rotation.from_matrix(origin[:3, :3]).as_euler("xyz")
    xyz, rpy = (" ".join(map(repr, numbers.tolist())) for numbers in (origin[:3, 3], rpy))
    return (
        f'<link name="{child}"/><joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>{inside}</joint>'
    )


SOURCES = {"by hand": by_hand, "by builder": by_builder, "from URDF": from_urdf}


# Pinocchio's own joints -----------------------------------------------------------------------------------------


class Reference:
    """Pinocchio's model of the chain: RevoluteUnaligned, PrismaticUnaligned, HelicalUnaligned, a composite, Planar,
    and for the ball SphericalZYX or, with `quaternion`, Spherical."""

    def __init__(self, chain, home, quaternion=False):
        self.chain, self.quaternion = chain, quaternion
        self.model, joint, last = pin.Model(), 0, pin.SE3.Identity()
        for i, j in enumerate(chain):
            whole = j.kind in ("cylindrical", "spherical", "planar")
            here = pin.SE3(j.R if whole else np.eye(3), j.point)
            joint = self.model.addJoint(joint, self.joint_model(j), last.actInv(here), f"j{i}")
            last = here
        tool = pin.Frame("tool", joint, 0, last.actInv(pin.SE3(home)), pin.FrameType.OP_FRAME)
        self.tool = self.model.addFrame(tool)
        self.data = self.model.createData()

    def joint_model(self, j):
        if j.kind == "cylindrical":
            model = pin.JointModelComposite(2)
            model.addJoint(pin.JointModelRZ())
            model.addJoint(pin.JointModelPZ())
            return model
        return {
            "revolute": lambda: pin.JointModelRevoluteUnaligned(j.axis),
            "prismatic": lambda: pin.JointModelPrismaticUnaligned(j.axis),
            "helical": lambda: pin.JointModelHelicalUnaligned(j.axis, j.pitch),
            "spherical": pin.JointModelSpherical if self.quaternion else pin.JointModelSphericalZYX,
            "planar": pin.JointModelPlanar,
        }[j.kind]()

    def converted(self, theta):
        """Pinocchio's q, and the map from theta's rate to its velocities."""
        q, blocks, i = [], [], 0
        for j in self.chain:
            x = theta[i : i + DEGREES[j.kind]]
            i += len(x)
            if j.kind == "planar":
                c, s = np.cos(x[2]), np.sin(x[2])
                q += [x[0], x[1], c, s]
                blocks.append(np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]))
            elif j.kind == "spherical" and self.quaternion:
                q += Rotation.from_euler("ZYX", x).as_quat().tolist()
                # Diebel 2006, "Representing attitude", the body-axes rates of the sequence (3, 2, 1).
                (cb, sb), (cc, sc) = [(np.cos(angle), np.sin(angle)) for angle in x[1:]]
                blocks.append(np.array([[-sb, 0, 1], [cb * sc, cc, 0], [cb * cc, -sc, 0]]))
            else:
                q += x.tolist()
                blocks.append(np.eye(len(x)))
        N = np.zeros((sum(len(block) for block in blocks), len(theta)))
        row = 0
        for block in blocks:
            N[row : row + len(block), row : row + len(block)] = block
            row += len(block)
        return np.array(q), N

    def __call__(self, theta):
        """g, J^s, J^b at theta (n,)."""
        q, N = self.converted(np.asarray(theta))
        pin.computeJointJacobians(self.model, self.data, q)
        g = pin.updateFramePlacement(self.model, self.data, self.tool).homogeneous
        frames = pin.ReferenceFrame
        J_s, J_b = (
            pin.getFrameJacobian(self.model, self.data, self.tool, frame).reshape(6, -1) @ N
            for frame in (frames.WORLD, frames.LOCAL)
        )
        return g, J_s, J_b
