"""The product of exponentials, against Pinocchio on random chains, finite differences and the textbooks' examples."""

import numpy as np
import pytest

from joint_arms import Reference, random_chain, screws_of
from strategies import BATCHES, EPS, close
from twistarm import joints, poe, screws

# Two accounts of a chain of up to nine joints, each some 1 m long: rounding of nine products.
PINOCCHIO = 1e-13
BATCH = 256 * EPS  # The same chain, one by one and in a batch: NumPy orders sums differently.

KINDS = ("revolute", "prismatic", "helical")


class Chain:
    """A random chain of joints about oblique axes: screws and home, and Pinocchio's model of it."""

    def __init__(self, kinds, seed):
        chain, self.home = random_chain(kinds, seed)
        self.screws, self.m = np.hstack([screws_of(joint) for joint in chain]), len(kinds)
        self.pinocchio, self.x = Reference(chain, self.home), np.random.default_rng(seed).uniform(-3, 3, self.m)


CHAINS = [
    *(Chain([kind], seed) for seed, kind in enumerate(KINDS)),
    *(Chain(np.random.default_rng(seed).choice(KINDS, size=n), seed) for seed, n in enumerate((2, 3, 5, 6, 7, 9))),
]


@pytest.mark.parametrize("chain", CHAINS)
def test_forward_kinematics_agrees_with_pinocchio(chain):
    close(poe.fk(chain.screws, chain.home, np.zeros(chain.m)), chain.home, BATCH)
    close(poe.fk(chain.screws, chain.home, chain.x), chain.pinocchio(chain.x)[0], PINOCCHIO)


@pytest.mark.parametrize("chain", CHAINS)
def test_jacobians_agree_with_pinocchio(chain):
    _, spatial, body = chain.pinocchio(chain.x)
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
    close(poe.fk(chain.screws * gear, chain.home, chain.x / gear), chain.pinocchio(chain.x)[0], PINOCCHIO)


def test_a_chain_without_joints_stands_still():
    none, home = np.zeros((6, 0)), CHAINS[0].home
    assert (poe.fk(none, home, []) == home).all()
    assert poe.fk(none, home, np.zeros((5, 0))).shape == (5, 4, 4)
    assert poe.fk_body(none, home, np.zeros((5, 0))).shape == (5, 4, 4)
    assert poe.spatial_jacobian(none, np.zeros((5, 0))).shape == (5, 6, 0)
    assert poe.body_jacobian(none, home, np.zeros((5, 0))).shape == (5, 6, 0)


PRINTED_3 = 6e-4  # Three printed decimals, computed from inputs of three decimals.

X, Y, Z = np.eye(3)


def rot_z(a):
    return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])


def pose(R, p):
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = R, p
    return g


def lynch_park(*rows):
    """A (6, m) stack from rows of (w, v), as the book prints them."""
    return screws.from_angular_first(np.array(rows, dtype=float), twists="rows").T


def test_mls_example_3_9_stanford_arm():
    """Its spatial Jacobian, column i (−ω' × q', ω') for the axis where it stands; its wrist's position."""
    L0, L1 = 0.4, 0.55
    q1, wrist = [0, 0, L0], [0, L1, L0]
    S = np.hstack([
        joints.revolute(Z, q1), joints.revolute(-X, q1), joints.prismatic(Y),
        joints.revolute(Z, wrist), joints.revolute(-X, wrist), joints.revolute(Y, wrist),
    ])  # fmt: skip
    for theta in np.random.default_rng(1).uniform(-3, 3, size=(20, 6)):
        (s1, s2, _, s4, s5, _), (c1, c2, _, c4, c5, _) = np.sin(theta), np.cos(theta)
        reach = L1 + theta[2]
        qw = np.array([-reach * s1 * c2, reach * c1 * c2, L0 - reach * s2])
        w2 = np.array([-c1, -s1, 0])
        w4 = np.array([-s1 * s2, c1 * s2, c2])
        w5 = np.array([-c1 * c4 + s1 * c2 * s4, -s1 * c4 - c1 * c2 * s4, s2 * s4])
        w6 = np.array([
            -c5 * (s1 * c2 * c4 + c1 * s4) + s1 * s2 * s5,
            c5 * (c1 * c2 * c4 - s1 * s4) - c1 * s2 * s5,
            -s2 * c4 * c5 - c2 * s5,
        ])  # fmt: skip
        columns = [
            [0, 0, 0, *Z],
            [L0 * s1, -L0 * c1, 0, *w2],
            [-s1 * c2, c1 * c2, -s2, 0, 0, 0],
            *([*np.cross(qw, w), *w] for w in (w4, w5, w6)),
        ]
        close(poe.spatial_jacobian(S, theta), np.transpose(columns))
        close(poe.fk(S, pose(np.eye(3), wrist), theta)[:3, 3], qw)


def test_lynch_park_twist_of_a_turning_car():
    """L&P §3.3.2: seen from {s} and from {b}, V_s = (0, 0, 2, −2, −4, 0), V_b = (0, 0, −2, 2.8, 4, 0)."""
    T_sb = pose([[-1, 0, 0], [0, 1, 0], [0, 0, -1]], [4, 0.4, 0])
    V_s, V_b = lynch_park([0, 0, 2, -2, -4, 0], [0, 0, -2, 2.8, 4, 0]).T
    close(screws.transform_twist(T_sb, V_b), V_s)
    close(screws.to_screw(V_s).point, [2, -1, 0])
    close(screws.to_screw(V_b).point, [2, -1.4, 0])


def test_lynch_park_screw_between_two_planar_frames():
    """L&P §3.3.3.2, example 3.26: from (1, 2), 30° to (2, 1), 60° by S = (0, 0, 1, 3.37, −3.37, 0), θ = 30°."""
    T_sb = pose(rot_z(np.radians(30)), [1, 2, 0])
    T_sc = pose(rot_z(np.radians(60)), [2, 1, 0])
    xi = screws.log(T_sc @ screws.inverse(T_sb))
    theta = screws.to_screw(xi).magnitude
    close(theta, np.radians(30))
    close(screws.to_angular_first(xi) / theta, [0, 0, 1, 3.37, -3.37, 0], 5e-3)
    close(screws.exp(xi) @ T_sb, T_sc)


def test_lynch_park_wrench_of_a_hand_holding_an_apple():
    """L&P §3.4, example 3.28: the force-torque sensor reads F_f = (0, 0, −0.75, 0, −6, 0), (m, f) in N m and N."""
    F_h, F_a = lynch_park([0, 0, 0, 0, -5, 0], [0, 0, 0, 0, 0, 1]).T
    T_hf = pose(np.eye(3), [-0.1, 0, 0])
    T_af = pose([[1, 0, 0], [0, 0, 1], [0, -1, 0]], [-0.25, 0, 0])
    F_f = screws.transform_wrench(screws.inverse(T_hf), F_h) + screws.transform_wrench(screws.inverse(T_af), F_a)
    close(screws.to_angular_first(F_f), [0, 0, -0.75, 0, -6, 0])


def test_lynch_park_example_4_5_ur5():
    """L&P §4.1.2, example 4.5: the UR5 at θ₂ = −π/2, θ₅ = π/2, the printed matrix."""
    W1, W2, A1, A2, H1, H2 = 0.109, 0.082, 0.425, 0.392, 0.089, 0.095
    S = lynch_park(
        [0, 0, 1, 0, 0, 0], [0, 1, 0, -H1, 0, 0], [0, 1, 0, -H1, 0, A1],
        [0, 1, 0, -H1, 0, A1 + A2], [0, 0, -1, -W1, A1 + A2, 0], [0, 1, 0, H2 - H1, 0, A1 + A2],
    )  # fmt: skip
    M = pose([[-1, 0, 0], [0, 0, 1], [0, 1, 0]], [A1 + A2, W1 + W2, H1 - H2])
    g = poe.fk(S, M, [0, -np.pi / 2, 0, 0, np.pi / 2, 0])
    close(g, [[0, -1, 0, 0.095], [1, 0, 0, 0.109], [0, 0, 1, 0.988], [0, 0, 0, 1]], PRINTED_3)
