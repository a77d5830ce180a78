"""Worked examples of the two textbooks, and what the guide has to get right.

MLS: Murray, Li & Sastry, A Mathematical Introduction to Robotic Manipulation, 1994.
L&P: Lynch & Park, Modern Robotics, 2017; its twists are (w, v) and are written that way here.
"""

from __future__ import annotations

import numpy as np
import pytest

from strategies import EPS, derivative
from twistarm import joints, poe, rotations, screws

ROUNDING = 64 * EPS
"""Closed forms and products of up to seven exponentials, for arms of a few metres."""

DERIVATIVE = 1e-10
"""Sixth-order differences with h = 1e-3 on functions of order 1."""

PRINTED_3 = 6e-4
"""Three printed decimals, computed from inputs of three decimals."""

X, Y, Z = np.eye(3)
THETAS = np.random.default_rng(1).uniform(-3, 3, size=(20, 7))
"""Twenty arbitrary configurations; each arm takes as many columns as it has joints."""


def close(a, b, tol=ROUNDING):
    np.testing.assert_allclose(a, b, rtol=0, atol=tol)


def rot_x(a):
    return np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])


def rot_y(a):
    return np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])


def rot_z(a):
    return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])


def pose(R, p):
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = R, p
    return g


def sc(*angles):
    """The sines, then the cosines."""
    return [*np.sin(angles), *np.cos(angles)]


def lynch_park(*rows):
    """A (6, m) stack from rows of (w, v), as the book prints them."""
    return screws.from_angular_first(np.array(rows, dtype=float)).T


# MLS, chapter 2 ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("theta", [0.3, -2.0, 3.1])
def test_mls_elementary_rotations(theta):
    """MLS §2.2.2: e^{x̂θ}, e^{ŷθ}, e^{ẑθ}."""
    close(rotations.exp(X, theta), rot_x(theta))
    close(rotations.exp(Y, theta), rot_y(theta))
    close(rotations.exp(Z, theta), rot_z(theta))


def test_mls_rodrigues_written_out():
    """MLS §2.2.2, after eq. 2.14: the entries of e^{ŵθ} with v_θ = 1 − cos θ, for ‖w‖ = 1."""
    w1, w2, w3 = np.array([2.0, -3.0, 6.0]) / 7
    s, c, v = np.sin(0.8), np.cos(0.8), 1 - np.cos(0.8)
    expected = [
        [w1**2 * v + c, w1 * w2 * v - w3 * s, w1 * w3 * v + w2 * s],
        [w1 * w2 * v + w3 * s, w2**2 * v + c, w2 * w3 * v - w1 * s],
        [w1 * w3 * v - w2 * s, w2 * w3 * v + w1 * s, w3**2 * v + c],
    ]
    close(rotations.exp([w1, w2, w3], 0.8), expected)


@pytest.mark.parametrize(("alpha", "beta", "gamma"), [(0.3, 1.1, -2.0), (-3.0, 0.2, 3.0), (1.0, 3.0, 0.5)])
def test_mls_zyz_angles(alpha, beta, gamma):
    """MLS §2.2.3: R = R_z(α) R_y(β) R_z(γ), written out, and its inverse for 0 < β < π."""
    sa, sb, sg, ca, cb, cg = sc(alpha, beta, gamma)
    R = np.array([
        [ca * cb * cg - sa * sg, -ca * cb * sg - sa * cg, ca * sb],
        [sa * cb * cg + ca * sg, -sa * cb * sg + ca * cg, sa * sb],
        [-sb * cg, sb * sg, cb],
    ])  # fmt: skip
    close(rotations.from_euler("ZYZ", [alpha, beta, gamma]), R)
    close(rotations.to_euler("ZYZ", R), [alpha, beta, gamma])


def test_mls_quaternion_of_an_axis_and_an_angle():
    """MLS §2.2.3: Q = (cos θ/2, w sin θ/2)."""
    w, theta = np.array([2.0, -3.0, 6.0]) / 7, 1.3
    Q = [np.cos(theta / 2), *(w * np.sin(theta / 2))]
    close(rotations.to_quaternion_wxyz(rotations.exp(w, theta)), Q)
    close(rotations.from_quaternion_wxyz(Q), rotations.exp(w, theta))


@pytest.mark.parametrize("theta", [0.0, 0.7, -2.5, 3.1])
def test_mls_rotation_about_a_line(theta):
    """MLS §2.3.2: the turn about z through (0, l₁, 0): ξ = (l₁, 0, 0, 0, 0, 1), p = l₁ (sin θ, 1 − cos θ, 0)."""
    l1 = 1.7
    xi = joints.revolute(Z, [0, l1, 0])[:, 0]
    close(xi, [l1, 0, 0, 0, 0, 1])
    close(screws.exp(xi, theta), pose(rot_z(theta), [l1 * np.sin(theta), l1 * (1 - np.cos(theta)), 0]))
    # A frame at rest in (0, l₁, 0) turns on the spot.
    close(screws.exp(xi, theta) @ pose(np.eye(3), [0, l1, 0]), pose(rot_z(theta), [0, l1, 0]))


@pytest.mark.parametrize("alpha", [0.01, 0.7, 2.5, 3.1])
def test_mls_twist_of_a_relative_pose(alpha):
    """MLS §2.3.2: the exponential coordinates of g = (R_z(α), (−l₂ sin α, l₁ + l₂ cos α, 0)), scaled to ‖w‖ = 1."""
    l1, l2 = 1.7, 0.6
    g = pose(rot_z(alpha), [-l2 * np.sin(alpha), l1 + l2 * np.cos(alpha), 0])
    v = [(l1 - l2) / 2, (l1 + l2) * np.sin(alpha) / (2 * (1 - np.cos(alpha))), 0]
    # 1 − cos α in the book's form loses digits as α → 0: 1e-16 / α² at the least angle here.
    close(screws.log(g) / alpha, [*v, 0, 0, 1], 1e-10)


@pytest.mark.parametrize("theta", [0.0, 0.7, -2.5])
def test_mls_spatial_and_body_velocity_of_one_joint(theta):
    """MLS §2.4: V^s = (l₁, 0, 0, 0, 0, 1), V^b = (−l₂, 0, 0, 0, 0, 1) for (R_z(θ), (−l₂ sin θ, l₁ + l₂ cos θ, 0))."""
    l1, l2 = 1.7, 0.6

    def g(t):
        return pose(rot_z(t), [-l2 * np.sin(t), l1 + l2 * np.cos(t), 0])

    g_dot = derivative(g, theta)
    spatial, body = [l1, 0, 0, 0, 0, 1], [-l2, 0, 0, 0, 0, 1]
    close(screws.vee(g_dot @ screws.inverse(g(theta))), spatial, DERIVATIVE)
    close(screws.vee(screws.inverse(g(theta)) @ g_dot), body, DERIVATIVE)
    close(screws.transform_twist(g(theta), body), spatial)
    close(screws.adjoint(g(theta)) @ body, spatial)


def test_mls_pitch_axis_and_magnitude():
    """MLS §2.3.3: h = wᵀv/‖w‖², axis through (w × v)/‖w‖², magnitude ‖w‖; the screw motion leads back."""
    v, w = np.array([1.0, -2.0, 0.5]), np.array([0.4, 1.2, -0.3])
    screw = screws.to_screw([*v, *w])
    close(screw.pitch, w @ v / (w @ w))
    close(screw.point, np.cross(w, v) / (w @ w))
    close(screw.magnitude, np.sqrt(w @ w))
    q, u, h, M = screw.point, w / np.sqrt(w @ w), w @ v / (w @ w), np.sqrt(w @ w)
    R = rotations.exp(u, M)
    close(screws.exp([*v, *w]), pose(R, (np.eye(3) - R) @ q + h * M * u))


# MLS, chapter 3 ---------------------------------------------------------------------------------------

L0, L1, L2 = 0.4, 0.55, 0.35

SCARA = np.array([[0, 0, 0, 0, 0, 1], [L1, 0, 0, 0, 0, 1], [L1 + L2, 0, 0, 0, 0, 1], [0, 0, 1, 0, 0, 0]]).T
SCARA_HOME = pose(np.eye(3), [0, L1 + L2, L0])


def test_mls_example_3_1_scara():
    """MLS §3.2.2, example 3.1: g_st(θ) of the SCARA manipulator."""
    built = np.hstack([
        joints.revolute(Z, [0, 0, 0]), joints.revolute(Z, [0, L1, 0]),
        joints.revolute(Z, [0, L1 + L2, 0]), joints.prismatic(Z),
    ])  # fmt: skip
    close(built, SCARA)
    for theta in THETAS[:, :4]:
        s1, s12, c1, c12 = sc(theta[0], theta[0] + theta[1])
        p = [-L1 * s1 - L2 * s12, L1 * c1 + L2 * c12, L0 + theta[3]]
        close(poe.fk(SCARA, SCARA_HOME, theta), pose(rot_z(theta[:3].sum()), p))


def test_mls_example_3_8_scara_jacobian():
    """MLS §3.4.1, example 3.8: the spatial Jacobian of the SCARA manipulator."""
    for theta in THETAS[:, :4]:
        s1, s12, c1, c12 = sc(theta[0], theta[0] + theta[1])
        expected = np.zeros((6, 4))
        expected[0, 1:3] = L1 * c1, L1 * c1 + L2 * c12
        expected[1, 1:3] = L1 * s1, L1 * s1 + L2 * s12
        expected[2, 3] = 1
        expected[5, :3] = 1
        close(poe.spatial_jacobian(SCARA, theta), expected)


def test_mls_example_3_2_elbow_manipulator():
    """MLS §3.2.2, example 3.2: the twists and g_st(θ) of the elbow manipulator, a 6R arm with a spherical wrist."""
    q1, qw = [0, 0, L0], [0, L1 + L2, L0]
    built = np.hstack([
        joints.revolute(Z, q1), joints.revolute(-X, q1), joints.revolute(-X, [0, L1, L0]),
        joints.revolute(Z, qw), joints.revolute(-X, qw), joints.revolute(Y, qw),
    ])  # fmt: skip
    printed = [
        [0, 0, 0, 0, 0, 1], [0, -L0, 0, -1, 0, 0], [0, -L0, L1, -1, 0, 0],
        [L1 + L2, 0, 0, 0, 0, 1], [0, -L0, L1 + L2, -1, 0, 0], [-L0, 0, 0, 0, 1, 0],
    ]  # fmt: skip
    close(built, np.array(printed).T)
    for theta in THETAS[:, :6]:
        s1, s2, s23, c1, c2, c23 = sc(theta[0], theta[1], theta[1] + theta[2])
        s4, s5, s6, c4, c5, c6 = sc(*theta[3:])
        R = [
            [
                c6 * (c1 * c4 - s1 * c23 * s4) + s6 * (s1 * s23 * c5 + s1 * c23 * c4 * s5 + c1 * s4 * s5),
                -c5 * (s1 * c23 * c4 + c1 * s4) + s1 * s23 * s5,
                c6 * (-c5 * s1 * s23 - (c23 * c4 * s1 + c1 * s4) * s5) + (c1 * c4 - c23 * s1 * s4) * s6,
            ],
            [
                c6 * (c4 * s1 + c1 * c23 * s4) - (c1 * c5 * s23 + (c1 * c23 * c4 - s1 * s4) * s5) * s6,
                c5 * (c1 * c23 * c4 - s1 * s4) - c1 * s23 * s5,
                c6 * (c1 * c5 * s23 + (c1 * c23 * c4 - s1 * s4) * s5) + (c4 * s1 + c1 * c23 * s4) * s6,
            ],
            [
                -c6 * s23 * s4 - (c23 * c5 - c4 * s23 * s5) * s6,
                -c4 * c5 * s23 - c23 * s5,
                c6 * (c23 * c5 - c4 * s23 * s5) - s23 * s4 * s6,
            ],
        ]
        p = [-s1 * (L1 * c2 + L2 * c23), c1 * (L1 * c2 + L2 * c23), L0 - L1 * s2 - L2 * s23]
        close(poe.fk(built, pose(np.eye(3), qw), theta), pose(R, p))


def stanford():
    """MLS §3.4.1, example 3.9 (Stanford arm) and L&P §5.1.1, example 5.3 (RRPRRR): the same arm."""
    q1, qw = [0, 0, L0], [0, L1, L0]
    S = np.hstack([
        joints.revolute(Z, q1), joints.revolute(-X, q1), joints.prismatic(Y),
        joints.revolute(Z, qw), joints.revolute(-X, qw), joints.revolute(Y, qw),
    ])  # fmt: skip
    return S, pose(np.eye(3), qw)


def test_mls_example_3_9_stanford_arm():
    """Its spatial Jacobian, column i (−ω' × q', ω') for the axis where it stands; its wrist's position."""
    S, home = stanford()
    for theta in THETAS[:, :6]:
        s1, s2, s4, s5, c1, c2, c4, c5 = sc(theta[0], theta[1], theta[3], theta[4])
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
        close(poe.fk(S, home, theta)[:3, 3], qw)


def test_mls_joint_torques_balance_a_wrench():
    """MLS §3.4.2: τ = (J^b)ᵀ F_t = (J^s)ᵀ F_s, F_s = Ad(g_st⁻¹)ᵀ F_t; the SCARA's slide carries a weight."""
    theta = THETAS[0, :4]
    g = poe.fk(SCARA, SCARA_HOME, theta)
    weight = np.array([0, 0, -9.81, 0, 0, 0])
    torques = poe.body_jacobian(SCARA, SCARA_HOME, theta).T @ weight
    close(torques, [0, 0, 0, -9.81])
    close(poe.spatial_jacobian(SCARA, theta).T @ screws.transform_wrench(g, weight), torques)


# L&P, chapter 3 ---------------------------------------------------------------------------------------


def test_lynch_park_rotation_by_30_degrees():
    """L&P §3.2.3.3, example 3.12: 30° about (0, 0.866, 0.5)."""
    R = [[0.866, -0.250, 0.433], [0.250, 0.967, 0.058], [-0.433, 0.058, 0.899]]
    close(rotations.from_axis_angle([0, 0.866, 0.5], np.radians(30)), R, PRINTED_3)
    axis, angle = rotations.to_axis_angle(rotations.from_axis_angle([0, 0.866, 0.5], np.radians(30)))
    close(axis, [0, 0.866, 0.5], PRINTED_3)
    close(angle, 0.524, PRINTED_3)


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


# L&P, chapters 4 and 5 --------------------------------------------------------------------------------


def test_lynch_park_example_4_1_3r_spatial():
    """L&P §4.1.2, example 4.1: the 3R spatial open chain."""
    S = lynch_park([0, 0, 1, 0, 0, 0], [0, -1, 0, 0, 0, -L1], [1, 0, 0, 0, -L2, 0])
    M = np.array([[0, 0, 1, L1], [0, 1, 0, 0], [-1, 0, 0, -L2], [0, 0, 0, 1.0]])
    for theta in THETAS[:, :3]:
        s2, c2 = sc(theta[1])
        R = rot_z(theta[0]) @ rot_y(-theta[1]) @ rot_x(theta[2]) @ M[:3, :3]
        close(poe.fk(S, M, theta), pose(R, rot_z(theta[0]) @ [L1 + L2 * s2, 0, -L2 * c2]))


def test_lynch_park_example_4_2_3r_planar():
    """L&P §4.1.2, example 4.2: the 3R planar open chain, its pose as sums over the links."""
    L3 = 0.2
    S = lynch_park([0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -L1, 0], [0, 0, 1, 0, -(L1 + L2), 0])
    for theta in THETAS[:, :3]:
        sums = np.cumsum(theta)
        p = [np.cos(sums) @ [L1, L2, L3], np.sin(sums) @ [L1, L2, L3], 0]
        close(poe.fk(S, pose(np.eye(3), [L1 + L2 + L3, 0, 0]), theta), pose(rot_z(sums[-1]), p))


def test_lynch_park_examples_4_3_and_4_6_6r_in_both_forms():
    """L&P §4.1.2 and §4.1.3, examples 4.3 and 4.6: the screws of the 6R chain in {s} and in {b}."""
    L = 0.8
    S = lynch_park(
        [0, 0, 1, 0, 0, 0], [0, 1, 0, 0, 0, 0], [-1, 0, 0, 0, 0, 0],
        [-1, 0, 0, 0, 0, L], [-1, 0, 0, 0, 0, 2 * L], [0, 1, 0, 0, 0, 0],
    )  # fmt: skip
    B = lynch_park(
        [0, 0, 1, -3 * L, 0, 0], [0, 1, 0, 0, 0, 0], [-1, 0, 0, 0, 0, -3 * L],
        [-1, 0, 0, 0, 0, -2 * L], [-1, 0, 0, 0, 0, -L], [0, 1, 0, 0, 0, 0],
    )  # fmt: skip
    M = pose(np.eye(3), [0, 3 * L, 0])
    close(poe.body_screws(S, M), B)
    close(poe.fk(S, M, THETAS[:, :6]), poe.fk_body(B, M, THETAS[:, :6]))


def test_lynch_park_example_4_4_rrprrr():
    """L&P §4.1.2, example 4.4: the RRPRRR chain: shoulder, slide along the arm, wrist, hand."""
    S = lynch_park(
        [0, 0, 1, 0, 0, 0], [1, 0, 0, 0, 0, 0], [0, 0, 0, 0, 1, 0],
        [0, 1, 0, 0, 0, 0], [1, 0, 0, 0, 0, -L1], [0, 1, 0, 0, 0, 0],
    )  # fmt: skip
    for theta in THETAS[:, :6]:
        tip = rot_z(theta[0]) @ rot_x(theta[1]) @ (
            [0, L1 + theta[2], 0] + L2 * rot_y(theta[3]) @ rot_x(theta[4]) @ Y
        )  # fmt: skip
        R = rot_z(theta[0]) @ rot_x(theta[1]) @ rot_y(theta[3]) @ rot_x(theta[4]) @ rot_y(theta[5])
        close(poe.fk(S, pose(np.eye(3), [0, L1 + L2, 0]), theta), pose(R, tip))


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


def test_lynch_park_example_4_7_wam_in_body_form():
    """L&P §4.1.3, example 4.7: the 7R WAM arm at θ₂ = 45°, θ₄ = −45°, θ₆ = −90°, the printed matrix."""
    A1, A2, A3, W1 = 0.55, 0.3, 0.06, 0.045
    turn = [0, 0, 1, 0, 0, 0]
    B = lynch_park(
        turn, [0, 1, 0, A1 + A2 + A3, 0, 0], turn, [0, 1, 0, A2 + A3, 0, W1], turn, [0, 1, 0, A3, 0, 0], turn,
    )  # fmt: skip
    g = poe.fk_body(B, pose(np.eye(3), [0, 0, A1 + A2 + A3]), np.radians([0, 45, 0, -45, 0, -90, 0]))
    close(g, [[0, 0, -1, 0.3157], [0, 1, 0, 0], [1, 0, 0, 0.6571], [0, 0, 0, 1]], 6e-5)


def test_lynch_park_example_5_2_rrrp_jacobian():
    """L&P §5.1.1, example 5.2: the space Jacobian of the spatial RRRP chain."""
    S = lynch_park([0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -L1, 0], [0, 0, 1, 0, -(L1 + L2), 0], [0, 0, 0, 0, 0, 1])
    for theta in THETAS[:, :4]:
        s1, s12, c1, c12 = sc(theta[0], theta[0] + theta[1])
        expected = lynch_park(
            [0, 0, 1, 0, 0, 0],
            [0, 0, 1, L1 * s1, -L1 * c1, 0],
            [0, 0, 1, L1 * s1 + L2 * s12, -L1 * c1 - L2 * c12, 0],
            [0, 0, 0, 0, 0, 1],
        )
        close(poe.spatial_jacobian(S, theta), expected)


# what the guide has to get right ------------------------------------------------------------------------


def test_guide_the_inverse_of_a_quaternion_divides_by_the_square_of_its_length():
    """‖Q‖² = Q·Q*: for Q = (1, 2, 3, 4) it is 30, and dividing by 30² instead leaves Q Q⁻¹ = 1/30."""
    Q = np.array([1.0, 2, 3, 4])
    conjugate = Q * [1, -1, -1, -1]
    close(rotations.quaternion_product_wxyz(Q, conjugate), [30, 0, 0, 0])
    close(rotations.quaternion_product_wxyz(Q, rotations.quaternion_inverse_wxyz(Q)), [1, 0, 0, 0])
    close(rotations.quaternion_product_wxyz(Q, conjugate / 30**2), [1 / 30, 0, 0, 0])


def test_guide_quaternions_cover_the_rotations_twice():
    """Q and −Q, and every multiple, turn a point p ↦ Q p Q⁻¹ alike."""
    Q, p = np.array([1.0, 2, 3, 4]), np.array([0.3, -0.2, 0.9])
    R = rotations.from_quaternion_wxyz(Q)
    for multiple in (-1.0, 2.0, -0.01):
        close(rotations.from_quaternion_wxyz(multiple * Q), R)
    times, inverse = rotations.quaternion_product_wxyz, rotations.quaternion_inverse_wxyz
    close(times(times(Q, [0, *p]), inverse(Q)), [0, *(R @ p)])


def test_guide_rodrigues_needs_a_unit_vector():
    """For any w: I + ŵ/‖w‖ sin ‖w‖θ + ŵ²/‖w‖² (1 − cos ‖w‖θ); the unit-vector form is no rotation for ‖w‖ = 7."""
    w, theta = np.array([2.0, -3, 6]), 0.4
    W = screws.hat(w)
    close(rotations.exp(w, theta), np.eye(3) + W / 7 * np.sin(7 * theta) + W @ W / 49 * (1 - np.cos(7 * theta)))
    unit_form = np.eye(3) + W * np.sin(theta) + W @ W * (1 - np.cos(theta))
    assert np.abs(unit_form.T @ unit_form - np.eye(3)).max() > 1


def test_guide_at_beta_zero_zyz_knows_only_alpha_plus_gamma():
    """At β = 0 the angles (0.5, 0, 0.2) and (0.7, 0, 0) are one rotation; at β = π it is α − γ that counts."""
    close(rotations.from_euler("ZYZ", [0.5, 0, 0.2]), rotations.from_euler("ZYZ", [0.7, 0, 0]))
    close(rotations.to_euler("ZYZ", rotations.from_euler("ZYZ", [0.5, 0, 0.2])), [0.7, 0, 0])
    close(rotations.to_euler("ZYZ", rotations.from_euler("ZYZ", [0.5, np.pi, 0.2])), [0.3, np.pi, 0])
    assert np.linalg.cond(rotations.euler_rate_map("ZYZ", [0.5, 0, 0.2])) > 1e15


@pytest.mark.parametrize("pitch", [0.0, 0.3])
def test_guide_a_turning_joint_moves_points_by_w_cross_p_minus_q(pitch):
    """ṗ = ω × (p − q) is pure rotation; a screw adds hω, so ξ = (−ω × q + hω, ω)."""
    w, q, p = np.array([2.0, -3, 6]) / 7, np.array([0.3, 1.0, -0.4]), np.array([1.0, 0.2, 0.8, 1.0])
    xi = joints.helical(w, q, pitch)[:, 0]
    close(xi, [*(-np.cross(w, q) + pitch * w), *w])
    close((screws.hat(xi) @ p)[:3], np.cross(w, p[:3] - q) + pitch * w)


def test_guide_the_joint_twist_is_spatial_and_e_moves_the_frame_from_the_left():
    """g(θ) = e^{ξ̂θ} g(0) has ġ g⁻¹ = ξ̂ for every θ, while g⁻¹ ġ is another twist, Ad(g⁻¹) ξ."""
    xi, start = np.array([0.3, -0.2, 0.5, 0.6, 0, 0.8]), pose(rot_x(0.4), [1.0, 2, 3])
    for theta in (0.0, 0.9):
        g = screws.exp(xi, theta) @ start
        g_dot = derivative(lambda t: screws.exp(xi, t) @ start, theta)
        close(screws.vee(g_dot @ screws.inverse(g)), xi, 100 * DERIVATIVE)
        close(screws.vee(screws.inverse(g) @ g_dot), screws.adjoint(screws.inverse(g)) @ xi, 100 * DERIVATIVE)


def test_guide_poses_compose_by_adjacent_letters():
    """g_ac = g_ab g_bc, from g_ab and g_bc; R_ba = R_abᵀ."""
    g_ab, g_bc = pose(rot_x(0.4), [1, 2, 3]), pose(rot_z(-1.0), [0, 1, 0])
    p_c = np.array([0.1, 0.2, 0.3, 1])
    close(g_ab @ (g_bc @ p_c), (g_ab @ g_bc) @ p_c)
    close(screws.inverse(g_ab)[:3, :3], g_ab[:3, :3].T)
    close(screws.inverse(g_ab @ g_bc), screws.inverse(g_bc) @ screws.inverse(g_ab))


def test_guide_the_space_form_needs_no_adjoint_but_the_jacobian_does():
    """Π e^{ξ̂ᵢθᵢ} g(0) takes the twists at rest; the Jacobian's columns are those twists carried along."""
    S, home = stanford()
    theta = THETAS[3, :6]
    g = home
    for xi, value in reversed(list(zip(S.T, theta, strict=True))):
        g = screws.exp(xi, value) @ g
    close(poe.fk(S, home, theta), g)
    J = poe.spatial_jacobian(S, theta)
    close(J[:, 0], S[:, 0])
    carried = np.eye(4)
    for i in range(5):
        carried = carried @ screws.exp(S[:, i], theta[i])
        close(J[:, i + 1], screws.adjoint(carried) @ S[:, i + 1])
