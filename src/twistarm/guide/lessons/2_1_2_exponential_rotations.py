# %% [markdown]
# # Rotations as exponentials
#
# The motor of a joint turns about its own shaft, by some angle. The shaft seldom points along x, y or z of your base.
# Which rotation matrix belongs to the shaft and the angle? And the reverse: the tool shall go from one orientation to
# another. About which axis do you turn it, and how far?
#
# The exponential of a matrix answers the first question, and its inverse, the logarithm, the second. The rest of this
# course builds on them.
#
# S is the frame of the base and T that of the tool. The picture shows both with one origin, so that you see the turn
# alone. The columns of $R_{st}$ are the axes of T, seen from S.

# %%
from math import factorial

import numpy as np
from scipy.linalg import expm

from twistarm import guide, rotations

arm = guide.arm()
theta = 0.6 * arm.ready + 0.4 * arm.random_theta(3)  # between ready and a random configuration
R = arm.fk(theta)[:3, :3]
guide.say(rf"The tool of `{arm.name}` in a random configuration: $$R_{{st}} = {guide.tex(R)}$$")


# %%
def towards_the_eye(azim, elev=22.0):
    """How nearly an axis of S or T points at the eye, from 0 to 1."""
    a, e = np.radians([azim, elev])
    eye = [np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)]
    return np.abs(np.vstack([np.eye(3), R.T]) @ eye).max()


fig, ax = guide.axes3(box=False, azim=min(range(-55, 305, 10), key=towards_the_eye))
guide.plot_frame(ax, np.eye(3), "S", alpha=0.5)
guide.plot_frame(ax, R, "T")
guide.figure(
    fig,
    "Two frames with one origin. S, faint, has the axes of the base. T has the axes of the tool; the tip of each is a "
    "column of the rotation matrix.",
    "Frame S is the base, frame T the tool. The coordinates of the tip of $x_T$, seen from S, are the first column.",
)

# %% [markdown]
# ## A group
#
# Two turns, one after the other, are again a turn. A set with such an operation is a *group* if four laws hold. For
# $R_1, R_2, R_3 \in SO(3)$, the rotation matrices of lesson 2.1.1:
#
# - closure: $R_1 R_2$ is in $SO(3)$ too;
# - identity: $I R_1 = R_1 I = R_1$;
# - inverse: $R_1^T R_1 = R_1 R_1^T = I$, so that the transpose undoes the turn;
# - associativity: $(R_1 R_2) R_3 = R_1 (R_2 R_3)$, as for all matrices.
#
# Source: Murray, Li and Sastry, *A Mathematical Introduction to Robotic Manipulation* (MLS), section 2.2.1. Two things
# are not in the list. The sum $R_1 + R_2$ is not a rotation. And $R_1 R_2 = R_2 R_1$ does not hold in general.

# %%
X, Y, Z = (rotations.exp(unit, np.pi / 2) for unit in np.eye(3))  # quarter turns
halved = np.linalg.det((Z + np.eye(3)) / 2)
quarters, halves = (
    np.degrees(rotations.angle_between(R1 @ R2, R2 @ R1)) for R1, R2 in ((X, Y), (X @ X, Y @ Y))
)
guide.predict(
    "Is the mean of $I$ and a quarter turn about $z$ an eighth of a turn? And when does the order of two turns not "
    "matter: for turns about one axis, quarter turns about $x$ and $y$, half turns about $x$ and $y$?",
    f"The mean is no rotation: its determinant is {halved:.2f}, so it shrinks things. Rotations are "
    f"multiplied. You can add and halve their logarithms, which come at the end of this lesson. Turns about "
    f"one axis commute, because their angles add up."
    f" The two quarter turns come out {quarters:.0f}° apart, the two half turns {halves:.0f}°: half "
    "turns about axes at right angles are the only other pair that commutes.",
)

# %% [markdown]
# ## A point goes round
#
# Fix a unit vector $\omega$, the shaft, and let a body turn about it at one radian per second. Measure a point $p$ of
# the body from a point of the shaft. It moves at right angles to the shaft and to $p$:
#
# $$\dot p(t) = \omega \times p(t) = \hat\omega\, p(t), \qquad
# \hat\omega = \begin{bmatrix} 0 & -\omega_3 & \omega_2 \\ \omega_3 & 0 & -\omega_1 \\
# -\omega_2 & \omega_1 & 0 \end{bmatrix}$$
#
# The hat writes the cross product as a matrix. Such matrices are *skew-symmetric*, $\hat\omega^T = -\hat\omega$. This
# is a linear differential equation: the rate of $p$ is a constant matrix times $p$. For numbers, $\dot x = c\,x$ has
# the solution $x = e^{ct} x(0)$. For vectors it is the same, with the exponential of a matrix:
#
# $$p(t) = e^{\hat\omega t} p(0)$$
#
# The next section defines this exponential as a series. Differentiate it term by term to check the law. After $\theta$
# seconds at one radian per second the body has turned by $\theta$. Therefore
#
# $$R(\omega, \theta) = e^{\hat\omega\theta}$$

# %%
omega = np.array([1.0, 0.5, 2.0]) / np.linalg.norm([1.0, 0.5, 2.0])
p0 = np.array([0.8, -0.3, 0.4])
times = np.linspace(0, 1.5 * np.pi, 100)
orbit = np.array([expm(rotations.skew(omega) * t) @ p0 for t in times])  # SciPy's, of any matrix


# %%
fig, ax = guide.axes3(box=False, height=4.0, elev=35, azim=-45)
ax.plot(*orbit.T, color=guide.GREY, linestyle="-")
guide.plot_vector(ax, [0, 0, 0], 1.1 * omega, r"$\omega$", guide.PINK)


def draw_point(ax, p, name):
    guide.plot_vector(ax, [0, 0, 0], p, "", guide.INK)
    ax.text(*(0.6 * p - [0.1, 0.1, 0.05]), name, color=guide.INK, ha="center", va="center")
    velocity = 0.6 * np.cross(omega, p)
    guide.plot_vector(ax, p, velocity, "", guide.ORANGE)
    words = {"color": guide.ORANGE, "ha": "center", "va": "center"}
    ax.text(*(p + 1.35 * velocity), r"$\omega\times p$", **words)


draw_point(ax, p0, "$p(0)$")
guide.plot_motion(draw_point, ax, orbit[::3], "$p(t)$")
guide.figure(
    fig,
    "A point on a circle around an axis omega, at two instants. An arrow along the circle is its velocity, omega cross "
    "p, at right angles to the axis and to p.",
    r"The point keeps its distance from the shaft. Its velocity is $\omega \times p$ at every instant.",
)

# %% [markdown]
# ## The series becomes Rodrigues' formula
#
# The exponential of a number is a series, $e^x = 1 + x + \frac{x^2}{2!} + \cdots$. For a matrix it is the same series:
#
# $$e^{\hat\omega\theta} = I + \hat\omega\theta + \frac{(\hat\omega\theta)^2}{2!}
# + \frac{(\hat\omega\theta)^3}{3!} + \cdots$$
#
# The powers repeat. The rule for a double cross product says $a \times (a \times x) = a\,(a^T x) - \|a\|^2 x$. As a
# matrix this is
#
# $$\hat a^2 = a a^T - \|a\|^2 I$$
#
# where $a a^T$ is the $3 \times 3$ matrix of the products $a_i a_j$. Multiply by $\hat a$. Because $\hat a a = a \times
# a = 0$, the first term drops out: $\hat a^3 = -\|a\|^2\,\hat a$ (MLS, lemma 2.3). For the unit vector $\omega$ this is
# $\hat\omega^3 = -\hat\omega$. Sort the terms by $\hat\omega$ and $\hat\omega^2$:
#
# $$e^{\hat\omega\theta} = I + \left(\theta - \frac{\theta^3}{3!} + \frac{\theta^5}{5!} - \cdots\right)\hat\omega
# + \left(\frac{\theta^2}{2!} - \frac{\theta^4}{4!} + \frac{\theta^6}{6!} - \cdots\right)\hat\omega^2$$
#
# The brackets are the series of $\sin\theta$ and of $1 - \cos\theta$. This is **Rodrigues' formula**:
#
# $$e^{\hat\omega\theta} = I + \hat\omega\sin\theta + \hat\omega^2(1 - \cos\theta), \qquad \|\omega\| = 1$$
#
# Source: MLS, section 2.2.2, equation (2.14). It always gives a rotation. The transpose of $e^{\hat\omega\theta}$ is
# $e^{-\hat\omega\theta}$, its inverse. The determinant is 1 at $\theta = 0$ and changes continuously, so it cannot
# become $-1$.


# %% tags=["shown"]
def rodrigues(omega, theta):
    """The rotation by theta [rad] about the unit vector omega."""
    W = rotations.skew(omega)
    return np.eye(3) + W * np.sin(theta) + W @ W * (1 - np.cos(theta))


def series(omega, theta, terms):
    """The first terms of the series."""
    W = rotations.skew(omega)
    return sum(np.linalg.matrix_power(W * theta, k) / factorial(k) for k in range(terms))


# %%
counts = np.arange(1, 41)
angles = (0.5, 3.0, 6.0)
errors = {a: [np.abs(series(omega, a, n) - rodrigues(omega, a)).max() for n in counts] for a in angles}
enough = {a: counts[np.argmax(np.array(e) < 5e-10)] for a, e in errors.items()}
guide.predict(
    "How many terms of the series do you need for nine correct decimals, at half a radian and at six radians, nearly "
    "a full turn? And at which angle is the series cheaper than the formula?",
    f"It takes {enough[0.5]} terms at half a radian and {enough[6.0]} at six radians. The series is never "
    f"cheaper. The formula needs one sine, one cosine and the square of one matrix at every angle.",
)

# %%
fig, ax = guide.axes2(xlabel="terms of the series", ylabel="largest error of an entry")
for a in angles:
    ax.semilogy(counts, np.maximum(errors[a], 1e-17), label=f"{a:g} rad")
ax.legend()
guide.figure(
    fig,
    "The error of the series against the number of its terms, on a logarithmic scale. For half a radian it "
    "falls at once. For six radians it first grows, then falls. All three end at the level of rounding.",
    "The larger the angle, the longer the series; for six radians its terms first grow.",
)

# %% [markdown]
# ### The axis must have length one
#
# Rodrigues' formula holds for a **unit** vector. For any other vector, divide by its length first:
#
# $$e^{\hat\omega\theta} = I + \frac{\hat\omega}{\|\omega\|}\sin(\|\omega\|\theta)
# + \frac{\hat\omega^2}{\|\omega\|^2}\,(1 - \cos(\|\omega\|\theta))$$
#
# An axis from a CAD file or a URDF may well have another length.

# %%
long_axis = np.array([0.0, 0.0, 2.0])
careless = rodrigues(long_axis, np.radians(30))
careful = rodrigues(long_axis / 2, 2 * np.radians(30))
guide.predict(
    f"Take $\\omega = (0, 0, {long_axis[2]:.0f})$ and $\\theta = 30°$. What is the determinant of the matrix that the "
    "short formula gives? And by which angle does the matrix of the long one turn?",
    f"The short formula gives a determinant of {np.linalg.det(careless):.3f}, so it is no rotation. The long one turns "
    f"by {np.degrees(rotations.angle_between(np.eye(3), careful)):.0f}°, because such a shaft turns at two radians per "
    "second.",
)

# %% [markdown]
# ## The shafts of your arm
#
# For $\omega$ along $x$, $y$ or $z$, Rodrigues' formula gives $R_x$, $R_y$ and $R_z$ of the first lesson. For a shaft
# of your arm in the ready configuration, it gives the rotation that this joint adds. For the table, each joint moved
# alone. The last column compares $e^{\hat\omega\theta}R$ with the orientation that the tool then had. Here $R$ is that
# at ready.

# %%
turning = guide.arm_with(
    "a joint that turns", lambda a: bool(np.any(np.linalg.norm(a.screws[3:], axis=0) > 0.5))
)
pose = turning.ready
shafts = turning.spatial_jacobian(pose)[3:]  # the axes of the joints, as lesson 3.3.2 shows
rows, before, step = [], turning.fk(pose)[:3, :3], np.radians(40)
for name, shaft, unit in zip(turning.joint_names, shafts.T, np.eye(turning.n), strict=True):
    if not np.isclose(np.linalg.norm(shaft), 1):
        continue  # a slide, or a coordinate that moves several joints
    after = turning.fk(pose + step * unit)[:3, :3]
    off = max(np.abs(rodrigues(shaft, step) @ before - after).max(), np.finfo(float).eps)
    rows.append([f"`{name}`", *shaft, f"${guide.rough(off)}$"])
guide.table(
    ["joint", "$\\omega_x$", "$\\omega_y$", "$\\omega_z$", "off by at most"],
    rows,
    f"Shafts of `{turning.name}`, seen from the base. Each joint was moved by {np.degrees(step):.0f}°.",
)

# %% [markdown]
# The new factor is on the **left**, because the shaft is seen from the base. For a shaft that is seen from the tool, it
# would be on the right.
#
# ## The way back: the logarithm
#
# Every rotation is a turn about one axis: this is **Euler's theorem**. The axis is a direction that the rotation does
# not change, $R\omega = \omega$. It exists if $R - I$ has the determinant 0. And it has:
#
# $$\det(R - I) = \det(R - RR^T) = \det R\,\det(I - R^T) = \det(I - R) = -\det(R - I)$$
#
# A matrix and its transpose have one determinant. The last step changes the sign of three rows, and each changes the
# sign of the determinant. A number that equals its own negative is 0. $R$ keeps lengths and right angles, so it takes
# the plane across the axis to itself. With $\det R = 1$ it is no mirror there, so it is a turn. To find the axis, read
# Rodrigues' formula backwards. The trace, the sum of the diagonal, holds the angle, and the differences of opposite
# entries hold the axis:
#
# $$\theta = \cos^{-1}\frac{\mathrm{tr}\,R - 1}{2}, \qquad
# \omega = \frac{1}{2\sin\theta}\begin{bmatrix} r_{32} - r_{23} \\ r_{13} - r_{31} \\ r_{21} - r_{12} \end{bmatrix}$$
#
# Source: MLS, section 2.2.2. The product $\omega\theta$ is the *logarithm* of $R$; its three numbers are also called
# the exponential coordinates. So one turn takes the tool from one orientation to another, even if many joints moved.

# %%
start, end = arm.fk(arm.ready)[:3, :3], R  # from where the arm waits to the random configuration
change = end @ start.T  # seen from the base: change · start = end
w = rotations.log(change)
turn = np.linalg.norm(w)

halfway = rotations.exp(w / 2) @ start
guide.say(
    f"From the ready configuration to the first picture, `{arm.name}` turns its tool by **{np.degrees(turn):.1f}°** "
    f"about $({', '.join(f'{x:.3f}' for x in (w / turn if turn else w) + 0.0)})$, seen from the base. Half the "
    f"logarithm is half the way: {np.degrees(rotations.angle_between(start, halfway)):.1f}° from the one and "
    f"{np.degrees(rotations.angle_between(halfway, end)):.1f}° from the other."
)

# %%
guide.slider(
    "axis_angle",
    "Set a half turn, 180°. Then reverse the axis. What happens to the matrix? Try the same at 90°.",
    "At a half turn $\\omega$ and $-\\omega$ give the same matrix: there the logarithm has two values, and a "
    "program must choose one. A controller that follows the axis sees a jump there. At 90° the two turns are "
    "inverse to each other.",
    axis=(1, 0, 1),
    angle=180,
)

# %% [markdown]
# ### Where the formula for the logarithm fails
#
# At $\theta = 0$ there is no axis, and the logarithm is $0$. At a half turn $\sin\theta = 0$, so the formula divides by
# zero, but there is an axis. Rodrigues' formula with $\theta = \pi$, and $\hat\omega^2 = \omega\omega^T - I$ from
# above, give
#
# $$R + I = 2\,\omega\,\omega^T$$
#
# Every column of this matrix is a multiple of $\omega$. Divide the longest column by its length: this is $\omega$ or
# $-\omega$, and both are right (Lynch & Park, section 3.2.3.3).
#
# Near 0 and $\pi$ rounding is magnified, because the cosine is flat there. Turns by a few billionths of a radian are
# common: an iteration meets them in its last steps.

# %%
sizes = np.logspace(-10, 0, 21)
exact = rotations.exp([0.6, 0.0, 0.8], sizes)
by_cosine = np.arccos(np.clip((np.trace(exact, axis1=1, axis2=2) - 1) / 2, -1, 1))
by_log = np.linalg.norm(rotations.log(exact), axis=1)

fig, ax = guide.axes2(xlabel="true angle [rad]", ylabel="relative error of the angle")
ax.loglog(sizes, np.maximum(abs(by_cosine / sizes - 1), 1e-17), label="arc cosine of the trace")
ax.loglog(sizes, np.maximum(abs(by_log / sizes - 1), 1e-17), label="twistarm's logarithm")
ax.legend()
guide.figure(
    fig,
    "The relative error of two ways to find a small angle. By the arc cosine of the trace all digits are lost below "
    "ten to the minus eight radians. The careful logarithm keeps them.",
    f"Below about ${guide.rough(sizes[abs(by_cosine / sizes - 1) > 0.5].max())}$ rad the arc cosine returns "
    f"only zero or noise.",
)

# %% [markdown]
# `rotations.log` and SciPy's `Rotation.as_rotvec` use the quaternion, which is accurate at both ends. Write the formula
# once yourself, in the exercise below. From then on, use one of these functions.
#
# ## In use: which way is down?
#
# You know gravity in the axes of the base, $a_s$. To keep a bottle upright, the gripper needs it in the axes of the
# tool, $a_t$. The matrix $R_{st}$ takes coordinates of the tool T to coordinates of the base S, $a_s = R_{st}\, a_t$.
# You need the opposite direction:
#
# $$a_t = R_{st}^T\,a_s$$
#
# (An accelerometer in the gripper, at rest, reads $-a_t$: it measures the force that holds it up.)

# %%
a_s = np.array([0.0, 0.0, -9.81])  # downward, the base standing upright [m/s²]
a_t = R.T @ a_s
back = R @ a_s
wrong = np.degrees(np.arccos(np.clip(a_t @ back / (a_t @ a_t), -1, 1)))
guide.table(
    ["", "$x$", "$y$", "$z$"],
    [["gravity in base axes", *a_s], ["in tool axes, $R^T a$", *a_t], ["the slip, $R\\,a$", *back]],
    f"Gravity [m/s²] seen from the tool of `{arm.name}`. With the transpose forgotten, down is {wrong:.0f}° wrong.",
)

# %% [markdown]
# Two habits prevent this mistake. Write the indices, and let the inner ones meet: $a_s = R_{st}\, a_t$. Test with a
# quarter turn about a level axis, where you know the answer. A half turn hides the mistake, because it is its own
# inverse. So does a turn about the vertical, which does not change gravity.
#
# ## What goes wrong in practice
#
# **Degrees.** `exp(axis, 90)` turns by 90 radians. The result is a rotation, so no check complains.

# %%
lost = rotations.angle_between(
    rotations.exp([0, 0, 1], 90.0), rotations.exp([0, 0, 1], np.radians(90.0))
)
guide.say(f"90 radians in place of 90° leave the tool {np.degrees(lost):.0f}° off.")

# %% [markdown]
# **Left and right.** A shaft seen from the base multiplies from the left. A shaft seen from the tool multiplies from
# the right. The mistake does not show while all shafts are parallel and the tool at zero is turned about them alone.
#
# **A program that multiplies for hours.** Rounding slowly moves the product out of $SO(3)$. Call `rotations.nearest`
# from time to time.
#
# ## Exercises

# %%
guide.practice("2_1_2_exponential_rotations")
