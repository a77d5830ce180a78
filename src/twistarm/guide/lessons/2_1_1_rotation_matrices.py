# %% [markdown]
# # Which way does the gripper point?
#
# The encoders have told you every joint angle, and the tool is somewhere in front of the arm. *Where* it is, three
# numbers say. But which way does it point, and how far is it rolled? You will need an answer that a program can
# multiply, compare and send to a motor, and that does not break in the one posture in which you pick things up.
#
# This lesson has two answers. Nine numbers that never fail, and three that do.

# %%
import numpy as np

from twistarm import guide, rotations

arm = guide.arm()
g = arm.fk(arm.ready)  # the tool seen from the base, in the pose that the arm waits in
R = g[:3, :3]

# %% [markdown]
# ## Nine numbers: the axes, written side by side
#
# Fix a frame A to the base and a frame B to the tool. Look at B's three axes from A and write each down as a column:
#
# $$R_{ab} = \begin{bmatrix} x_{ab} & y_{ab} & z_{ab} \end{bmatrix}$$
#
# That is the **rotation matrix** (MLS, section 2.2.1). Read it by columns: the third one says where the tool's $z$ axis
# points.

# %%
guide.say(rf"Your arm, `{arm.name}`, waiting: $$R_{{ab}} = {guide.tex(R)}$$")

# %% tags=["hidden"]
fig, ax = guide.axes3(width=4.8, height=4.0)
size = 0.3 * arm.reach
guide.plot_frame(ax, np.eye(4), "A", size)
guide.plot_arm(ax, arm, tool=False)
guide.plot_frame(ax, g, "B", size)
guide.fit(ax)
nearest = "xyz"[int(np.argmax(np.abs(R[:, 2])))]
guide.figure(
    fig,
    f"The skeleton of {arm.name} with frame A at its base and frame B at its tool; the tool's z axis lies nearest to "
    f"the {nearest} axis of the base",
    r"Frame A at the base, frame B at the tool. The columns of $R_{ab}$ are the axes of B, seen from A.",
)

# %% [markdown]
# ## What makes nine numbers a rotation
#
# The axes have length one and stand square on each other, and they make a right hand:
#
# $$R^T R = I, \qquad \det R = +1$$
#
# The first law is six equations for nine numbers, so that three are left to choose. The second chooses one of two
# halves. All matrices that obey both are called $SO(3)$.

# %%
off = np.abs(R.T @ R - np.eye(3)).max()
guide.say(
    rf"For your tool: the largest entry of $R^T R - I$ is ${guide.rough(off)}$, and $\det R = {np.linalg.det(R):.6f}$."
)
assert off < 1e-12
assert np.isclose(np.linalg.det(R), 1.0)

mirror = np.diag([1.0, -1.0, 1.0])
assert np.allclose(mirror.T @ mirror, np.eye(3))
guide.predict(
    r"A camera hands you $M = \mathrm{diag}(1, -1, 1)$. It has $M^T M = I$. Can the tool be made to point so?",
    rf"No. $\det M = {np.linalg.det(mirror):.0f}$: it is a mirror, which makes a right-handed gripper a left-handed "
    rf"one. "
    "No motor can do that. Whenever a matrix comes from outside, look at its determinant too.",
)

# %% [markdown]
# ## What it does
#
# A point with coordinates $q_b$ on the tool has the coordinates $q_a = R_{ab}\, q_b$ in directions of the base.
# Frames are chained by multiplying, and indices that meet cancel; the way back is the transpose, for which nothing
# has to be solved:
#
# $$R_{ac} = R_{ab} R_{bc}, \qquad R_{ba} = R_{ab}^{-1} = R_{ab}^T$$

# %%
ahead = np.array([0.0, 0.0, 0.1])  # ten centimetres along the tool's own z axis
there = R @ ahead
guide.say(
    rf"Ten centimetres along the tool's own $z$ axis are ${guide.tex(ahead)}$ on the tool and ${guide.tex(there)}$ "
    rf"seen "
    "from the base. Still ten centimetres: a rotation keeps lengths and angles."
)
assert np.isclose(np.linalg.norm(there), np.linalg.norm(ahead))
assert np.allclose(R.T @ there, ahead)

# %% [markdown]
# ## The order matters
#
# Take a book. Turn it by 90° about the vertical axis, then by 90° about the axis that points away from you. Begin
# again, and do the two in the other order.

# %%
quarter = np.pi / 2
Rx, Rz = rotations.exp([1, 0, 0], quarter), rotations.exp([0, 0, 1], quarter)
apart = np.degrees(rotations.angle_between(Rx @ Rz, Rz @ Rx))
guide.predict(
    r"$R_x(90°) R_z(90°)$ or $R_z(90°) R_x(90°)$: by what angle do the two outcomes differ?",
    rf"By {apart:.0f}°. Read a product of rotations from the left and each factor turns about the axes as the ones "
    rf"before "
    "it have left them; read it from the right, and each turns about the axes that stand still. Both readings give the "
    "same matrix, and neither lets you swap two factors.",
)

# %% tags=["hidden"]
fig, panels = guide.axes3(columns=2, width=6.4, height=3.2, box=False)
for ax, product, words in zip(panels, (Rx @ Rz, Rz @ Rx), ("$R_x R_z$", "$R_z R_x$"), strict=True):
    guide.plot_frame(ax, np.eye(3), "A", 1.0, alpha=0.35)
    guide.plot_frame(ax, product, "B", 0.8)
    ax.set_title(words)
    guide.fit(ax, [[-0.9] * 3, [0.9] * 3])
guide.figure(
    fig,
    "Two frames, turned by the same two quarter turns in either order: they point in different directions",
    "The same two quarter turns, in either order.",
)

# %% [markdown]
# ## Three numbers: Euler angles
#
# Nine numbers under six laws: three should do. Turn about $z$ by $\alpha$, about the *new* $y$ by $\beta$, about the
# *newest* $z$ by $\gamma$ (MLS, section 2.2.3):
#
# $$R = R_z(\alpha)\, R_y(\beta)\, R_z(\gamma)$$
#
# Each later turn is about an axis that the earlier ones have moved; so each factor is written to the right.

# %% tags=["hidden"]
orders = {"ZYZ": "as in MLS", "ZYX": "yaw, pitch, roll; URDF's rpy is the same three, listed backwards"}
rows = []
for order, where in orders.items():
    angles = rotations.to_euler(order, R)
    assert np.allclose(rotations.from_euler(order, angles), R)
    rows.append([order, where, *(f"{angle:.2f}°".replace("-", "−") for angle in np.degrees(angles))])
guide.table(
    ["order", "used", "first", "second", "third"], rows, f"One orientation of `{arm.name}`, told twice."
)

# %% [markdown]
# ## Where they fail
#
# Set the middle angle to zero. Then the first and the third turn are about one and the same
# axis, and two triples with the same sum are one orientation:

# %%
one, other = np.radians([50.0, 0.0, 20.0]), np.radians([10.0, 0.0, 60.0])
assert np.allclose(rotations.from_euler("ZYZ", one), rotations.from_euler("ZYZ", other))
guide.slider(
    "frame",
    r"Set $\beta$ to 0. Now move $\alpha$ up and $\gamma$ down by as much. What happens to the frame, and to the nine "
    "numbers?",
    r"Nothing at all. At $\beta = 0$ the matrix is $R_z(\alpha + \gamma)$: only the sum matters, and the difference is "
    r"lost. Endlessly many triples are the same orientation, and an orientation a little beside it needs $\alpha$ and "
    r"$\gamma$ to jump. At $\beta = 180°$ it is the sum that is lost.",
    order="ZYZ",
    alpha=50,
    beta=40,
    gamma=20,
)

# %% [markdown]
# It does not fail only *at* that point. Nearby, a small turn of the tool asks for large changes of the angles. Let the
# tool turn with angular velocity $\omega$; the angles then change by
#
# $$\omega = B(\alpha, \beta, \gamma) (\dot\alpha, \dot\beta, \dot\gamma)^T$$
#
# where the columns of $B$ are the three axes, as they stand. The **condition number** of $B$ says how much harder the
# worst turn is for the angles than the easiest.

# %%
beta = np.radians(np.linspace(1, 179, 179))
B = rotations.euler_rate_map("ZYZ", np.stack([0 * beta, beta, 0 * beta], axis=-1))
condition = np.linalg.cond(B)
c = np.abs(np.cos(beta))
assert np.allclose(condition, np.sqrt((1 + c) / (1 - c))), (
    "two unit axes at the angle β, and one square to both"
)
guide.predict(
    r"At $\beta = 90°$ the three axes stand square: condition 1. What is it at $\beta = 1°$?",
    rf"{condition[0]:.0f}. To turn the tool by one degree in the worst direction, $\alpha$ and $\gamma$ must change by "
    rf"some {1 / np.sqrt(2) / np.tan(beta[0]):.0f}° each, in opposite senses. A controller that runs on Euler angles "
    rf"there "
    "asks the motors for what they cannot do.",
)

# %% tags=["hidden"]
fig, ax = guide.axes2(xlabel="β [°]", ylabel="condition of B")
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
# Whether that hurts depends on where your tool points when it works. Here it is as the arm waits, and as if it pointed
# straight down to pick something up.

# %% tags=["hidden"]
down = rotations.exp([1, 0, 0], np.pi)
rows = []
for words, orientation in (("waiting", R), ("pointing straight down", down)):
    conditions = []
    for order in orders:
        angles = rotations.to_euler(order, orientation)
        number = np.linalg.cond(rotations.euler_rate_map(order, angles))
        conditions.append("fails" if number > 1e6 else f"{number:.1f}")
    rows.append([words, *conditions])
guide.table(["tool", *orders], rows, "Condition of the angles; 1 is best.")
guide.say(
    "Every choice of three angles fails somewhere: three numbers cannot go around all orientations without a seam, "
    "as no "
    "flat map shows the whole globe. So compute with matrices (or with quaternions, in the next lesson), and use "
    "angles "
    "to talk to people."
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **Transposed.** $R_{ab}$ for $R_{ba}$: everything works at the pose where the tool is not turned, and nothing
#   elsewhere. Name matrices with both frames, and let the indices cancel.
# - **Degrees.** `sin(90)` is about the angle 90 radians.
# - **Fixed or moving axes.** URDF's `rpy` turns about fixed axes, first $x$, then $y$, then $z$. That is the moving
#   order
#   $z, y, x$ backwards, and another rotation than moving $x, y, z$.
# - **Not quite a rotation.** Typed with three decimals, or multiplied a million times, a matrix leaves $SO(3)$.

# %% tags=["hidden"]
typed = np.round(R @ rotations.exp([0.3, -0.5, 0.2]), 2)
mended = rotations.nearest(typed)
guide.say(
    rf"Rounded to two decimals, an orientation of your tool is off by "
    rf"{np.abs(typed.T @ typed - np.eye(3)).max():.4f} in "
    rf"$R^TR = I$. The nearest rotation (`rotations.nearest`) is off by "
    rf"${guide.rough(np.abs(mended.T @ mended - np.eye(3)).max())}$, and "
    rf"{np.degrees(rotations.angle_between(mended, R @ rotations.exp([0.3, -0.5, 0.2]))):.2f}° from what was meant."
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("2_1_1_rotation_matrices")
