"""What the guide has to get right about rotations, screws and chains."""

from __future__ import annotations

import numpy as np
import pytest

from strategies import derivative
from textbook import DERIVATIVE, THETAS, close, pose, rot_x, stanford
from twistarm import joints, poe, rotations, screws


def test_guide_quaternions_cover_the_rotations_twice():
    """Q and −Q, and every multiple, turn a point p ↦ Q p Q⁻¹ alike."""
    Q, p = np.array([1.0, 2, 3, 4]), np.array([0.3, -0.2, 0.9])
    R = rotations.from_quaternion_wxyz(Q)
    for multiple in (-1.0, 2.0, -0.01):
        close(rotations.from_quaternion_wxyz(multiple * Q), R)
    times, inverse = rotations.quaternion_product_wxyz, rotations.quaternion_inverse_wxyz
    close(times(times(Q, [0, *p]), inverse(Q)), [0, *(R @ p)])


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
