"""Worked examples of MLS.

MLS: Murray, Li & Sastry, A Mathematical Introduction to Robotic Manipulation, 1994.
"""

from __future__ import annotations

import numpy as np
import pytest

from strategies import derivative
from textbook import DERIVATIVE, L0, L1, L2, THETAS, Z, close, pose, rot_z, sc, stanford
from twistarm import joints, poe, rotations, screws

# MLS, chapter 2 ---------------------------------------------------------------------------------------


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


def test_mls_joint_torques_balance_a_wrench():
    """MLS §3.4.2: τ = (J^b)ᵀ F_t = (J^s)ᵀ F_s, F_s = Ad(g_st⁻¹)ᵀ F_t; the SCARA's slide carries a weight."""
    theta = THETAS[0, :4]
    g = poe.fk(SCARA, SCARA_HOME, theta)
    weight = np.array([0, 0, -9.81, 0, 0, 0])
    torques = poe.body_jacobian(SCARA, SCARA_HOME, theta).T @ weight
    close(torques, [0, 0, 0, -9.81])
    close(poe.spatial_jacobian(SCARA, theta).T @ screws.transform_wrench(g, weight), torques)
