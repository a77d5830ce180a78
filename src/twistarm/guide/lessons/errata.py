# %% [markdown]
# # Errata of the guide
#
# The team's guide is a manual on manipulation. This page lists its errors for its readers, each with a number that
# shows the error. The numbers were computed when this page was built.

# %%
from math import factorial

import numpy as np

from twistarm import guide, joints, rotations, screws


def gap(A, B):
    """The largest difference of two entries."""
    return np.abs(A - B).max()


def numbers(values):
    return ", ".join(f"{value + 0.0:.2f}" for value in np.round(values, 2))  # never -0.00


# %% [markdown]
# ## 1. Sine and cosine without an argument (2.1.1)
#
# The guide writes $\sin$ and $\cos$ without an angle in the elementary rotations, and $R_v(\beta)$ for $R_y(\beta)$.
# Each needs its angle. Programs take radians.

# %%
q = np.array([1.0, 0.0, 0.0])  # 1 m from the axis
wrong, right = (rotations.exp([0, 0, 1], angle) @ q for angle in (1.0, np.radians(1.0)))
guide.say(
    f"Turned by 1 rad instead of 1°, a point at 1 m from the axis is {np.linalg.norm(wrong - right):.3f} m off."
)

# %% [markdown]
# ## 2. From which frame to which, and about which axes (2.1.1)
#
# The rotation "from B to B" takes A to B. The ZYZ angles have the order α, β, γ. Each Euler angle turns about an axis
# that the turns before it have moved. So each new factor is on the right.

# %%
a, b = np.radians([40.0, 30.0])
moved = rotations.exp([0, 0, 1], a) @ rotations.exp([0, 1, 0], b)
fixed = rotations.exp([0, 1, 0], b) @ rotations.exp([0, 0, 1], a)
guide.say(
    f"$R_z(40°)R_y(30°)$ and $R_y(30°)R_z(40°)$ differ by {np.degrees(rotations.angle_between(moved, fixed)):.1f}°."
)

# %% [markdown]
# ## 3. The norm of a quaternion (2.1.1)
#
# $Q \cdot Q^*$ is the square of the norm, $\|Q\|^2$, and not the norm. With the guide's definition, $Q^{-1} =
# Q^*/\|Q\|^2$ divides by the fourth power of the length. With unit quaternions the mistake does not show.

# %%
Q = np.array([1.0, 2.0, 3.0, 4.0])
conjugate = Q * [1, -1, -1, -1]
square = rotations.quaternion_product_wxyz(Q, conjugate)[0]
literal = rotations.quaternion_product_wxyz(Q, conjugate / square**2)[0]
right = rotations.quaternion_product_wxyz(Q, conjugate / square)[0]
guide.say(
    f"For $Q = (1, 2, 3, 4)$: $Q \\cdot Q^* = {square:.0f}$. Read literally, $Q \\cdot Q^{{-1}} = {literal:.4f}$, "
    f"which is $1/{1 / literal:.0f}$; with $\\|Q\\| = \\sqrt{{{square:.0f}}}$ it is {right:.0f}."
)

# %% [markdown]
# ## 4. Quaternions are no global parametrisation (2.1.1)
#
# The quaternions are $\mathbb{H}$; $\mathbb{Q}$ are the fractions. Unit quaternions cover the rotations twice: $Q$ and
# $-Q$ are the same rotation.

# %%
Q = rotations.to_quaternion_wxyz(rotations.exp([1, 2, 3], 0.4))
same = gap(rotations.from_quaternion_wxyz(Q), rotations.from_quaternion_wxyz(-Q))
guide.say(
    f"The matrices of $Q$ and of $-Q$ differ by {same:.0f}; as points of the sphere the two are "
    f"{np.linalg.norm(Q - -Q):.0f} apart, the greatest distance."
)

# %% [markdown]
# ## 5. Which matrices are rotations (2.1.2)
#
# A rotation has $R^TR = I$, the unit matrix and not the number 1, and $\det R = +1$. $SO(n)$ does not contain all $n
# \times n$ matrices, and the vectors of $\mathbb{R}^3$ are not its elements: $A, B \in SO(3) \subset \mathbb{R}^{3
# \times 3}$.

# %%
mirror = np.diag([1.0, 1.0, -1.0])
off = gap(mirror.T @ mirror, np.eye(3))
double = 2 * np.eye(3)
guide.say(
    f"The mirror $\\mathrm{{diag}}(1, 1, -1)$ has $M^TM = I$ (off by {off:.0f}) and determinant "
    f"−{-np.linalg.det(mirror):.0f}: it makes a right hand a left one. $2I$ is a $3 \\times 3$ matrix of "
    f"determinant {np.linalg.det(double):.0f}."
)

# %% [markdown]
# ## 6. The series of the exponential (2.1.2)
#
# The body turns at unit rate for $\theta$ units of time, not for $\omega$ units. The series has the terms $\theta^4/4!$
# and $\theta^6/6!$, not $\omega^4/4!$ and $\omega^6/6!$: $\omega$ is a vector.

# %%
w, theta = np.array([0.6, 0.0, 0.8]), 1.2
W = rotations.skew(w)
cosine = {power: (-1) ** (power // 2) * theta**power / factorial(power) for power in (2, 4, 6, 8)}
# What the guide writes: powers of ω, which has norm one, where powers of the angle belong.
slipped = cosine | {power: (-1) ** (power // 2) / factorial(power) for power in (4, 6)}
sine = sum((-1) ** (power // 2) * theta**power / factorial(power) for power in (1, 3, 5, 7, 9))
exact = rotations.exp(w, theta)
right, wrong = (np.eye(3) + W * sine - W @ W * sum(terms.values()) for terms in (cosine, slipped))
guide.say(
    f"At $\\theta = {theta}$ no entry of the series is more than ${guide.rough(gap(right, exact))}$ from the "
    f"rotation's; "
    f"with $\\|\\omega\\| = 1$ in place of $\\theta$ in those two terms one is {gap(wrong, exact):.3f} from it."
)

# %% [markdown]
# ## 7. Rodrigues' formula needs a unit axis (2.1.2)
#
# The formula is named after Rodrigues. $e^{\hat\omega\theta} = I + \hat\omega \sin\theta + \hat\omega^2 (1 -
# \cos\theta)$ holds for $\|\omega\| = 1$. Otherwise: $I + \frac{\hat\omega}{\|\omega\|} \sin(\|\omega\|\theta) +
# \frac{\hat\omega^2}{\|\omega\|^2} (1 - \cos(\|\omega\|\theta))$.

# %%
w, theta = np.array([0.0, 0.0, 2.0]), np.radians(30.0)
W = rotations.skew(w)
careless = np.eye(3) + W * np.sin(theta) + W @ W * (1 - np.cos(theta))
size = np.linalg.norm(w)
careful = np.eye(3) + W / size * np.sin(size * theta) + W @ W / size**2 * (1 - np.cos(size * theta))
guide.say(
    "For $\\omega = (0, 0, 2)$ and 30° the short formula gives a matrix of determinant "
    f"{np.linalg.det(careless):.3f}, no rotation; the long one is within "
    f"${guide.rough(max(gap(careful, rotations.exp(w, theta)), 1e-16))}$ of the exponential."
)

# %% [markdown]
# ## 8. What is given, and what is sought (2.2.1)
#
# The guide says twice that $g_{ac}$ is given. It means $g_{ab}$ and $g_{bc}$: $g_{ac} = g_{ab}\, g_{bc}$. Indices that
# meet in the middle cancel. In the other order they do not.

# %%
ab, bc = screws.exp([1, 0, 0, 0, 0, 0.5]), screws.exp([0, 1, 0, 0.7, 0, 0])
off = np.linalg.norm((ab @ bc - bc @ ab)[:3, 3])
guide.say(
    f"With two poses, turned by 0.5 and by 0.7 rad, $g_{{ab}}\\,g_{{bc}}$ and $g_{{bc}}\\,g_{{ab}}$ put the "
    f"origin {off:.3f} m apart."
)

# %% [markdown]
# ## 9. Chasles, and what a twist is (2.2.2)
#
# Chasles' theorem says that every rigid motion is a screw motion. A twist is not the time derivative of a screw motion.
# It is the infinitesimal screw motion: the motion at its first instant.

# %%
xi = joints.helical([0, 0, 1], [0.3, 0, 0], 0.1)[:, 0]
h = 1e-6
rate = (screws.exp(xi, h) - screws.exp(xi, -h)) / (2 * h)
off = gap(rate, screws.hat(xi))
guide.say(
    f"At $t = 0$ the derivative of $e^{{\\hat\\xi t}}$ is $\\hat\\xi$ (by differences no entry is more than "
    f"${guide.rough(off)}$ off); at $t = 1$ it is another matrix, whose entries differ by up to "
    f"{gap(screws.hat(xi) @ screws.exp(xi, 1.0), screws.hat(xi)):.2f}."
)

# %% [markdown]
# ## 10. A joint that turns and slides (2.2.2)
#
# The guide gives $\dot p = \omega \times (p - q)$ for a joint that translates and rotates. This is the velocity of pure
# rotation. A screw adds $h\omega$, and a slide has $\dot p = v$. So a screw has $v = -\omega \times q + h\omega$.

# %%
w, q, p, pitch = np.array([0, 0, 1.0]), np.array([0.3, 0, 0]), np.array([0.5, 0.2, 0]), 0.1
turning = np.cross(w, p - q)
xi = np.append(-np.cross(w, q) + pitch * w, w)
along = (screws.hat(xi) @ np.append(p, 1))[:3]
guide.say(
    f"A point on a screw of pitch {pitch} m/rad moves along the axis at {along @ w:.2f} m/s for each rad/s; the "
    f"guide's formula says {turning @ w:.0f}."
)

# %% [markdown]
# ## 11. Spatial, not body (2.2.2)
#
# The twist of $\dot g g^{-1} = \hat\xi$ is seen from the fixed frame: it is the spatial velocity. The body velocity is
# $g^{-1}\dot g$.

# %%
xi = joints.revolute([0, 0, 1], [0.4, 0, 0])[:, 0]
home = screws.exp([0.9, 0, 0, 0, 0.3, 0])
body = screws.adjoint(screws.inverse(home)) @ xi
guide.say(
    f"For a joint 0.4 m from the origin: spatial $v = ({numbers(xi[:3])})$, body $v = ({numbers(body[:3])})$ "
    f"m/s. They are {np.linalg.norm((xi - body)[:3]):.2f} m/s apart."
)

# %% [markdown]
# ## 12. The pose at the beginning (2.2.2)
#
# $e^{\hat\xi\theta}$ moves the initial pose: $g(\theta) = e^{\hat\xi\theta} g(0)$. Without $g(0)$ the answer is wrong
# by the distance of the tool from the origin at zero.

# %%
xi = joints.revolute([0, 0, 1], [0, 0, 0])[:, 0]
home = screws.exp([0.8, 0, 0, 0, 0, 0])
with_home, without = screws.exp(xi, 0.5) @ home, screws.exp(xi, 0.5)
guide.say(
    f"A tool 0.8 m out, the joint at 0.5 rad: without $g(0)$ the answer is "
    f"{np.linalg.norm((with_home - without)[:3, 3]):.2f} m off."
)

# %% [markdown]
# ## 13. Points with a one below them (2.2.2)
#
# $e^{\hat\xi\theta}$ is $4 \times 4$ and moves points $\bar p = (p, 1)$ within one frame: $\dot{\bar p} = \hat\xi \bar
# p$. With a zero below, it moves a direction, and the translation drops out.

# %%
g = screws.exp([0.5, 0.2, 0, 0, 0, 1.0])
p = np.array([1.0, 0, 0])
point, vector = (g @ [*p, 1])[:3], (g @ [*p, 0])[:3]
guide.say(
    f"The same three numbers as a point and as a direction end {np.linalg.norm(point - vector):.3f} m apart."
)

# %% [markdown]
# ## 14. The product of exponentials needs no Adjoint (3.1)
#
# The space form needs only the twists at home, seen from the space frame: $g = e^{\hat\xi_1\theta_1} \cdots
# e^{\hat\xi_n\theta_n} g(0)$. The body form and the Jacobians need Adjoints.

# %%
S = np.hstack([joints.revolute([0, 0, 1], [0, 0, 0]), joints.revolute([0, 0, 1], [0.4, 0, 0])])
home = screws.exp([0.7, 0, 0, 0, 0, 0])
theta = np.array([0.5, 0.8])
g = screws.exp(S[:, 0], theta[0]) @ screws.exp(S[:, 1], theta[1]) @ home
x = 0.4 * np.cos(theta[0]) + 0.3 * np.cos(theta.sum())
guide.say(
    f"The two-link arm by this formula alone: $x = {g[0, 3]:.4f}$ m; by trigonometry: $x = {x:.4f}$ m."
)

# %% [markdown]
# ## 15. The signs of the two-link arm go together (3.2)
#
# $\theta_2 = \pi \pm \alpha$ and $\theta_1 = \mathrm{atan2}(y, x) \pm \beta$ are two solutions, not four: both with
# plus, or both with minus.


# %%
def elbow(l1, l2, p, a, b):
    """The guide's formula with the sign `a` on α and `b` on β."""
    r = np.hypot(*p)
    alpha = np.arccos(np.clip((l1**2 + l2**2 - r**2) / (2 * l1 * l2), -1, 1))
    beta = np.arccos(np.clip((r**2 + l1**2 - l2**2) / (2 * l1 * r), -1, 1))
    return np.array([np.arctan2(p[1], p[0]) + b * beta, np.pi + a * alpha])


def tip(l1, l2, first, second):
    return np.array(
        [
            l1 * np.cos(first) + l2 * np.cos(first + second),
            l1 * np.sin(first) + l2 * np.sin(first + second),
        ]
    )


l1, l2, target = 0.4, 0.3, np.array([0.35, 0.3])
missed = {
    (a, b): np.linalg.norm(tip(l1, l2, *elbow(l1, l2, target, a, b)) - target)
    for a in (1, -1)
    for b in (1, -1)
}
guide.say(
    f"With equal signs the tool is ${guide.rough(max(missed[1, 1], missed[-1, -1]))}$ m from the target, with "
    f"mixed ones {missed[1, -1]:.3f} m; the greatest error, $2l_2$, is {2 * l2:.1f} m."
)

# %% [markdown]
# ## 16. How many solutions, and where (3.2)
#
# There are two solutions if $|l_1 - l_2| < r < l_1 + l_2$, one at either edge, where $\alpha$ is $0$ or $\pi$, and none
# outside. At $r = 0$ with equal links $\theta_1$ is free. At an edge rounding may move the cosine outside $[-1, 1]$:
# clamp it. Wrap $\pi + \alpha$ into $(-\pi, \pi]$.

# %%
l1, l2 = 0.4, 0.3
stretched = [elbow(l1, l2, np.array([l1 + l2, 0.0]), sign, sign) for sign in (1, -1)]
difference = np.abs(np.angle(np.exp(1j * (stretched[0] - stretched[1])))).max()
cosine = (l1**2 + l2**2 - (l1 + l2 + 1e-9) ** 2) / (2 * l1 * l2)
guide.say(
    f"Stretched out, no angle of the two solutions differs by more than ${guide.rough(difference)}$ rad. "
    f"A nanometre further the cosine is $-1 - {guide.rough(-1 - cosine)}$, whose arc cosine is not a number."
)
