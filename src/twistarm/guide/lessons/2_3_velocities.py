# %% [markdown]
# # Velocities and wrenches
#
# The gyro in the gripper says one thing, the camera on the mast another, and both measure the same motion. The driver
# pushes the stick forward: forward of the rover, or forward of the gripper? And when the gripper pulls at a drawer,
# what does the shoulder feel of it?
#
# A velocity is a motion *and* the frame in which its numbers are written. One $6 \times 6$ matrix passes from frame to
# frame, for velocities and, transposed, for forces.
#
# ## Two velocities of one motion
#
# The tool moves, $g(t) = g_{st}(\theta(t))$. Multiply $\dot g$ by $g^{-1}$, on one side or on the other. Both products
# have the form $\hat V$ of a twist:
#
# $$\hat V^s = \dot g\, g^{-1}, \qquad \hat V^b = g^{-1}\,\dot g$$
#
# $V^s = (v^s, \omega^s)$ is the **spatial** velocity, with its numbers in the axes of the base. $V^b = (v^b, \omega^b)$
# is the **body** velocity, with its numbers in the axes of the tool. Source: MLS, section 2.4.2.
#
# On your arm all joints move at once; $\dot g$ comes from two positions a moment apart, and nothing else.

# %%
import numpy as np
import pinocchio as pin

from twistarm import guide, screws

arm = guide.arm()
theta = 0.7 * arm.ready + 0.3 * arm.random_theta(2)
rates = 0.5 * np.cos(np.arange(arm.n))  # some rates [rad/s, m/s]
g = arm.fk(theta)

h = 1e-6
g_dot = (arm.fk(theta + h * rates) - arm.fk(theta - h * rates)) / (2 * h)
V_s = screws.vee(g_dot @ np.linalg.inv(g))
V_b = screws.vee(np.linalg.inv(g) @ g_dot)
assert np.allclose(V_s, arm.spatial_jacobian(theta) @ rates, atol=1e-6)
assert np.allclose(V_b, arm.body_jacobian(theta) @ rates, atol=1e-6)
guide.table(
    ["", "$v_x$", "$v_y$", "$v_z$", r"$\omega_x$", r"$\omega_y$", r"$\omega_z$"],
    [["$V^s$", *V_s], ["$V^b$", *V_b], ["tool's origin, base axes", *g_dot[:3, 3], "", "", ""]],
    f"One motion of `{arm.name}` [m/s, rad/s].",
)

# %%
speed = np.linalg.norm(g_dot[:3, 3])
assert np.allclose(g[:3, :3] @ V_b[:3], g_dot[:3, 3], atol=1e-6)
assert np.allclose(V_s[:3] + np.cross(V_s[3:], g[:3, 3]), g_dot[:3, 3], atol=1e-6)
guide.predict(
    "How fast does the tool move? Two of the three rows of the table have a linear part of this length. Which one has "
    "not, in general, and what does it say?",
    f"At {speed:.3f} m/s. $v^b$ is the velocity of the tool's origin, written in the tool's axes, and has this length. "
    f"$v^s$, here of length {np.linalg.norm(V_s[:3]):.3f} m/s, is the velocity of the point of the moving body that "
    r"is just at the *base's* origin. The tool's own is $\dot p = v^s + \omega^s \times p$.",
)

# %% tags=["hidden"]
fig, ax = guide.axes3(width=5.2, height=4.4)
guide.plot_arm(ax, arm, theta, alpha=0.5, tool=False)
scale = 0.3 * arm.reach / max(speed, np.linalg.norm(V_s[:3]), 1e-9)
guide.plot_vector(ax, g[:3, 3], scale * g_dot[:3, 3], r"$\dot p$", guide.AMBER)
guide.plot_vector(ax, [0, 0, 0], scale * V_s[:3], "$v^s$", guide.PINK)
guide.fit(ax)
guide.figure(
    fig,
    f"{arm.name} with two arrows: one at the tool, the velocity of its origin, and one at the base's origin, the "
    "linear part of the spatial velocity. They differ in length and direction.",
    r"$\dot p$ moves the tool. $v^s$ belongs to the point of the tool's body, thought large, that passes the base.",
)

# %% [markdown]
# ## The Adjoint
#
# From the two definitions, $\hat V^s = g\,\hat V^b g^{-1}$. Written for the six numbers:
#
# $$V^s = \mathrm{Ad}_g\, V^b, \qquad
# \mathrm{Ad}_g = \begin{bmatrix} R & \hat p R \\ 0 & R \end{bmatrix}$$
#
# This is the **Adjoint** of $g = (p, R)$. It takes a twist seen from B to the same twist seen from A, if $g = g_{ab}$.
# It follows the product, $\mathrm{Ad}_{g_1 g_2} = \mathrm{Ad}_{g_1}\mathrm{Ad}_{g_2}$, and the inverse,
# $(\mathrm{Ad}_g)^{-1} = \mathrm{Ad}_{g^{-1}}$. Source: MLS, section 2.4.2.

# %%
R, p = g[:3, :3], g[:3, 3]
Ad = np.block([[R, screws.hat(p) @ R], [np.zeros((3, 3)), R]])
assert np.allclose(Ad, pin.SE3(g).action)  # Pinocchio's order is (v, ω) too
assert np.allclose(Ad @ V_b, V_s, atol=1e-6)
assert np.allclose(np.linalg.inv(Ad), screws.adjoint(screws.inverse(g)))

shorter = np.concatenate([R @ V_b[:3], R @ V_b[3:]])
guide.say(
    r"Turning both halves with $R$ alone is not enough: without the term $\hat p R$ the linear part of $V^s$ is "
    f"{np.linalg.norm((shorter - V_s)[:3]):.3f} m/s off here."
)

# %% [markdown]
# ## Who sees what
#
# The body velocity does not depend on where you have put the base; the spatial one does not depend on where on the
# body you have put the tool frame. You can use this to test a program, and to choose: a driver who looks through the
# gripper's camera commands $V^b$.

# %%
g_tn = screws.exp([0.1, 0, 0.2, 0, 0.4, 0])  # a longer tool, shifted and tilted
tooled = arm.with_tool(g_tn, "long_tool")
same = tooled.spatial_jacobian(theta) @ rates
other = tooled.body_jacobian(theta) @ rates
assert np.allclose(same, V_s, atol=1e-6)
assert np.allclose(other, screws.adjoint(screws.inverse(g_tn)) @ V_b, atol=1e-6)
guide.predict(
    "You screw a longer tool to the flange and repeat the motion. Which of $V^s$ and $V^b$ changes?",
    f"$V^b$, by up to {np.abs(other - V_b).max():.3f}. $V^s$ changes by no more than "
    f"${guide.rough(np.abs(same - V_s).max())}$, which is rounding and the differences' error.",
)

# %% [markdown]
# Velocities that are seen from **one** frame add. That is how an arm's come about: each joint turns about its axis
# where the joints before it have carried the axis, and $V^s$ is the sum. A twist $\xi_i$ that was seen at zero is
# carried by the Adjoint of the motions before it. (MLS, section 2.4.4.)

# %%
total, before = np.zeros(6), np.eye(4)
values, speeds = arm.coupling.A @ theta, arm.coupling.A @ rates
for xi, value, rate in zip(arm.screws.T, values, speeds, strict=True):
    total = total + screws.adjoint(before) @ xi * rate
    before = before @ screws.exp(xi, value)
assert np.allclose(total, V_s, atol=1e-6)
guide.say(
    f"The sum over the {len(values)} moving joints of `{arm.name}` is off from $V^s$ by "
    f"${guide.rough(np.abs(total - V_s).max())}$."
)

# %%
guide.slider(
    "twist",
    "Let the body turn about $z$ and move the axis away from the origin. What becomes of $v$, and what of $\\omega$?",
    "$\\omega$ stays as it is, $v$ grows with the distance: the point of the body that is at the origin has further to "
    "go. This is $\\hat p R\\,\\omega$, the upper right block of the Adjoint.",
    pitch=0.0,
)

# %% [markdown]
# ## Wrenches
#
# A force $f$ and a torque $\tau$ together are a **wrench**, $F = (f, \tau)$. Force times velocity plus torque times
# angular velocity is power, and power does not depend on the frame:
#
# $$F_a^\top V_a = F_b^\top V_b$$
#
# With $V_a = \mathrm{Ad}_{g_{ab}} V_b$ this leaves one way for wrenches to pass from A to B:
#
# $$F_b = \mathrm{Ad}_{g_{ab}}^\top F_a$$
#
# It runs the other way than velocities do. Source: MLS, section 2.5.1. The tool pulls at a drawer, along its own $z$
# axis. Seen from the base the same wrench has a torque, force times lever arm.

# %%
pull = 20.0  # [N]
F_t = np.array([0, 0, pull, 0, 0, 0])
F_s = screws.adjoint(screws.inverse(g)).T @ F_t
assert np.allclose(F_s, [*(R @ F_t[:3]), *np.cross(p, R @ F_t[:3])])
assert np.isclose(F_s @ V_s, F_t @ V_b, atol=1e-5)
assert np.allclose(pin.SE3(g).act(pin.Force(F_t)).vector, F_s)
wrong = screws.adjoint(g) @ F_t
guide.table(
    ["", "$f_x$", "$f_y$", "$f_z$", r"$\tau_x$", r"$\tau_y$", r"$\tau_z$"],
    [["seen from the tool", *F_t], ["seen from the base", *F_s], ["the slip, as if a twist", *wrong]],
    f"A pull of {pull:.0f} N [N, N m]. The power is {F_t @ V_b:.3f} W by the first row and "
    f"{F_s @ V_s:.3f} W by the second.",
)

# %% [markdown]
# What each joint has to hold is the power that a unit of its rate would bring, $\tau_i = \xi_i'^\top F_s$, with
# $\xi_i'$ the joint's twist where it stands now. The Jacobian lessons make a law of it. Here it is checked by the
# principle of virtual work: move one joint a little and see how far the point of the pull goes along the force.

# %% tags=["reveal"]
torques = arm.spatial_jacobian(theta).T @ F_s
force = R @ F_t[:3]
work = [(arm.fk(theta + h * e) - arm.fk(theta - h * e))[:3, 3] @ force / (2 * h) for e in np.eye(arm.n)]
assert np.allclose(torques, work, atol=1e-5)
guide.table(
    ["joint", "holds", ""],
    [
        [f"`{name}`", float(t), "N" if u == "m" else "N m"]
        for name, t, u in zip(arm.joint_names, torques, arm.units, strict=True)
    ],
    f"What the joints of `{arm.name}` hold against the pull, gravity left out.",
)

# %% [markdown]
# ## What goes wrong in practice
#
# **$v^s$ taken for the tool's speed.** A controller that limits its length slows down joints whose axes pass far from
# the base's origin, and lets a joint whose axis passes through the origin turn as fast as it likes. Limit $v^b$.
#
# **$(v, \omega)$ or $(\omega, v)$.** Lynch & Park write the second, and their Adjoint has its $\hat p R$ at the lower
# left. A program from one book with a matrix from the other runs without complaint.
#
# **$\mathrm{Ad}_g$ for a wrench.** It takes the transpose of the inverse. With $\mathrm{Ad}_g$ the pull of the table
# keeps its force and loses its torque about the base. Where $p = 0$ the slip does not show, so test with a lever arm.
#
# **Adding twists of different frames.** The gyro's reading and the base's velocity are six numbers each, and their sum
# means nothing until one of them has passed through an Adjoint.
#
# **The stick in the wrong frame.** If the gripper moves sideways when it is rolled by a quarter turn, the command was
# read in the tool's axes and meant in the base's, or the other way round.
#
# ## Exercises

# %%
guide.practice("2_3_velocities")
