"""Worked examples of the two textbooks (`textbook` has their notation); L&P's twists are (w, v)."""

from __future__ import annotations

import numpy as np

from strategies import close
from textbook import L0, L1, L2, PRINTED_3, THETAS, Z, lynch_park, pose, rot_z, sc, stanford
from twistarm import joints, poe, rotations, screws

# MLS, chapter 3 ---------------------------------------------------------------------------------------

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
