"""The product of exponentials, against Pinocchio on random chains, finite differences and its own body form."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from strategies import BATCHES, EPS, close
from twistarm import poe, screws

# Two accounts of a chain of up to nine joints, each some 1 m long: rounding of nine products.
PINOCCHIO = 1e-13
BATCH = 256 * EPS  # The same chain, one by one and in a batch: NumPy orders sums differently.

KINDS = ("revolute", "prismatic", "helical")


class Chain:
    """A random chain of joints about oblique axes: its Pinocchio model, and screws and home by geometry."""

    def __init__(self, kinds, seed):
        rng = np.random.default_rng(seed)
        self.model, self.m = pin.Model(), len(kinds)
        columns, g, parent = [], np.eye(4), 0
        for i, kind in enumerate(kinds):
            step = random_pose(rng)
            g = g @ step
            axis = Rotation.random(random_state=seed + i).as_matrix()[:, 0]
            pitch = rng.normal()
            joint = {
                "revolute": lambda a=axis: pin.JointModelRevoluteUnaligned(a),
                "prismatic": lambda a=axis: pin.JointModelPrismaticUnaligned(a),
                "helical": lambda a=axis, h=pitch: pin.JointModelHelicalUnaligned(a, h),
            }[kind]()
            parent = self.model.addJoint(parent, joint, pin.SE3(step), f"joint_{i}")
            w, q = g[:3, :3] @ axis, g[:3, 3]
            columns.append({
                "revolute": [*np.cross(q, w), *w],
                "prismatic": [*w, 0, 0, 0],
                "helical": [*(np.cross(q, w) + pitch * w), *w],
            }[kind])  # fmt: skip
        tool = random_pose(rng)
        self.home = g @ tool
        self.tool = self.model.addFrame(pin.Frame("tool", parent, 0, pin.SE3(tool), pin.FrameType.OP_FRAME))
        self.data = self.model.createData()
        self.screws = np.array(columns).T
        self.x = rng.uniform(-3, 3, size=self.m)
        self.rate = rng.normal(size=self.m)

    def fk(self, x):
        pin.framesForwardKinematics(self.model, self.data, x)
        return self.data.oMf[self.tool].homogeneous

    def jacobian(self, x, frame):
        return pin.computeFrameJacobian(self.model, self.data, x, self.tool, frame).reshape(6, -1)


def random_pose(rng):
    g = np.eye(4)
    g[:3, :3] = Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
    g[:3, 3] = rng.normal(size=3)
    return g


CHAINS = [
    *(Chain([kind], seed) for seed, kind in enumerate(KINDS)),
    *(Chain(np.random.default_rng(seed).choice(KINDS, size=n), seed) for seed, n in enumerate((2, 3, 5, 6, 7, 9))),
]


@pytest.mark.parametrize("chain", CHAINS)
def test_forward_kinematics_agrees_with_pinocchio(chain):
    close(poe.fk(chain.screws, chain.home, np.zeros(chain.m)), chain.home, BATCH)
    close(poe.fk(chain.screws, chain.home, chain.x), chain.fk(chain.x), PINOCCHIO)


@pytest.mark.parametrize("chain", CHAINS)
def test_jacobians_agree_with_pinocchio(chain):
    spatial = chain.jacobian(chain.x, pin.ReferenceFrame.WORLD)
    body = chain.jacobian(chain.x, pin.ReferenceFrame.LOCAL)
    close(poe.spatial_jacobian(chain.screws, chain.x), spatial, 10 * PINOCCHIO)
    close(poe.body_jacobian(chain.screws, chain.home, chain.x), body, 10 * PINOCCHIO)


@pytest.mark.parametrize("chain", CHAINS)
def test_the_body_form_is_the_same_motion(chain):
    B = poe.body_screws(chain.screws, chain.home)
    close(screws.adjoint(chain.home) @ B, chain.screws, BATCH * 10)
    close(poe.fk_body(B, chain.home, chain.x), poe.fk(chain.screws, chain.home, chain.x), PINOCCHIO)
    at_home = poe.body_jacobian(chain.screws, chain.home, np.zeros(chain.m))
    close(at_home, B, BATCH * 10)


@pytest.mark.parametrize("batch", BATCHES)
def test_a_batch_is_its_configurations_one_by_one(batch):
    chain = CHAINS[-1]
    x = np.random.default_rng(1).uniform(-3, 3, size=(*batch, chain.m))
    B = poe.body_screws(chain.screws, chain.home)
    functions = (
        (lambda x: poe.fk(chain.screws, chain.home, x), (4, 4)),
        (lambda x: poe.fk_body(B, chain.home, x), (4, 4)),
        (lambda x: poe.spatial_jacobian(chain.screws, x), (6, chain.m)),
        (lambda x: poe.body_jacobian(chain.screws, chain.home, x), (6, chain.m)),
    )
    for function, shape in functions:
        whole = function(x)
        assert whole.shape == (*batch, *shape)
        for index in np.ndindex(batch):
            close(whole[index], function(x[index]), 10 * BATCH)


def test_a_screw_of_any_length_is_a_rescaled_joint():
    chain = CHAINS[-1]
    gear = np.array([2.0, -0.5, 10.0, 1e-3, 1.0, 3.0, 0.1, 7.0, 1e3])
    close(poe.fk(chain.screws * gear, chain.home, chain.x / gear), chain.fk(chain.x), PINOCCHIO)


def test_a_chain_without_joints_stands_still():
    none, home = np.zeros((6, 0)), CHAINS[0].home
    assert (poe.fk(none, home, []) == home).all()
    assert poe.fk(none, home, np.zeros((5, 0))).shape == (5, 4, 4)
    assert poe.fk_body(none, home, np.zeros((5, 0))).shape == (5, 4, 4)
    assert poe.spatial_jacobian(none, np.zeros((5, 0))).shape == (5, 6, 0)
    assert poe.body_jacobian(none, home, np.zeros((5, 0))).shape == (5, 6, 0)
