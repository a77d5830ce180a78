# %% [markdown]
# # Rotations as exponentials
#
# The motor of a joint knows one thing: an angle about its own shaft. The shaft seldom points along x, y or z of your
# base. Which rotation matrix belongs to the shaft and the angle? And the other way round: your tool is to get from one
# orientation to another; about which axis do you turn it, and how far?
#
# Both questions have one answer, the exponential of a matrix and its inverse, the logarithm. All that follows in this
# course is built of it.
#
# ## What the columns are
#
# Write down the unit vectors along the axes of a frame B, in the coordinates of a frame A. Put them side by side:
#
# $$R_{ab} = \begin{bmatrix} x_{ab} & y_{ab} & z_{ab} \end{bmatrix}$$
#
# That is the rotation matrix. Here A is the base of your arm and B its tool, moved to the base's origin so that you
# see the turn alone.

# %%
from math import factorial

import numpy as np
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from twistarm import guide, rotations

arm = guide.arm()
theta = 0.6 * arm.ready + 0.4 * arm.random_theta(3)
R = arm.fk(theta)[:3, :3]
guide.table(
    ["", "$x_{ab}$", "$y_{ab}$", "$z_{ab}$"],
    [[f"along ${axis}$ of the base", *row] for axis, row in zip("xyz", R, strict=True)],
    f"The tool's axes of `{arm.name}`, seen from the base: each column is one of them.",
)

# %% tags=["hidden"]
fig, ax = guide.axes3(box=False)
guide.plot_frame(ax, np.eye(3), "A", alpha=0.45)
guide.plot_frame(ax, R, "B")
guide.fit(ax, [[-0.6] * 3, [0.6] * 3])
guide.figure(
    fig,
    "Two frames with one origin. A, faint, has the axes of the base. B has the axes of the tool; the tip of each is a "
    "column of the rotation matrix.",
    "Frame A is the base, frame B the tool. The coordinates of the tip of $x_B$, seen from A, are the first column.",
)

# %% [markdown]
# The columns have length one and stand at right angles. All nine of their dot products together are one equation:
#
# $$R^\top R = I$$
#
# The columns are also right-handed, $x \times y = z$, which is the same as $\det R = +1$. Matrices with both properties
# are called *special orthogonal*, and their set is $SO(3) \subset \mathbb{R}^{3\times 3}$. Source: MLS, section 2.2.1.
#
# You may find $R^\top R = 1$ written, or all $n\times n$ matrices called $SO(n)$. The first property gives
# $\det R = \pm 1$ only, and most matrices have neither.

# %%
mirror = np.diag([1.0, 1.0, -1.0])
mean = (R + np.eye(3)) / 2
skewed = R + [[0, 0.1, 0], [0, 0, 0], [0, 0, 0]]


def off_orthogonal(M):
    """The largest entry of Mᵀ M − I."""
    return np.abs(M.T @ M - np.eye(3)).max()


assert off_orthogonal(R) < 1e-9
assert np.isclose(np.linalg.det(R), 1)
assert off_orthogonal(mirror) == 0
guide.table(
    ["matrix", "largest entry of $M^\\top M - I$", "$\\det M$"],
    [
        [name, f"${guide.rough(off_orthogonal(M))}$", np.linalg.det(M)]
        for name, M in (
            ("$R$ of the tool", R),
            ("a mirror", mirror),
            ("one entry of $R$ changed", skewed),
        )
    ],
    "Only the first is a rotation. The mirror makes a right hand a left one, and no arm does that.",
)

# %% [markdown]
# ## A group
#
# Do one turn after the other and you have a turn. A set with an operation of this kind is a *group* if four things
# hold. For $A, B \in SO(3)$:
#
# - closure: $AB$ is in $SO(3)$ too;
# - identity: $IR = RI = R$;
# - inverse: $R^\top R = R R^\top = I$, so that the transpose undoes the turn;
# - associativity: $(AB)C = A(BC)$, as for all matrices.
#
# Two things are missing from the list. One is $AB = BA$. The other is the sum.

# %%
A, B = rotations.exp([1, 0, 0], np.pi / 2), rotations.exp([0, 1, 0], np.pi / 2)
apart = np.degrees(rotations.angle_between(A @ B, B @ A))
half = rotations.exp([0, 0, 1], np.pi / 2)
halved = np.linalg.det((half + np.eye(3)) / 2)
assert off_orthogonal(A @ B) < 1e-12
guide.predict(
    "Take a quarter turn about $x$ and a quarter turn about $y$. How far apart are the two orders? And is the mean of "
    "$I$ and a quarter turn about $z$ the eighth of a turn between them?",
    f"The orders are {apart:.0f}° apart. The mean has determinant {halved:.2f}: it is no rotation, it shrinks things. "
    "Rotations are multiplied. What can be added and halved is their logarithm, at the end of this lesson.",
)

# %% [markdown]
# ## A point goes round
#
# Fix a unit vector $\omega$, the shaft, and let a body turn about it at one radian per second. A point $q$ of the body
# moves at right angles to the shaft and to itself:
#
# $$\dot q(t) = \omega \times q(t) = \hat\omega\, q(t), \qquad
# \hat\omega = \begin{bmatrix} 0 & -\omega_3 & \omega_2 \\ \omega_3 & 0 & -\omega_1 \\
# -\omega_2 & \omega_1 & 0 \end{bmatrix}$$
#
# The hat writes the cross product as a matrix. Its matrices are *skew-symmetric*, $\hat\omega^\top = -\hat\omega$, and
# their set is called $so(3)$. What we have is a linear differential equation with a constant matrix. Its solution is
# the one that you know from numbers, where $\dot q = a q$ gives $q = e^{at} q(0)$:
#
# $$q(t) = e^{\hat\omega t} q(0)$$
#
# After $\theta$ seconds at one radian per second the body has turned by $\theta$. Therefore
#
# $$R(\omega, \theta) = e^{\hat\omega\theta}$$

# %%
omega = np.array([1.0, 0.5, 2.0]) / np.linalg.norm([1.0, 0.5, 2.0])
q0 = np.array([0.8, -0.3, 0.4])
times = np.linspace(0, 1.5 * np.pi, 100)
orbit = np.array([expm(rotations.skew(omega) * t) @ q0 for t in times])  # SciPy's, of any matrix

assert np.allclose(rotations.skew(omega) @ q0, np.cross(omega, q0))
assert np.allclose(orbit, rotations.exp(omega, times) @ q0)
rates = np.gradient(orbit, times, axis=0)[1:-1]
assert np.abs(rates - np.cross(omega, orbit[1:-1])).max() < 1e-3

# %% tags=["hidden"]
fig, ax = guide.axes3(box=False, height=4.0, elev=35, azim=-100)
ax.plot(*orbit.T, color=guide.GREY, linestyle="-")
guide.plot_vector(ax, [0, 0, 0], 1.1 * omega, r"$\omega$", guide.PINK)
for k, name in ((0, "$q(0)$"), (50, "$q(t)$")):
    guide.plot_vector(ax, [0, 0, 0], orbit[k], "", guide.INK)
    ax.text(*(0.6 * orbit[k] + [0.12, 0, -0.1]), name, ha="center", va="center")
    guide.plot_vector(ax, orbit[k], 0.6 * np.cross(omega, orbit[k]), r"$\omega\times q$", guide.ORANGE)
guide.fit(ax, [*orbit, [0, 0, 0], omega])
guide.figure(
    fig,
    "A point on a circle around an axis omega, at two instants. An arrow along the circle is its velocity, omega cross "
    "q, at right angles to the axis and to q.",
    r"The point keeps its distance from the shaft. Its velocity is $\omega \times q$ at every instant.",
)

# %% [markdown]
# ## The series becomes Rodrigues' formula
#
# The exponential of a matrix is the same series as that of a number:
#
# $$e^{\hat\omega\theta} = I + \hat\omega\theta + \frac{(\hat\omega\theta)^2}{2!}
# + \frac{(\hat\omega\theta)^3}{3!} + \cdots$$
#
# For a unit vector the powers repeat: $\hat\omega^3 = -\hat\omega$. Sort the terms by $\hat\omega$ and $\hat\omega^2$:
#
# $$e^{\hat\omega\theta} = I + \left(\theta - \frac{\theta^3}{3!} + \frac{\theta^5}{5!} - \cdots\right)\hat\omega
# + \left(\frac{\theta^2}{2!} - \frac{\theta^4}{4!} + \frac{\theta^6}{6!} - \cdots\right)\hat\omega^2$$
#
# The brackets are the sine and one minus the cosine. This is **Rodrigues' formula**:
#
# $$e^{\hat\omega\theta} = I + \hat\omega\sin\theta + \hat\omega^2(1 - \cos\theta), \qquad \|\omega\| = 1$$
#
# Source: MLS, section 2.2.2, equation (2.14).


# %%
def rodrigues(omega, theta):
    """The rotation by theta [rad] about the unit vector omega."""
    W = rotations.skew(omega)
    return np.eye(3) + W * np.sin(theta) + W @ W * (1 - np.cos(theta))


angle = 2.1
assert np.allclose(rodrigues(omega, angle), Rotation.from_rotvec(omega * angle).as_matrix())
assert np.allclose(rodrigues(omega, angle), expm(rotations.skew(omega) * angle))
assert np.allclose(np.linalg.matrix_power(rotations.skew(omega), 3), -rotations.skew(omega))


def series(omega, theta, terms):
    """The first terms of the series."""
    X = rotations.skew(omega) * theta
    return sum(np.linalg.matrix_power(X, k) / factorial(k) for k in range(terms))


counts = np.arange(1, 41)
angles = (0.5, 3.0, 6.0)
errors = {a: [np.abs(series(omega, a, n) - rodrigues(omega, a)).max() for n in counts] for a in angles}
enough = {a: counts[np.argmax(np.array(e) < 5e-10)] for a, e in errors.items()}
guide.predict(
    "How many terms of the series do you need for nine correct decimals, at half a radian and at six radians, nearly "
    "a full turn? And at which angle is the series cheaper than the formula?",
    f"{enough[0.5]} at half a radian, {enough[6.0]} at six radians. It is cheaper nowhere: the formula needs one "
    "sine, one cosine and the square of one matrix, whatever the angle.",
)

# %% tags=["hidden"]
fig, ax = guide.axes2(xlabel="terms of the series", ylabel="largest error of an entry")
for a in angles:
    ax.semilogy(counts, np.maximum(errors[a], 1e-17), label=f"{a:g} rad")
ax.legend()
guide.figure(
    fig,
    "The error of the series against the number of its terms, on a logarithmic scale. For half a radian it falls at "
    "once. For six radians it first grows, then falls. All three end where rounding begins.",
    "The larger the angle, the longer the series; for six radians its terms first grow.",
)

# %% [markdown]
# You may find $\omega^4/4!$ and $\omega^6/6!$ in this series, and the axis said to turn "for $\omega$ units of time".
# The angle $\theta$ belongs there: $\omega$ is a vector, and its fourth power means nothing.
#
# ### The condition that is easily lost
#
# Rodrigues' formula holds for a **unit** vector. For any other, divide first:
#
# $$e^{\hat\omega\theta} = I + \frac{\hat\omega}{\|\omega\|}\sin(\|\omega\|\theta)
# + \frac{\hat\omega^2}{\|\omega\|^2}\,(1 - \cos(\|\omega\|\theta))$$
#
# An axis out of a CAD file or a URDF may well have another length.

# %% tags=["reveal"]
long_axis = np.array([0.0, 0.0, 2.0])
careless = rodrigues(long_axis, np.radians(30))
careful = rodrigues(long_axis / 2, 2 * np.radians(30))
assert np.allclose(careful, expm(rotations.skew(long_axis) * np.radians(30)))
guide.say(
    f"For $\\omega = (0, 0, {long_axis[2]:.0f})$ and $\\theta = 30°$ the short formula gives a matrix of determinant "
    f"**{np.linalg.det(careless):.3f}**, which is no rotation. The long one gives a turn by "
    f"{np.degrees(rotations.angle_between(np.eye(3), careful)):.0f}°, because such a shaft turns at two radians per "
    "second."
)

# %% [markdown]
# ## The shafts of your arm
#
# For $\omega$ along x, y or z Rodrigues' formula gives the three elementary matrices of the first lesson. For the
# shafts of your arm, as they stand now, it gives the rotation that each joint would add.

# %%
turning = guide.arm_with(
    "a joint that turns", lambda a: bool(np.any(np.linalg.norm(a.screws[3:], axis=0) > 0.5))
)
pose = turning.ready
shafts = turning.spatial_jacobian(pose)[3:]
rows, before, step = [], turning.fk(pose)[:3, :3], np.radians(40)
for name, shaft, unit in zip(turning.joint_names, shafts.T, np.eye(turning.n), strict=True):
    if not np.isclose(np.linalg.norm(shaft), 1):
        continue  # a slide, or a coordinate that moves several joints
    after = turning.fk(pose + step * unit)[:3, :3]
    assert np.allclose(rodrigues(shaft, step) @ before, after)
    assert np.allclose(rotations.skew(shaft) @ shaft, 0)
    rows.append(
        [f"`{name}`", *shaft, f"${guide.rough(np.abs(rodrigues(shaft, step) @ before - after).max())}$"]
    )
guide.table(
    ["joint", "$\\omega_x$", "$\\omega_y$", "$\\omega_z$", "off from forward kinematics"],
    rows,
    f"Shafts of `{turning.name}` at ready, seen from the base. Each joint was moved by {np.degrees(step):.0f}°; "
    r"$e^{\hat\omega\theta}R$ was compared with the tool's new orientation.",
)

# %% [markdown]
# The new factor stands on the **left**, because the shaft is seen from the base. A shaft that is seen from the tool
# would stand on the right.
#
# ## The way back: the logarithm
#
# Every rotation is a turn about one axis. To find it, read Rodrigues' formula backwards. The trace holds the angle, and
# the difference of opposite entries holds the axis:
#
# $$\theta = \cos^{-1}\frac{\mathrm{tr}\,R - 1}{2}, \qquad
# \omega = \frac{1}{2\sin\theta}\begin{bmatrix} r_{32} - r_{23} \\ r_{13} - r_{31} \\ r_{21} - r_{12} \end{bmatrix}$$
#
# Source: MLS, section 2.2.2. The product $\omega\theta$ is the *logarithm* of $R$, three numbers that are called its
# exponential coordinates. So one turn takes the tool from one orientation to another, however many joints moved.

# %%
start, end = arm.fk(arm.ready)[:3, :3], R
change = end @ start.T  # seen from the base: change · start = end
w = rotations.log(change)
turn = np.linalg.norm(w)
assert np.allclose(rotations.exp(w) @ start, end)
assert np.isclose(turn, np.linalg.norm(Rotation.from_matrix(change).as_rotvec()))
if 0.01 < turn < np.pi - 0.01:  # where the formula above may be used
    vee = np.array(
        [change[2, 1] - change[1, 2], change[0, 2] - change[2, 0], change[1, 0] - change[0, 1]]
    )
    assert np.allclose(vee / (2 * np.sin(turn)) * np.arccos((np.trace(change) - 1) / 2), w)

halfway = rotations.exp(w / 2) @ start
guide.say(
    f"From ready to the orientation of the first table, `{arm.name}` turns its tool by **{np.degrees(turn):.1f}°** "
    f"about $({', '.join(f'{x:.3f}' for x in (w / turn if turn else w) + 0.0)})$, seen from the base. Half the "
    f"logarithm is half the way: {np.degrees(rotations.angle_between(start, halfway)):.1f}° from the one and "
    f"{np.degrees(rotations.angle_between(halfway, end)):.1f}° from the other."
)

# %%
guide.slider(
    "axis_angle",
    "Set a half turn, 180°. Then reverse the axis. What happens to the matrix? Try the same at 90°.",
    "At a half turn $\\omega$ and $-\\omega$ give the same matrix: there the logarithm has two values, and a program "
    "has to choose one. At 90° the two turns are inverse to each other.",
    axis=(1, 0, 1),
    angle=180,
)

# %% [markdown]
# ### Where the formula for the logarithm fails
#
# At $\theta = 0$ there is no axis to find, and at a half turn $\sin\theta = 0$ leaves nothing to divide by. Near both
# ends rounding is magnified, because the cosine is flat there. A turn by a few billionths of a radian is no rarity: it
# is what an iteration sees just before it ends.

# %% tags=["hidden"]
sizes = np.logspace(-10, 0, 21)
exact = rotations.exp([0.6, 0.0, 0.8], sizes)
by_cosine = np.arccos(np.clip((np.trace(exact, axis1=1, axis2=2) - 1) / 2, -1, 1))
by_log = np.linalg.norm(rotations.log(exact), axis=1)
tiny = np.argmin(abs(sizes - 1e-9))
assert by_cosine[tiny] == 0
assert np.abs(by_log / sizes - 1).max() < 1e-6

fig, ax = guide.axes2(xlabel="true angle [rad]", ylabel="relative error of the angle")
ax.loglog(sizes, np.maximum(abs(by_cosine / sizes - 1), 1e-17), label="arc cosine of the trace")
ax.loglog(sizes, np.maximum(abs(by_log / sizes - 1), 1e-17), label="twistarm's logarithm")
ax.legend()
guide.figure(
    fig,
    "The relative error of two ways to find a small angle. By the arc cosine of the trace all digits are lost below "
    "ten to the minus eight radians. The careful logarithm keeps them.",
    f"Below {1e-8:g} rad the arc cosine returns nothing but zero or noise.",
)

# %% [markdown]
# `rotations.log` goes by the quaternion of the lesson before, which is sensitive at both ends. Use it, or SciPy's
# `Rotation.as_rotvec`, and keep the formula for the blackboard.
#
# ## In use: which way is down?
#
# A gripper with an accelerometer feels gravity in its own axes. You know gravity in the axes of the base. The matrix
# $R_{st}$ takes tool coordinates to base coordinates, $f_s = R_{st} f_t$, so what the sensor reads is the other
# direction:
#
# $$f_t = R_{st}^\top f_s$$

# %%
g_s = np.array([0.0, 0.0, -9.81])  # downward, the base standing upright [m/s²]
g_t = R.T @ g_s
back = R @ g_s
assert np.allclose(R @ g_t, g_s)
assert np.allclose(g_t, Rotation.from_matrix(R).inv().apply(g_s))
wrong = np.degrees(np.arccos(np.clip(g_t @ back / (g_t @ g_t), -1, 1)))
guide.table(
    ["", "$x$", "$y$", "$z$"],
    [["gravity in base axes", *g_s], ["in tool axes, $R^\\top g$", *g_t], ["the slip, $R\\,g$", *back]],
    f"Gravity [m/s²] as the tool of `{arm.name}` feels it. With the transpose forgotten, down is {wrong:.0f}° wrong.",
)

# %% [markdown]
# Two habits keep you from the slip. Write the indices, and let the inner ones meet: $f_s = R_{st} f_t$. And test with
# a turn whose answer you know, about an axis that is not the one in question: a turn about the vertical leaves gravity
# as it is, and would hide the slip.
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
# **An axis that is not a unit vector.** The matrix stretches: the tool grows or shrinks as the joint turns. Check
# $\det R = 1$ once, where the axis enters your program.
#
# **Left and right.** A shaft seen from the base multiplies from the left, one seen from the tool from the right. The
# slip does not show while all shafts are parallel, and does with the first that is not.
#
# **Rotations that are averaged or filtered entry by entry.** The result is no rotation. Filter the logarithms of small
# differences, or quaternions with signs that agree.
#
# **A program that multiplies for hours.** Rounding carries the product out of $SO(3)$ slowly. Put it back now and
# then, with `rotations.nearest`.
#
# **The half turn.** Near 180° the axis may flip to its negative from one instant to the next. It is no error of yours:
# both are right. A controller that follows the axis sees a jump.
#
# ## Exercises

# %%
guide.practice("2_1_2_exponential_rotations")
