"""What the guide has to get right about rotations, screws and chains."""

from __future__ import annotations

import numpy as np
import pytest

from strategies import derivative
from textbook import DERIVATIVE, THETAS, close, pose, rot_x, rot_z, stanford
from twistarm import joints, poe, rotations, screws


def test_guide_the_inverse_of_a_quaternion_divides_by_its_square():
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


def test_guide_the_joint_twist_is_spatial():
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
