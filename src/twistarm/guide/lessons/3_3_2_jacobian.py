# %% [markdown]
# # How fast does the tool move, and how hard can it push?
#
# You have put a joystick beside the arm. Pushed forward, it is to move the tool forward at five centimetres a second.
# What do you send to the motors? And when the tool then carries a stone, what torque must each motor hold?
#
# Both questions have the same answer: one matrix, the **manipulator Jacobian**. It has a column for each joint, and
# every column is something you know already: a twist.

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
# Hold every joint still but one, and let that one run at a rate of one. Everything beyond it, the tool included, then
# moves with the twist of its axis. But the axis is no longer where it was on the photograph at zero: the joints before
# it have carried it along. An Adjoint says where it is now:
#
# $$\xi_i' = \mathrm{Ad}_{e^{\hat\xi_1\theta_1} \cdots e^{\hat\xi_{i-1}\theta_{i-1}}}\, \xi_i$$
#
# Now let all joints run. Their twists, each times its rate, add up, and a sum of columns times numbers is a matrix
# times a vector:
#
# $$V^s = J^s(\theta)\, \dot\theta, \qquad J^s = \begin{bmatrix} \xi_1' & \xi_2' & \cdots & \xi_n' \end{bmatrix}$$
#
# This is the **spatial Jacobian** (Murray, Li and Sastry, *A Mathematical Introduction to Robotic Manipulation* (MLS),
# section 3.4.1). No derivative of a sine was taken by hand. $V^s = (v, \omega)$ is the spatial twist of the tool, the
# linear part first.

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
# Is it right? Pinocchio builds the same matrix from your file, link by link. A second check needs no theory at all:
# move one joint a little to either side, and see what forward kinematics says.

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
    rf"g^{{-1}}$ it is ${guide.rough(off_difference)}$: a quotient is no more exact than that."
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
left.set_title("the axes, where they stand now")
right.set_title("the tool's velocity by each joint")
guide.figure(
    fig,
    f"Left, {arm.name} as it waits with the axis of each joint where it stands now; right, at its tool, an arrow for "
    "each joint that moves its origin: the velocity that this joint alone gives it",
    "Left, the columns of $J^s$ are the twists of these axes. Right, what each joint alone, at a rate of one, does "
    "to the tool's origin; the longest arrow is "
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
    f"Your arm has {count} axes. The last joint moves by half a unit. How many columns of axes change? And if only the "
    "first one moves?",
    f"The last joint changes {by_last}: it carries no axis. The first one changes {by_first} of {count}: never its "
    f"own, and none that it moves along itself. Column $i$ depends on the joints *before* $i$ alone.",
)

# %% [markdown]
# ## Read the first three rows with care
#
# The linear part $v$ of $V^s$ is **not** the velocity of the tool. Imagine the tool's body so large that it reaches the
# origin of the base: $v$ is the velocity of the point of it that is just there. The tool's origin, at $p$, has the
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
apart = np.linalg.norm(p_dot - v)
guide.say(
    f"Let `{arm.joint_names[k]}` alone run at {rates_of[k]}. The first three rows say "
    f"$|v| = {np.linalg.norm(v):.3f}$ m/s. The tool's origin moves at $|\\dot p| = {np.linalg.norm(p_dot):.3f}$ m/s, "
    f"as the difference quotient of forward kinematics confirms. The two vectors are {apart:.3f} m/s apart."
)

# %% [markdown]
# ## The same from the tool's side
#
# Look at the axes from the tool instead, and you have the **body Jacobian**, with which the solver walked to its target:
#
# $$V^b = J^b(\theta)\, \dot\theta, \qquad J^b = \mathrm{Ad}_{g_{st}}^{-1} J^s$$
#
# Here $v$ is what a person expects: the velocity of the tool's origin, in the tool's own axes. Many programs use a
# third matrix, which keeps that velocity but writes it in axes of the base. It is called *hybrid*, and it is neither
# $J^s$ nor $J^b$. All three are right, and they answer three questions.

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
    f"One motion, `{arm.joint_names[k]}` at {rates_of[k]}, told three times.",
)

# %%
moved = theta + 0.7 * np.eye(arm.n)[0]  # the first joint alone; no limit is looked at
alone = np.count_nonzero(arm.coupling.A[:, 0]) == 1 and arm.coupling.A[0, 0] != 0
unchanged = np.abs(arm.body_jacobian(moved) - J_b).max()
guide.predict(
    f"The first joint, `{arm.joint_names[0]}`, moves by 0.7. What changes in $J^b$?",
    (
        f"Nothing: the largest difference is ${guide.rough(unchanged)}$. If you sit on the tool and look back along "
        "the arm, you see the same axes in the same places; the first joint only moves the world beyond. $J^b$ depends on "
        "the joints *after* the column, $J^s$ on those before it."
        if alone
        else "Another joint follows the first one, so something does change. If it moved alone, nothing would: from "
        "the tool you would see the same axes in the same places."
    ),
)

# %% [markdown]
# ## The joystick
#
# Now the question from the beginning. The tool's origin is to go along one axis of the base at five centimetres a
# second. Those are three equations, and the unknowns are the rates of the joints. `np.linalg.lstsq` gives the rates
# that come nearest to the wish, and of several solutions the one with the smallest sum of squares (m/s and rad/s
# counted alike).

# %%
wishes = 0.05 * np.eye(3)
answers = [np.linalg.lstsq(hybrid[:3], wish, rcond=1e-9)[0] for wish in wishes]
missed = np.linalg.norm(hybrid[:3] @ np.transpose(answers) - wishes, axis=0)
best = int(np.argmin(np.round(missed, 9)))  # the axis along which the arm can go best
rates = np.round(answers[best], 12) + 0.0

dt = 0.01
gone = (arm.fk(theta + dt * rates) - g)[:3, 3]

# %%
guide.table(
    ["joint", "rate"],
    [
        [f"`{name}`", f"{x:.4f} m/s" if unit == "m" else f"{np.degrees(x):.2f}°/s".replace("-", "−")]
        for name, x, unit in zip(arm.joint_names, rates, arm.units, strict=True)
    ],
    f"Five centimetres a second along the base's ${'xyz'[best]}$ axis.",
)
closed = [i for i in range(3) if missed[i] > 1e-6]
guide.say(
    f"Let them run for a hundredth of a second: forward kinematics finds the tool {1000 * gone[best]:.3f} mm farther "
    f"along ${'xyz'[best]}$, of {1000 * dt * wishes[best][best]:.3f} mm that were wished. The next hundredth needs a "
    f"new Jacobian, for the axes have moved. "
    + (
        f"Along {' and '.join(f'${chr(120 + i)}$' for i in closed)} this arm cannot go here as wished: the best rates "
        f"miss by {', '.join(f'{missed[i] * 1000:.1f}' for i in closed)} mm/s. The next lesson says why."
        if closed
        else "The tool may turn on the way, because nothing was said about that. To forbid it, ask for all six rows."
    )
)

# %% [markdown]
# ## The transpose holds the load
#
# The tool exerts a force $f$ and a torque $\tau$ on the world: a **wrench** $F_t = (f, \tau)$, in the tool's axes. Its
# power is $F_t^T V^b$. No power is lost in the joints, so the motors must supply as much at all rates:
#
# $$\tau^T \dot\theta = F_t^T V^b = F_t^T J^b \dot\theta \quad\text{for every } \dot\theta, \qquad\text{hence}\qquad
# \tau = (J^b)^T F_t$$
#
# (MLS, section 3.4.2; on the left, $\tau$ are the torques of the joints, forces for those that slide.) With a wrench
# that is seen from the base it is $\tau = (J^s)^T F_s$. Nothing is inverted. The formula holds in every configuration
# and for any number of joints.
#
# A stone of one kilogram hangs at the tool's origin. The tool carries it, which means that it pushes it **up**.

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
    "Which joint of your arm bears most of that kilogram, as it waits? And which bears nothing?",
    (
        f"Most: `{arm.joint_names[heaviest]}`, with {abs(torques[heaviest]):.2f} {unit}. Nothing: "
        + (
            ", ".join(f"`{n}`" for n, t in zip(arm.joint_names, torques, strict=True) if abs(t) < 1e-6)
            or "none"
        )
        + ". About a level axis a joint bears the weight times the horizontal distance of the tool from "
        "the axis; about a vertical one, nothing."
        if abs(torques[heaviest]) > 1e-6
        else "None of them bears anything: every axis stands so that the weight cannot drive it. The bearings carry "
        "all."
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
        + " $(J^b)^T F = 0$. No motor holds against such a wrench, because the structure carries it, and no motor can "
        "bring one about."
        if free
        else "So every wrench asks something of some motor, and the motors together can exert any wrench."
    )
)

# %%
guide.scene(
    arm,
    theta,
    caption="The axes are the columns of the spatial Jacobian. Move a joint: which axes come along, which stay?",
    quantity="screws",
)
guide.predict(
    "Which axes came along?",
    "Those of the joints after it, and the tool. Its own axis stays, and so do those before it: column $i$ depends on "
    "the joints before $i$ alone.",
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **The wrong Jacobian.** $v$ of $J^s$ is taken for the velocity of the tool. A tool that should only turn then
#   wanders off, the more so the farther it is from the base.
# - **Columns from the photograph.** The twists at zero are used as columns. At zero everything is right; anywhere else
#   the arm drifts.
# - **The wrench in other axes.** A force measured in axes of the base goes into $(J^b)^T$. It fits as long as the tool
#   is not turned.
# - **The torque first.** Another library writes $(\omega, v)$ and $(\tau, f)$. The shapes fit, and nothing warns you.
# - **The sign.** $F$ is what the tool exerts. A force sensor at the wrist often reports what the world exerts on the
#   tool: then the motors push the wrong way.

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
    ["slip", "off by"],
    slips,
    f"On `{arm.name}`, waiting; slides at 0.1 m/s, turns at 0.3 rad/s; the stone of one kilogram.",
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_3_2_jacobian")
