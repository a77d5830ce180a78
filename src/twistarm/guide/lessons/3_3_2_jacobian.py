# %% [markdown]
# # How fast does the tool move, and how hard can it push?
#
# You drive the arm with a joystick. When you push it forward, the tool shall move forward at five centimetres per
# second. What do you send to the motors? And if the tool carries a stone, what torque must each motor hold?
#
# One matrix answers both questions: the **manipulator Jacobian**. It has a column for each joint, and every column is a
# twist.

# %%
import numpy as np

from twistarm import guide, poe, screws

arm = guide.arm()
theta = arm.ready
g = arm.fk(theta)
p = g[:3, 3]  # the tool's origin, seen from the base

# %% [markdown]
# ## One joint, one column
#
# Let one joint move at a rate of one, and hold all others. Everything beyond it, the tool included, then moves with the
# twist of its axis. But this axis is no longer where it was at zero: the joints before it have moved it. An Adjoint
# gives its present twist:
#
# $$\xi_i' = \mathrm{Ad}_{e^{\hat\xi_1\theta_1} \cdots e^{\hat\xi_{i-1}\theta_{i-1}}}\, \xi_i$$
#
# Now let all joints move. Their twists, each times its rate, add up. A sum of columns times numbers is a matrix times a
# vector:
#
# $$V^s = J^s(\theta)\, \dot\theta, \qquad J^s = \begin{bmatrix} \xi_1' & \xi_2' & \cdots & \xi_n' \end{bmatrix}$$
#
# This is the **spatial Jacobian**. Source: Murray, Li and Sastry, *A Mathematical Introduction to Robotic Manipulation*
# (MLS), section 3.4.1. It needs no derivative of a sine or cosine. $V^s = (v, \omega)$ is the spatial twist of the
# tool, the linear part first.

# %% tags=["shown"]
values = arm.coupling.A @ theta  # one value for each axis, mimic joints too
carried, columns = np.eye(4), []
for xi, value in zip(arm.screws.T, values, strict=True):
    columns.append(screws.adjoint(carried) @ xi)
    carried = carried @ screws.exp(xi, value)
axes_now = np.column_stack(columns)
J_s = axes_now @ arm.coupling.A  # joints that follow another are added to its column

# %%
rates_of = ["1 m/s" if unit == "m" else "1 rad/s" for unit in arm.units]
rows = [
    [row, *(f"{x + 0.0:.3f}".replace("-", "−") for x in np.round(numbers, 3))]
    for row, numbers in zip(
        ("$v_x$", "$v_y$", "$v_z$", r"$\omega_x$", r"$\omega_y$", r"$\omega_z$"), J_s, strict=True
    )
]
guide.table(
    ["", *(f"`{name}`" for name in arm.joint_names)],
    rows,
    f"$J^s$ of `{arm.name}`, waiting: $v$ in m/s, $\\omega$ in rad/s, for {' or '.join(sorted(set(rates_of)))}.",
)

# %% [markdown]
# Is it right? Pinocchio computes the same matrix from your file, link by link. A second check needs only forward
# kinematics: move one joint a little to either side, and take the difference.

# %%
if arm.description is not None:
    by_pinocchio = arm.by_pinocchio(theta)[1]
else:
    by_pinocchio = poe.spatial_jacobian(arm.screws, values) @ arm.coupling.A

hybrid = arm.hybrid_jacobian(theta)  # the velocity of the tool's origin and ω, both in axes of the base
speeds = np.linalg.norm(hybrid[:3], axis=0)

h, by_difference = 1e-5, np.zeros((6, arm.n))
for i, step in enumerate(h * np.eye(arm.n)):
    g_dot = (arm.fk(theta + step) - arm.fk(theta - step)) / (2 * h)
    V_hat = g_dot @ screws.inverse(g)  # the spatial twist as a matrix, at a rate of one
    by_difference[:, i] = [*V_hat[:3, 3], V_hat[2, 1], V_hat[0, 2], V_hat[1, 0]]

off, off_difference = np.abs(J_s - by_pinocchio).max(), np.abs(J_s - by_difference).max()
guide.say(
    rf"The largest difference from Pinocchio is ${guide.rough(off)}$; from the difference quotient of $\dot g "
    rf"g^{{-1}}$ it is ${guide.rough(off_difference)}$, the accuracy of such a quotient."
)

# %%
fig, (left, right) = guide.axes3(2, width=6.6, height=3.6, box=False)
guide.plot_arm(left, arm, theta, tool=False)
for k, (xi, point) in enumerate(
    zip(axes_now.T, guide.arm_points(arm, theta)[1:-1], strict=True), start=1
):
    guide.plot_screw(left, xi, 0.42 * arm.reach, near=point)
    end = point - 0.27 * arm.reach * screws.to_screw(xi).axis  # beside the end that has no arrow
    left.text(*end, f"{k}", color=guide.PINK, ha="center", va="center")
guide.plot_arm(right, arm, theta, colour=guide.GREY, alpha=0.6, tool=False)
for k in np.argsort(-speeds, kind="stable"):
    if speeds[k] > 0.02 * speeds.max():
        arrow = 0.5 * arm.reach * hybrid[:3, k] / speeds.max()
        guide.plot_vector(right, p, arrow, colour=guide.BLUE)
        right.text(*(p + 1.14 * arrow + [0, 0, 0.02 * arm.reach]), f"{k + 1}", color=guide.BLUE)
left.set_title("the axes in this configuration")
right.set_title("the tool's velocity by each joint")
guide.figure(
    fig,
    f"Left, {arm.name} as it waits with the axis of each joint where it stands now; right, at its tool, an arrow for "
    "each joint that moves its origin: the velocity that this joint alone gives it",
    "Left, the columns of $J^s$ are the twists of these axes. Right, the velocity that each joint alone, at "
    "a rate of one, gives the tool's origin. The longest arrow is"
    " "
    f"{speeds.max():.2f} m/s. A joint without an arrow does not move the origin.",
)

# %%
last = values.copy()
last[-1] += 0.5
first = values.copy()
first[0] += 0.5
count = arm.screws.shape[1]


def columns_changed(J, other):
    return int((np.abs(J - other).max(axis=0) > 1e-9).sum())


by_last = columns_changed(axes_now, poe.spatial_jacobian(arm.screws, last))
by_first = columns_changed(axes_now, poe.spatial_jacobian(arm.screws, first))
guide.predict(
    f"Your arm has {count} axes. The last joint moves by half a unit. How many of their twists change? And if "
    f"only the first joint moves?",
    f"The last joint changes {by_last}: it moves no other axis. The first one changes {by_first} of {count}: "
    f"never its own, and none that it only shifts along itself. Column $i$ depends only on the joints *before* $i$."
    f"",
)

# %% [markdown]
# ## Read the first three rows with care
#
# The linear part $v$ of $V^s$ is **not** the velocity of the tool. Imagine that the tool's body reaches to the origin
# of the base. $v$ is the velocity of the body's point that is now at this origin. The tool's origin, at $p$, has the
# velocity
#
# $$\dot p = v + \omega \times p$$

# %%
turning = np.linalg.norm(J_s[3:], axis=0) > 0.5
lever = np.where(turning, speeds, -1.0)
k = int(np.argmax(lever))  # the turning joint that moves the tool most
v, omega = J_s[:3, k], J_s[3:, k]
p_dot = v + np.cross(omega, p)
step = h * np.eye(arm.n)[k]
difference = np.linalg.norm(p_dot - v)
guide.say(
    f"Let `{arm.joint_names[k]}` alone move at {rates_of[k]}. The first three rows say "
    f"$|v| = {np.linalg.norm(v):.3f}$ m/s. The tool's origin moves at $|\\dot p| = {np.linalg.norm(p_dot):.3f}$ m/s, "
    f"as the difference quotient of forward kinematics confirms. The two vectors are {difference:.3f} m/s apart."
)

# %% [markdown]
# ## The same from the tool's side
#
# The same axes, seen from the tool, give the **body Jacobian**. The numeric solver uses it:
#
# $$V^b = J^b(\theta)\, \dot\theta, \qquad J^b = \mathrm{Ad}_{g_{st}}^{-1} J^s$$
#
# Here $v$ is the velocity of the tool's origin, in the tool's own axes. Many programs use a third matrix, the *hybrid*
# Jacobian. It has the velocity of the tool's origin in the axes of the base. It is neither $J^s$ nor $J^b$. All three
# are right, and they answer three different questions.

# %%
J_b = screws.adjoint(screws.inverse(g)) @ J_s

guide.table(
    ["Jacobian", "$v$ is the velocity of", "in axes of", "in Pinocchio", r"$\lvert v \rvert$ [m/s]"],
    [
        [
            "$J^s$, spatial",
            "the point at the base's origin",
            "the base",
            "`WORLD`",
            float(np.linalg.norm(J_s[:3, k])),
        ],
        ["$J^b$, body", "the tool's origin", "the tool", "`LOCAL`", float(np.linalg.norm(J_b[:3, k]))],
        [
            "hybrid",
            "the tool's origin",
            "the base",
            "`LOCAL_WORLD_ALIGNED`",
            float(np.linalg.norm(hybrid[:3, k])),
        ],
    ],
    f"One motion, `{arm.joint_names[k]}` at {rates_of[k]}, by three Jacobians.",
)

# %%
moved = theta + 0.7 * np.eye(arm.n)[0]  # the first joint alone; no limit is looked at
alone = np.count_nonzero(arm.coupling.A[:, 0]) == 1 and arm.coupling.A[0, 0] != 0
unchanged = np.abs(arm.body_jacobian(moved) - J_b).max()
guide.predict(
    f"The first joint, `{arm.joint_names[0]}`, moves by 0.7. What changes in $J^b$?",
    (
        f"Nothing: the largest difference is ${guide.rough(unchanged)}$. Seen from the tool, all axes are in "
        f"the same places. The first joint only moves the world behind the base. A column of $J^b$ depends on "
        f"the joints *after* it, a column of $J^s$ on those before it."
        if alone
        else "Another joint follows the first one, so something changes. If the first joint moved alone, nothing would change: seen from the tool, all axes would stay in the same places."
    ),
)

# %% [markdown]
# ## The joystick
#
# Now the first question. The tool's origin shall go along one axis of the base at five centimetres per second. These
# are three equations for the rates of the joints. `np.linalg.lstsq` gives the rates that come nearest to this velocity.
# Of several solutions it gives the one with the smallest sum of squares (with m/s and rad/s counted alike).

# %%
wishes = 0.05 * np.eye(3)
answers = [np.linalg.lstsq(hybrid[:3], wish, rcond=1e-9)[0] for wish in wishes]
missed = np.linalg.norm(hybrid[:3] @ np.transpose(answers) - wishes, axis=0)
best = int(np.argmin(np.round(missed, 9)))  # the axis along which the arm can go best
rates = np.round(answers[best], 12) + 0.0

dt = 0.01
moved_by = (arm.fk(theta + dt * rates) - g)[:3, 3]

# %%
guide.table(
    ["joint", "rate"],
    [
        [f"`{name}`", f"{x:.4f} m/s" if unit == "m" else f"{np.degrees(x):.2f}°/s".replace("-", "−")]
        for name, x, unit in zip(arm.joint_names, rates, arm.units, strict=True)
    ],
    f"Five centimetres per second along the base's ${'xyz'[best]}$ axis.",
)
closed = [i for i in range(3) if missed[i] > 1e-6]
guide.say(
    f"After a hundredth of a second, the tool has moved by {1000 * moved_by[best]:.3f} mm along ${'xyz'[best]}$, "
    f"by forward kinematics. The command was {1000 * dt * wishes[best][best]:.3f} mm. The next hundredth "
    f"needs a new Jacobian, because the axes have moved. "
    + (
        f"Along {' and '.join(f'${chr(120 + i)}$' for i in closed)} this arm cannot follow the command here: "
        f"the best rates miss it by"
        f" {', '.join(f'{missed[i] * 1000:.1f}' for i in closed)} mm/s. The next lesson says why."
        if closed
        else "The tool may turn on the way, because the command does not include the rotation. To forbid it, use all six rows."
    )
)

# %% [markdown]
# ## The transpose holds the load
#
# The tool exerts a force $f$ and a torque $\tau$ on the world: a **wrench** $F_t = (f, \tau)$, in the tool's axes. Its
# power is $F_t^T V^b$. Without friction, the motors supply the same power, at all rates:
#
# $$\tau^T \dot\theta = F_t^T V^b = F_t^T J^b \dot\theta \quad\text{for every } \dot\theta, \qquad\text{so}\qquad
# \tau = (J^b)^T F_t$$
#
# On the left, $\tau$ are the torques of the joints, or forces for those that slide (MLS, section 3.4.2). For a wrench
# that is seen from the base, $\tau = (J^s)^T F_s$. No matrix is inverted. The formula holds in every configuration and
# for any number of joints.
#
# A stone of one kilogram hangs at the tool's origin. To carry the stone, the tool pushes it **up**.

# %% tags=["shown"]
mass, gravity = 1.0, 9.81
f = np.array([0.0, 0.0, mass * gravity])  # on the stone, in axes of the base
F_t = np.append(g[:3, :3].T @ f, np.zeros(3))  # the same in the tool's axes
torques = J_b.T @ F_t


# %%
heaviest = int(np.argmax(np.abs(torques)))
free = 6 - int(np.linalg.matrix_rank(J_b, tol=1e-6))
unit = "N" if arm.units[heaviest] == "m" else "N m"
guide.predict(
    "Which joint of your arm needs the most torque for that kilogram in the ready configuration? And which needs none?",
    (
        f"Most: `{arm.joint_names[heaviest]}`, with {abs(torques[heaviest]):.2f} {unit}. Nothing: "
        + (
            ", ".join(f"`{n}`" for n, t in zip(arm.joint_names, torques, strict=True) if abs(t) < 1e-6)
            or "none"
        )
        + ". A joint with a level axis holds the weight times the horizontal distance of the tool from the "
        "axis. A joint with a vertical axis holds nothing."
        if abs(torques[heaviest]) > 1e-6
        else "None of them: the weight cannot turn any of these axes. The bearings carry the load."
    ),
)

# %%
rows = []
for name, torque, limit, unit in zip(
    arm.joint_names, torques, arm.limits.effort, arm.units, strict=True
):
    share = f"{100 * abs(torque) / limit:.1f} %" if np.isfinite(limit) and limit > 0 else "not given"
    rows.append(
        [
            f"`{name}`",
            f"{np.round(torque, 3) + 0.0:.3f} {'N' if unit == 'm' else 'N m'}".replace("-", "−"),
            share,
        ]
    )
guide.table(
    ["joint", "it holds", "of its limit"],
    rows,
    "One kilogram at the tool, the arm's own weight not counted. The sign says which way the joint pushes.",
)
over = [
    name
    for name, torque, limit in zip(arm.joint_names, torques, arm.limits.effort, strict=True)
    if limit > 0 and abs(torque) > limit
]
if over:
    guide.say(
        f"More than 100 % for {', '.join(f'`{name}`' for name in over)}: by its file this arm cannot hold that stone."
    )
guide.say(
    f"$J^b$ has rank {6 - free} here. "
    + (
        (
            f"So {free} independent wrenches have"
            if free > 1
            else "So one wrench, and its multiples, has"
        )
        + " $(J^b)^T F = 0$. The structure carries such a wrench without any motor, and no motor can produce one."
        if free
        else "So every wrench needs some motor torque, and the motors together can exert any wrench."
    )
)

# %%
guide.scene(
    arm,
    theta,
    caption="The axes are the columns of the spatial Jacobian. Move a joint: which axes move, and which stay?",
    quantity="screws",
)
guide.predict(
    "Which axes moved?",
    "Those of the joints after it, and the tool. Its own axis stays, and so do those before it: column $i$ "
    "depends only on the joints before $i$.",
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **The wrong Jacobian.** $v$ of $J^s$ is taken for the velocity of the tool. A tool that should only turn then drifts
#   away. The farther it is from the base, the faster it drifts.
# - **Columns from the photograph.** The twists at zero are used as columns. They are right at zero, and wrong as soon
#   as a joint has moved an axis beyond it.
# - **The wrench in other axes.** A force measured in axes of the base goes into $(J^b)^T$. It is right only if the tool
#   is not turned, or turned about the direction of the force.
# - **The torque first.** Another library writes $(\omega, v)$ and $(\tau, f)$. The shapes fit, so there is no error.
# - **The sign.** $F$ is what the tool exerts. A force sensor at the wrist often reports what the world exerts on the
#   tool. With the wrong sign the motors push the wrong way.

# %%
test = np.where(np.array(arm.units) == "m", 0.1, 0.3)
true = hybrid @ test
slips = [
    ["$v$ of $J^s$ for the tool's", f"{1000 * np.linalg.norm((J_s @ test - true)[:3]):.0f} mm/s"],
    [
        "columns from the photograph",
        f"{1000 * np.linalg.norm(((arm.screws @ arm.coupling.A - J_s) @ test)[:3]):.0f} mm/s in $v$ of $V^s$",
    ],
    [
        "the wrench in axes of the base",
        f"{np.abs(J_b.T @ np.append(f, np.zeros(3)) - torques).max():.2f} N m or N",
    ],
    ["the torque first", f"{np.abs(J_b.T @ np.roll(F_t, 3) - torques).max():.2f} N m or N"],
    ["the sign", f"{np.abs(2 * torques).max():.2f} N m or N"],
]
guide.table(
    ["mistake", "off by"],
    slips,
    f"On `{arm.name}`, waiting; slides at 0.1 m/s, turns at 0.3 rad/s; the stone of one kilogram.",
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_3_2_jacobian")
