# %% [markdown]
# # Which way does the gripper point?
#
# The encoders report every joint angle, and the tool is somewhere in front of the arm. Three numbers say *where* it is.
# But which way does it point, and how far is it rolled? You need an answer that a program can multiply, compare and
# send to a motor. It must not fail in the configuration in which you pick things up.
#
# This lesson gives two answers: nine numbers that never fail, and three numbers that fail in places.
#
# Take one configuration of your arm as the example. `arm.ready` holds the joint values in which it waits. The program
# mixes them with random values inside the limits. Then `arm.fk` computes the pose of the tool, a $4 \times 4$ matrix
# $g$. The lesson *Where is the tool?* (3.1) shows how. Here you need only its upper left corner, three rows and three
# columns.

# %% tags=["shown"]
import numpy as np

from twistarm import guide, rotations

arm = guide.arm()
theta = 0.6 * arm.ready + 0.4 * arm.random_theta(3)  # 60 % ready, 40 % random
g = arm.fk(theta)  # the tool seen from the base
R = g[:3, :3]

# %% [markdown]
# ## Nine numbers: the axes, written side by side
#
# Fix a frame S to the base and a frame T to the tool. Write the three axes of T, seen from S, as three columns:
#
# $$R_{st} = \begin{bmatrix} x_{st} & y_{st} & z_{st} \end{bmatrix}$$
#
# This is the **rotation matrix**. Source: Murray, Li and Sastry, *A Mathematical Introduction to Robotic Manipulation*
# (MLS), section 2.2.1. Read it by columns: the third column says where the tool's $z$ axis points. Here it is for your
# arm.

# %%
guide.say(rf"The tool of `{arm.name}`: $$R_{{st}} = {guide.tex(R)}$$")

# %%
fig, ax = guide.axes3(width=4.8, height=4.0)
size = 0.3 * arm.reach
guide.plot_arm(ax, arm, theta, alpha=0.45, tool=False)
guide.plot_frame(ax, np.eye(4), "S", size)
guide.plot_frame(ax, g, "T", size)
nearest = "xyz"[int(np.argmax(np.abs(R[:, 2])))]
guide.figure(
    fig,
    f"The skeleton of {arm.name} with frame S at its base and frame T at its tool; the tool's z axis lies nearest to "
    f"the {nearest} axis of the base",
    r"Frame S at the base, frame T at the tool. The columns of $R_{st}$ are the axes of T, seen from S. Circles are "
    "joints that turn, squares joints that slide, the triangle is the base.",
)

# %% [markdown]
# ## What makes nine numbers a rotation
#
# The axes have length one, are at right angles to each other, and form a right-handed frame:
#
# $$R^T R = I, \qquad \det R = +1$$
#
# $R^T R$ is symmetric: its entries above the diagonal equal those below. So the first law is six equations for nine
# numbers. Three are left to choose. The first law allows $\det R = \pm 1$, and the second law takes $+1$. The set of
# all matrices that obey both laws is called $SO(3)$, the *special orthogonal group*.

# %%
off = np.abs(R.T @ R - np.eye(3)).max()
guide.say(
    rf"For your tool: no entry of $R^T R - I$ is above ${guide.rough(max(off, np.finfo(float).eps))}$, "
    rf"and $\det R = {np.linalg.det(R):.6f}$."
)

mirror = np.diag([1.0, -1.0, 1.0])
guide.predict(
    r"A camera hands you $M = \mathrm{diag}(1, -1, 1)$. It has $M^T M = I$. Can the tool have this orientation?",
    rf"No. $\det M = {np.linalg.det(mirror):.0f}$: it is a mirror, which makes a right-handed gripper a "
    rf"left-handed one. No motor can do that. Check the determinant of every matrix that comes from outside.",
)

# %% [markdown]
# ## What it does
#
# An arrow with the coordinates $q_t$ along the tool's axes has the coordinates $q_s = R_{st}\, q_t$ along those of the
# base. To chain frames, multiply: indices that meet cancel. Let C be a camera on the tool. The inverse of a rotation is
# its transpose, so no equation has to be solved:
#
# $$R_{sc} = R_{st} R_{tc}, \qquad R_{ts} = R_{st}^{-1} = R_{st}^T$$

# %% tags=["shown"]
ahead = np.array([0.0, 0.0, 0.1])  # ten centimetres along the tool's own z axis
ahead_s = R @ ahead

# %%
guide.say(
    rf"Ten centimetres along the tool's own $z$ axis are ${guide.tex(ahead)}$ on the tool and ${guide.tex(ahead_s)}$ "
    "seen from the base [m]. They are still ten centimetres: a rotation keeps lengths and angles."
)

# %% [markdown]
# ## Three turns to build from
#
# Turn a frame about one of its axes. This axis stays. The columns of the other two follow from the sine and the cosine:
#
# $$R_x(\theta) = \begin{bmatrix} 1 & 0 & 0 \\ 0 & \cos\theta & -\sin\theta \\ 0 & \sin\theta & \cos\theta
# \end{bmatrix}, \quad
# R_y(\theta) = \begin{bmatrix} \cos\theta & 0 & \sin\theta \\ 0 & 1 & 0 \\ -\sin\theta & 0 & \cos\theta
# \end{bmatrix}$$
#
# $$R_z(\theta) = \begin{bmatrix} \cos\theta & -\sin\theta & 0 \\ \sin\theta & \cos\theta & 0 \\ 0 & 0 & 1
# \end{bmatrix}$$
#
# In $R_y$ the minus is in the last row, because $z$ turns towards $x$.
#
# Their order matters. Take a book. Turn it by 90° about the vertical axis $z$, then by 90° about the axis $x$ that
# points away from you. Begin again, and do the two in the other order. Lesson 2.1.2 shows that two orientations differ
# by one turn about one axis. Its angle says how far apart they are.

# %%
quarter = np.pi / 2
Rx, Rz = rotations.exp([1, 0, 0], quarter), rotations.exp([0, 0, 1], quarter)
difference = np.degrees(rotations.angle_between(Rx @ Rz, Rz @ Rx))
guide.predict(
    r"$R_x(90°) R_z(90°)$ or $R_z(90°) R_x(90°)$: by what angle do the two outcomes differ?",
    rf"They differ by {difference:.0f}°. Read a product of rotations from the left: each factor turns about the "
    rf"axes as the factors before have left them. Read it from the right: each factor turns about the fixed "
    rf"axes. Both readings give the same matrix, and in both the order matters.",
)

# %%
fig, panels = guide.axes3(columns=2, width=6.4, height=3.2, box=False)
for ax, product, words in zip(panels, (Rx @ Rz, Rz @ Rx), ("$R_x R_z$", "$R_z R_x$"), strict=True):
    guide.plot_frame(ax, np.eye(3), "S", 1.0, alpha=0.5)
    guide.plot_frame(ax, product, "T", 0.65)
    ax.set_title(words, pad=0)
guide.figure(
    fig,
    "Two frames, turned by the same two quarter turns in either order: they point in different directions",
    "The same two quarter turns, in either order.",
)

# %% [markdown]
# ## Three numbers: Euler angles
#
# Nine numbers under six equations leave three. Turn about $z$ by $\alpha$, about the *new* $y$ by $\beta$, about the
# *newest* $z$ by $\gamma$ (MLS, section 2.2.3). Each turn is about an axis that the turns before it have moved. So each
# new factor is written to the right:
#
# $$R = R_z(\alpha)\, R_y(\beta)\, R_z(\gamma) = \begin{bmatrix}
# r_{11} & r_{12} & \cos\alpha \sin\beta \\ r_{21} & r_{22} & \sin\alpha \sin\beta \\
# -\sin\beta \cos\gamma & \sin\beta \sin\gamma & \cos\beta \end{bmatrix}$$
#
# The matrix also gives the angles back. Its last entry holds $\beta$, from 0 to 180°. If $\sin\beta$ is not 0, the
# third column holds $\alpha$ and the third row $\gamma$:
#
# $$\beta = \cos^{-1} r_{33}, \qquad \alpha = \mathrm{atan2}(r_{23}, r_{13}), \qquad
# \gamma = \mathrm{atan2}(r_{32}, -r_{31})$$
#
# If $\sin\beta$ is 0, this column and this row are 0 up to their last entries. Then set $\gamma = 0$. The second column
# is $(-\sin\alpha, \cos\alpha, 0)$, so $\alpha = \mathrm{atan2}(-r_{12}, r_{22})$. Other triples are in use too, so a
# file with "Euler angles" must say which. *URDF*, the format in which arms are described, calls its three `rpy`: roll,
# pitch and yaw.

# %%
orders = {"ZYZ": "in MLS", "ZYX": "yaw, pitch, roll; `rpy` is the same three, listed backwards"}
rows = []
for order, where in orders.items():
    angles = rotations.to_euler(order, R)
    rows.append([order, where, *(f"{angle:.2f}°".replace("-", "−") for angle in np.degrees(angles))])
guide.table(
    ["order", "used", "first", "second", "third"],
    rows,
    f"One orientation of `{arm.name}`, in two triples of angles.",
)

# %% [markdown]
# ## Where they fail
#
# Set the middle angle to zero. Then the first and the third turn are about the same axis. Only the sum of their angles
# matters, so different triples give one orientation:

# %%
guide.slider(
    "frame",
    r"Set $\beta$ to 0. Now move $\alpha$ up and $\gamma$ down by as much. What happens to the frame, and to "
    r"the nine numbers?",
    r"Nothing at all. At $\beta = 0$ the matrix is $R_z(\alpha + \gamma)$: only the sum matters, and the difference is "
    r"lost. Infinitely many triples are the same orientation, and for an orientation very close to it $\alpha$ and "
    r"$\gamma$ may have to jump. At $\beta = 180°$ it is the other way round: only the difference matters.",
    order="ZYZ",
    alpha=50,
    beta=40,
    gamma=20,
)

# %% [markdown]
# Euler angles also behave badly *near* that point: a small turn of the tool needs large changes of the angles. Let the
# tool turn. Its **angular velocity** $\omega$ is a vector, seen from the base. It points along the axis of the turn at
# this instant. Its length is the rate in rad/s. With a dot for the rate of an angle,
#
# $$\omega = E(\alpha, \beta, \gamma)\, (\dot\alpha, \dot\beta, \dot\gamma)^T$$
#
# The columns of $E$ are the axes of the three turns at this instant. The first turn is about $z$ of the base. The
# second is about $y$, which the first has turned by $\alpha$. The third is about the tool's $z$ axis, the last column
# of $R$ above:
#
# $$E = \begin{bmatrix} 0 & -\sin\alpha & \cos\alpha \sin\beta \\ 0 & \cos\alpha & \sin\alpha \sin\beta \\
# 1 & 0 & \cos\beta \end{bmatrix}, \qquad \det E = -\sin\beta$$
#
# At $\beta = 0$ the first and the third column are equal, and $E$ has no inverse. An example shows what happens nearby.

# %%
E_30 = rotations.euler_rate_map("ZYZ", np.radians([0, 30, 0]))
same, opposite = (np.linalg.norm(E_30 @ rates) for rates in ([1, 0, 1], [1, 0, -1]))
guide.say(
    r"Let $\beta = 30°$, and let $\alpha$ and $\gamma$ change at 1 rad/s each. In the same sense they turn the tool "
    rf"at {same:.2f} rad/s, in opposite senses at {opposite:.2f} rad/s. The ratio, {same / opposite:.1f}, is the "
    r"**condition number** of $E$ here: the greatest length of $\omega$ divided by the least, for rates of one length."
)
beta = np.radians(np.linspace(1, 179, 179))
E = rotations.euler_rate_map("ZYZ", np.stack([0 * beta, beta, 0 * beta], axis=-1))
condition = np.linalg.cond(E)
rates = np.linalg.inv(E[0])  # at β = 1°: the rates of the angles for each ω
fastest = np.linalg.norm(rates, 2) / np.sqrt(2)  # of α and of γ, which share the worst rate evenly
guide.predict(
    r"At $\beta = 90°$ the three axes are at right angles: the condition number is 1. What is it at $\beta = 1°$?",
    rf"It is {condition[0]:.0f}. To turn the tool at one degree per second in the worst direction, $\alpha$ and "
    rf"$\gamma$ must each change at {fastest:.0f}° per second, in opposite senses. A controller in Euler "
    rf"angles asks the motors there for more than they can do.",
)

# %%
fig, ax = guide.axes2(xlabel="β [°]", ylabel="condition number of E")
ax.semilogy(np.degrees(beta), condition)
ax.set_xticks(range(0, 181, 30))
guide.figure(
    fig,
    "The condition number against the angle beta: 1 at 90 degrees, growing without bound towards 0 and 180 degrees",
    r"ZYZ angles are at their best at $\beta = 90°$, and useless at 0° and 180°.",
)

# %% [markdown]
# ## On your arm
#
# Does this affect your arm? That depends on where its tool points. The table has the condition numbers for three
# orientations: the arm waits, the arm is in the random configuration above, and the tool points straight down.

# %%
down = rotations.exp([1, 0, 0], np.pi)
rows = []
waiting = arm.fk(arm.ready)[:3, :3]
for words, orientation in (("waiting", waiting), ("as above", R), ("pointing straight down", down)):
    conditions = []
    for order in orders:
        angles = rotations.to_euler(order, orientation)
        number = np.linalg.cond(rotations.euler_rate_map(order, angles))
        conditions.append("fails" if number > 1e6 else f"{number:.1f}")
    rows.append([words, *conditions])
guide.table(
    ["tool", *orders],
    rows,
    "Condition numbers. 1 is best. Where the first and third axis coincide, the angles fail.",
)

# %% [markdown]
# Every choice of three angles fails somewhere. Three numbers cannot cover all orientations without a seam, as no flat
# map shows the whole globe. So compute with matrices, or with the quaternions of the next lesson. Use angles only to
# show orientations to people.

# %% [markdown]
# ## What goes wrong in practice
#
# - **Transposed.** $R_{st}$ in place of $R_{ts}$ works where the tool is not turned, or is turned by exactly 180°, as
#   when it points straight down. Test with 30°. Name matrices by both frames, and let the indices cancel.
# - **Degrees.** `sin(90)` is the sine of 90 radians.
# - **Fixed or moving axes.** URDF's `rpy` turns about fixed axes, first $x$, then $y$, then $z$. This equals turns
#   about moving axes in the order $z, y, x$. It differs from turns about moving $x, y, z$.
# - **Not quite a rotation.** A matrix that is typed with few decimals, or multiplied a million times, leaves $SO(3)$.

# %%
typed = np.round(R, 2)
mended = rotations.nearest(typed)
guide.say(
    rf"Rounded to two decimals, the orientation of your tool misses $R^TR = I$ by up to "
    rf"{np.abs(typed.T @ typed - np.eye(3)).max():.4f}. `rotations.nearest` returns the nearest rotation. It "
    rf"is exact to all digits, and {np.degrees(rotations.angle_between(mended, R)):.2f}° from what was meant."
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("2_1_1_rotation_matrices")
