# %% [markdown]
# # Velocities and wrenches
#
# The gyro in the gripper and the camera on the mast measure the same motion and report different numbers. The driver
# pushes the stick forward. Is that forward of the rover, or of the gripper? And when the gripper pulls at a drawer,
# what torque must the shoulder hold?
#
# A velocity always belongs to a frame from which it is seen. One $6 \times 6$ matrix, the Adjoint, takes velocities
# from frame to frame. Its transpose does the same for forces.
#
# ## Angular velocity
#
# The tool turns, $R(t)$. Differentiate $R R^T = I$: $\dot R R^T + (\dot R R^T)^T = 0$. So the matrix $\dot R R^T$ is
# skew-symmetric: it is $\hat\omega$ of some vector $\omega$. So is $R^T \dot R$.
#
# $$\hat\omega^s = \dot R R^T, \qquad \hat\omega^b = R^T \dot R, \qquad \omega^s = R\,\omega^b$$
#
# Both are the same vector, the **angular velocity**. It is written in the axes of the base ($s$, for *space*) or in
# those of the tool ($b$, for *body*). Source: Murray, Li and Sastry, *A Mathematical Introduction to Robotic
# Manipulation* (MLS), section 2.4.1.
#
# ## Two velocities of one motion
#
# The tool also moves, $g(t) = (p(t), R(t))$. Multiply $\dot g$ by $g^{-1}$, from one side or from the other. Both
# products are the matrix $\hat V$ of a twist:
#
# $$\hat V^s = \dot g\, g^{-1} = \begin{bmatrix} \dot R R^T & \dot p - \dot R R^T p \\ 0 & 0 \end{bmatrix}, \qquad
# \hat V^b = g^{-1}\,\dot g = \begin{bmatrix} R^T \dot R & R^T \dot p \\ 0 & 0 \end{bmatrix}$$
#
# $V^s = (v^s, \omega^s)$ is the **spatial** velocity and $V^b = (v^b, \omega^b)$ the **body** velocity. Read the linear
# parts off the corners: $v^s = \dot p - \omega^s \times p$ and $v^b = R^T \dot p$. Source: MLS, section 2.4.2.
#
# Now all joints of your arm move at once. The program computes $\dot g$ only from two poses a moment apart.

# %% tags=["shown"]
import numpy as np

from twistarm import guide, screws

arm = guide.arm()
theta = 0.7 * arm.ready + 0.3 * arm.random_theta(2)
rates = 0.5 * np.cos(np.arange(arm.n))  # some rates [rad/s, m/s]
g = arm.fk(theta)

eps = 1e-6
g_dot = (arm.fk(theta + eps * rates) - arm.fk(theta - eps * rates)) / (2 * eps)
V_s = screws.vee(g_dot @ np.linalg.inv(g))
V_b = screws.vee(np.linalg.inv(g) @ g_dot)

# %%
guide.table(
    ["", "$v_x$", "$v_y$", "$v_z$", r"$\omega_x$", r"$\omega_y$", r"$\omega_z$"],
    [["$V^s$", *V_s], ["$V^b$", *V_b], ["tool's origin, base axes", *g_dot[:3, 3], "–", "–", "–"]],
    f"One motion of `{arm.name}` [m/s, rad/s].",
)

# %%
speed = np.linalg.norm(g_dot[:3, 3])
guide.predict(
    "How fast does the tool move? In two of the three rows of the table the linear part has this "
    "length. Which row is the third one, and which point has the velocity that it shows?",
    f"At {speed:.3f} m/s. $v^b$ is the velocity of the tool's origin, written in the tool's axes, and "
    f"has this length. $v^s$, here of length {np.linalg.norm(V_s[:3]):.3f} m/s, is the velocity of "
    r"the point of the moving body that is now at the *base's* origin. The tool's origin has $\dot p "
    r"= v^s + \omega^s \times p$.",
)

# %%
fig, ax = guide.axes3(width=5.2, height=4.4)
guide.plot_arm(ax, arm, theta, alpha=0.5, tool=False)
scale = 0.3 * arm.reach / max(speed, np.linalg.norm(V_s[:3]), 1e-9)
for start, vector, name, colour in (
    (g[:3, 3], scale * g_dot[:3, 3], r"$\dot p$", guide.AMBER),
    (np.zeros(3), scale * V_s[:3], "$v^s$", guide.PINK),
):
    guide.plot_vector(ax, start, vector, "", colour)
    ax.text(*(start + 1.25 * vector), name, color=colour, ha="center", va="center")
guide.figure(
    fig,
    f"{arm.name} with two arrows: one at the tool, the velocity of its origin, and one at the base's "
    "origin, the linear part of the spatial velocity. They differ in length and direction.",
    r"$\dot p$ is the velocity of the tool's origin. $v^s$ is that of the point of the tool's body "
    "which is now at the base's origin; imagine the body large enough to reach there. Both arrows "
    "have the same scale.",
)

# %% [markdown]
# ## The Adjoint
#
# From the two definitions, $\hat V^s = g\,\hat V^b g^{-1}$. What does this do to the six numbers of a twist $(v,
# \omega)$? A rotation turns a cross product along with its factors, $R(\omega \times x) = R\omega \times Rx$. As
# matrices, $R\,\hat\omega R^T = (R\omega)^{\wedge}$. (The hat of a longer term is written behind it.) Multiply out:
#
# $$g\,\hat\xi\, g^{-1} = \begin{bmatrix} (R\omega)^{\wedge} & Rv - R\omega \times p \\ 0 & 0 \end{bmatrix}
# = (\mathrm{Ad}_g\,\xi)^{\wedge}, \qquad
# \mathrm{Ad}_g = \begin{bmatrix} R & \hat p R \\ 0 & R \end{bmatrix}$$
#
# because $-\,R\omega \times p = p \times R\omega$. So $V^s = \mathrm{Ad}_g V^b$. This matrix is the **Adjoint** of $g =
# (p, R)$. It takes a twist seen from T to the same twist seen from S, if $g = g_{st}$. It respects the product,
# $\mathrm{Ad}_{g_1 g_2} = \mathrm{Ad}_{g_1}\mathrm{Ad}_{g_2}$, and the inverse, $(\mathrm{Ad}_g)^{-1} =
# \mathrm{Ad}_{g^{-1}}$. Source: MLS, section 2.4.2.

# %%
R, p = g[:3, :3], g[:3, 3]

shorter = np.concatenate([R @ V_b[:3], R @ V_b[3:]])
guide.say(
    r"It is not enough to turn both halves with $R$: without the term $\hat p R$ the linear part of "
    f"$V^s$ would be wrong by {np.linalg.norm((shorter - V_s)[:3]):.3f} m/s here."
)

# %% [markdown]
# ## What depends on the frames
#
# Which of the two velocities depends on where you put the frame of the tool, and which on that of the base?

# %%
g_tn = screws.exp([0.1, 0, 0.2, 0, 0.4, 0])  # a longer tool, shifted and tilted
tooled = arm.with_tool(g_tn, "long_tool")
same = tooled.spatial_jacobian(theta) @ rates
other = tooled.body_jacobian(theta) @ rates
guide.predict(
    "You screw a longer tool to the flange and repeat the motion. Which of $V^s$ and $V^b$ changes?",
    f"$V^b$, by up to {np.abs(other - V_b).max():.3f}. $V^s$ changes by no more than "
    f"${guide.rough(np.abs(same - V_s).max())}$, the error of the small differences: it does not "
    "depend on where on the body you put the tool frame. In the same way $V^b$ does not depend on "
    "where you put the base. So a driver who looks through the gripper's camera commands $V^b$.",
)

# %% [markdown]
# Velocities that are seen from **one** frame add. The velocity of an arm's tool is such a sum. Each joint turns about
# its axis, and the joints before it have moved that axis. Their motion $g$ takes the joint's twist $\xi_i$ at zero to
# $\xi_i' = \mathrm{Ad}_g\,\xi_i$ (MLS, section 2.4.4).

# %%
total, before = np.zeros(6), np.eye(4)
values, speeds = arm.coupling.A @ theta, arm.coupling.A @ rates
for xi, value, rate in zip(arm.screws.T, values, speeds, strict=True):
    total = total + screws.adjoint(before) @ xi * rate
    before = before @ screws.exp(xi, value)
guide.say(
    f"The sum over the {len(values)} moving joints of `{arm.name}` differs from $V^s$ by "
    f"${guide.rough(np.abs(total - V_s).max())}$. The twists $\\xi_i$ are spatial, seen from the "
    "base. Seen from the tool, the same twists are other numbers. They differ by up to "
    f"{np.abs(arm.body_screws - arm.screws).max():.2f}."
)

# %% [markdown]
# ## Wrenches
#
# A force $f$ and a torque $\tau$ together are a **wrench**, $F = (f, \tau)$. Force times velocity plus torque times
# angular velocity is power, and power does not depend on the frame:
#
# $$F_s^T V^s = F_t^T V^b$$
#
# This holds for every $V^b$, and $V^s = \mathrm{Ad}_{g_{st}} V^b$. So wrenches have the law
#
# $$F_t = \mathrm{Ad}_{g_{st}}^T F_s$$
#
# $\mathrm{Ad}_{g_{st}}$ takes velocities from T to S. Its transpose takes wrenches from S to T. Source: MLS, section
# 2.5.1. Let the tool pull at a drawer along its own $z$ axis. Seen from the base, the same wrench also has a torque,
# force times lever arm.

# %%
pull = 20.0  # [N]
F_t = np.array([0, 0, pull, 0, 0, 0])
F_s = screws.adjoint(screws.inverse(g)).T @ F_t
wrong = screws.adjoint(g) @ F_t
guide.table(
    ["", "$f_x$", "$f_y$", "$f_z$", r"$\tau_x$", r"$\tau_y$", r"$\tau_z$"],
    [["seen from the tool", *F_t], ["seen from the base", *F_s], ["wrong: carried as a twist", *wrong]],
    f"A pull of {pull:.0f} N [N, N m]. The power is {F_t @ V_b:.3f} W by the first row and "
    f"{F_s @ V_s:.3f} W by the second.",
)

# %% [markdown]
# A wrench has a screw, as a twist has. It is a force along a line and a torque about this line (Poinsot; MLS, section
# 2.5.2). The product $F_s^T\xi_i'$ is the power that joint $i$ delivers at a rate of one. So it is the torque that its
# motor must hold, or the force of a slide. If it is zero, twist and wrench are called **reciprocal** (MLS, section
# 2.5.3). The bearing then carries the whole load, as a door's hinges carry the door.

# %%
torques = arm.spatial_jacobian(theta).T @ F_s
idle = [f"`{name}`" for name, t in zip(arm.joint_names, torques, strict=True) if abs(t) < 1e-6]
by_motor = [
    f"`{name}` {t:.2f} {'N' if unit == 'm' else 'N m'}".replace("-", "−")
    for name, t, unit in zip(arm.joint_names, torques, arm.units, strict=True)
    if abs(t) >= 1e-6
]
guide.predict(
    "Which joints of your arm hold this pull without their motors? Look for axes that meet the line of the "
    "force or are parallel to it, and for slides at right angles to it.",
    f"Without a motor: {', '.join(idle) or 'none of them here'}. "
    + (f"With their motors, gravity left out: {', '.join(by_motor)}." if by_motor else ""),
)

# %% [markdown]
# ## What goes wrong in practice
#
# **$v^s$ taken for the tool's speed.** A controller that limits its length slows down joints far from the base's
# origin. A joint with an axis through the origin may turn at any speed. Limit $v^b$.
#
# **$(v, \omega)$ or $(\omega, v)$.** Lynch & Park write the second, and their Adjoint has its $\hat p R$ at the lower
# left. If you mix the two books, there is no error message, only wrong numbers.
#
# **$\mathrm{Ad}_g$ for a wrench.** From tool to base a wrench needs the transpose of the inverse. With $\mathrm{Ad}_g$
# the pull of the table keeps its force and loses its torque about the base. At $p = 0$ the mistake does not show, so
# test with a lever arm.
#
# **Adding twists of different frames.** The gyro's reading and the base's velocity are six numbers each. Take one of
# them to the frame of the other by an Adjoint before you add them.
#
# **The stick in the wrong frame.** Push the stick sideways, roll the gripper by a quarter turn, and push it again. If
# the tool now moves another way, the command is read in the tool's axes. Check that you meant these and not the base's.
# Do not test with the stick pushed along the roll axis: a roll does not change this direction.
#
# ## Exercises

# %%
guide.practice("2_3_velocities")
