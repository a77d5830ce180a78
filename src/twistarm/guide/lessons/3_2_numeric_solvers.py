# %% [markdown]
# # Walking to the target
#
# The closed form needs axes that meet or are parallel. Your bracket holds one axis three millimetres beside the others,
# and the formulas no longer apply. The numeric method works for every arm. It does what you would do with a joystick.
# Look how far the tool is off. Find out what a small turn of each joint does. Make the move that should close the gap.
# Look again.
#
# This lesson writes that solver in ten lines, shows where it fails, and repairs it with one number. Each step has a
# number to check.

# %%
import numpy as np

from twistarm import Approach, Pose, Position, guide, screws, solve_ik

arm = guide.arm()
planar = guide.bundled("rr_planar")  # the two-link arm

# %% [markdown]
# ## What a small turn of each joint does
#
# Take the two-link arm first. Its tip is at
#
# $$x = l_1 \cos\theta_1 + l_2 \cos(\theta_1 + \theta_2), \qquad y = l_1 \sin\theta_1 + l_2 \sin(\theta_1 + \theta_2)$$
#
# Turn the joints by the small angles $\Delta_1$ and $\Delta_2$. The tip then moves by the derivatives times these angles:
#
# $$\begin{bmatrix} \Delta x \\ \Delta y \end{bmatrix} \approx J \begin{bmatrix} \Delta_1 \\ \Delta_2 \end{bmatrix}, \qquad
#   J = \begin{bmatrix} -y & -l_2 \sin(\theta_1 + \theta_2) \\ x & l_2 \cos(\theta_1 + \theta_2) \end{bmatrix}$$
#
# Such a matrix is called a **Jacobian**. It has a column for each joint: what that joint does alone, at a rate of one.
#
# For a whole arm the columns are twists. Column $i$ of the **body Jacobian** $J^b(\theta)$ is the twist $(v, \omega)$
# of joint $i$ in that configuration, seen from the tool. All rates together give the body twist of the tool, $V^b =
# J^b(\theta)\,\dot\theta$. Source: Murray, Li and Sastry, *A Mathematical Introduction to Robotic Manipulation* (MLS),
# section 3.4.1. `arm.body_jacobian` computes it. [The lesson on the Jacobian](3_3_2_jacobian.html) derives the columns.

# %%
l2 = np.linalg.norm(np.diff(guide.arm_points(planar, np.zeros(2))[2:], axis=0))


def tip_jacobian(theta):
    """The matrix J above, (2, 2)."""
    x, y = planar.fk(theta)[:2, 3]
    return np.array([[-y, -l2 * np.sin(theta.sum())], [x, l2 * np.cos(theta.sum())]])


theta, h = np.radians([20.0, 60.0]), 1e-6
small = np.radians([0.0, 1.0])  # the elbow alone
predicted = 1000 * np.linalg.norm(tip_jacobian(theta) @ small)
made = 1000 * np.linalg.norm((planar.fk(theta + small) - planar.fk(theta))[:2, 3])
guide.say(
    f"Bend the elbow of the two-link arm from 60° to 61°. The second column times 1° predicts {predicted:.3f} "
    f"mm for the tip, and forward kinematics gives {made:.3f} mm."
)

# %% [markdown]
# ## The error twist
#
# The tool is at $g$ and should be at $g_d$. Seen from the tool, the motion from one to the other is $g^{-1} g_d$. Every
# motion is a screw motion. Its logarithm is the matrix of a twist, as [the lesson on
# twists](2_2_2_twists_and_screws.html) shows. The sign $\vee$ is the inverse of the hat: it takes the six numbers $(v,
# \omega)$ out of the matrix. We call this twist the *gap*.
#
# $$e = \big(\log(g^{-1} g_d)\big)^\vee$$
#
# Follow this twist for one unit of time to reach the target: $g\,e^{\hat e} = g_d$.


# %%
def nimble(arm, theta):
    """The least singular value of the directions that the arm has at all. Lengths are shares of the reach."""
    sigma = np.linalg.svd(
        arm.body_jacobian(theta) / np.repeat([arm.reach, 1.0], 3)[:, None], compute_uv=False
    )
    return sigma[sigma > 1e-9][-1]


rng = np.random.default_rng(3)
goals = [arm.ready + 0.3 * (arm.random_theta(rng) - arm.ready) for _ in range(40)]
goal = max(goals, key=lambda theta: nimble(arm, theta))
g_d = arm.fk(goal)
scale = np.where(np.array(arm.units) == "rad", 0.25, 0.1 * arm.reach)
start = goal + scale * rng.uniform(-1, 1, arm.n)
gap = screws.log(screws.inverse(arm.fk(start)) @ g_d)
guide.say(
    f"`{arm.name}` is a little off its goal. Seen from its tool the gap is $v = {guide.tex(1000 * gap[:3], 1)}$ mm "
    rf"and $\omega = {guide.tex(np.degrees(gap[3:]), 1)}°$. In all the tool has to turn by "
    f"{np.degrees(np.linalg.norm(gap[3:])):.1f}°."
)

# %% [markdown]
# ## Least squares
#
# Which step $\Delta$ of the joints closes a gap? The equation $J\Delta = e$ seldom has exactly one answer. With too few
# joints it has none: take the $\Delta$ for which $J\Delta$ comes nearest to $e$. With more joints than necessary it has
# many: take the shortest. Both are called **least squares**, because the distances are sums of squares.
# `np.linalg.lstsq` finds this step.

# %% tags=["shown"]
one_slide = np.linalg.lstsq([[1.0], [0.0]], [30.0, 40.0])[0]  # along x, for a gap of (30, 40) mm
two_slides = np.linalg.lstsq([[1.0, 1.0]], [30.0])[0]  # both along x, for a gap of 30 mm

# %%
guide.say(
    f"One slide along $x$, asked for $(30, 40)$ mm, moves {one_slide[0]:.0f} mm. It cannot move along $y$, so "
    f"40 mm remain. Two slides along $x$, asked for 30 mm, move {two_slides[0]:.0f} mm each: of all pairs "
    f"with the sum 30 this has the least sum of squares."
)

# %% [markdown]
# ## Newton's step
#
# Now combine both. Take the step that would close the gap if the Jacobian did not change on the way:
#
# $$J^b(\theta)\,\Delta = e, \qquad \theta \leftarrow \theta + \Delta$$
#
# Take the least-squares answer, make the step, and compute the gap again. This is Newton's method (Lynch & Park,
# section 6.2).


# %% tags=["shown"]
def newton_step(J, e):
    """The shortest step that closes the gap best."""
    return np.linalg.lstsq(J, e, rcond=1e-9)[0]


def walk(arm, g_d, theta, step, count):
    """The gap before each step, (count + 1, 6), and where the walk ends."""
    gaps = []
    for _ in range(count + 1):
        e = screws.log(screws.inverse(arm.fk(theta)) @ g_d)
        gaps.append(e)
        end, theta = theta, theta + step(arm.body_jacobian(theta), e)
    return np.array(gaps), end


# %%
def size(arm, gaps):
    """The gaps as one number each: metres in shares of the arm's reach, and radians."""
    scaled = np.asarray(gaps) / np.repeat([arm.reach, 1.0], 3)
    return np.linalg.norm(scaled, axis=-1)


gaps, reached = walk(arm, g_d, start, newton_step, 8)
rows = []
for i, (e, s) in enumerate(zip(gaps[:6], size(arm, gaps), strict=False)):
    metres, radians = np.linalg.norm(e.reshape(2, 3), axis=1)
    both = f"${guide.rough(max(s, 1e-16))}$"
    rows.append([str(i), f"{1000 * metres:.6f} mm", f"{np.degrees(radians):.6f}°", both])
guide.table(
    ["steps taken", "the tool is off by", "and by", "both in one number"],
    rows,
    f"Newton's steps of `{arm.name}` to a pose, from a configuration nearby. The last column counts lengths "
    f"as shares of its reach.",
)
guide.predict(
    "Look at the exponents in the last column. What does each step do to the number of correct digits?",
    "Once the gap is small, each step doubles them, down to rounding. An error $\\varepsilon$ becomes about "
    "$c\\,\\varepsilon^2$. "
    f"From a gap of ${guide.rough(size(arm, gaps)[1])}$ after one step it takes "
    f"{int(np.argmax(size(arm, gaps) < 1e-9)) - 1} more to pass $10^{{-9}}$.",
)

# %% [markdown]
# ## What each direction costs
#
# In some directions a small turn of the joints moves the tip far. In others the joints must turn a lot. The **singular
# values** of $J$ measure this: a metre costs $1/\sigma$ radians. Let the pair of joint rates go round a circle of
# radius one. $J$ maps this circle to an ellipse of tip velocities. The half axes of the ellipse are the singular values
# $\sigma_1 \ge \sigma_2$, the greatest and the least speed. `np.linalg.svd` computes them.

# %%
stretched = np.radians([20.0, 2.0])
sigma = np.linalg.svd(tip_jacobian(stretched), compute_uv=False)
guide.say(
    f"Take the two-link arm almost stretched out, its elbow bent by 2°: $\\sigma_1 = {sigma[0]:.3f}$ m and "
    f"$\\sigma_2 = "
    f"{sigma[1]:.4f}$ m per radian. A millimetre across the arm costs {np.degrees(1e-3 / sigma[0]):.2f}° of the joints "
    f"together, a millimetre along it {np.degrees(1e-3 / sigma[1]):.1f}°."
)

bends = np.radians(np.arange(1.0, 180.0))
at_bends = np.array([tip_jacobian(np.array([0.0, bend])) for bend in bends])
weaker = np.linalg.svd(at_bends, compute_uv=False)[:, 1]
nimblest = np.degrees(bends[np.argmax(weaker)])
guide.slider(
    "ellipsoid",
    r"This is the ellipse of the tip's velocities for $\dot\theta_1^2 + \dot\theta_2^2 = 1$. Where is the smaller "
    r"singular value $\sigma_2$ largest?",
    rf"At $\theta_2 = {nimblest:.0f}°$, with the tool close to the base. At 0° and 180° the ellipse is a line: "
    r"$\det J = l_1 l_2 \sin\theta_2 = 0$.",
    l1=0.4,
    l2=0.3,
    theta1=20,
    theta2=20,
)

# %% [markdown]
# ## Where Newton's method fails
#
# The arm is almost stretched out, and its tip shall come a little closer. Joint rates hardly move the tip along the
# arm. Only one combination of rates does, and its effect is small. So Newton's step contains very much of this
# combination.

# %%
tip = planar.fk(stretched)[:2, 3]
goal_2 = 0.9 * tip  # closer, on the same line


def tip_gap(theta):
    """The gap of the tip (2,), and the Jacobian (2, 2) of the tip's place."""
    return goal_2 - planar.fk(theta)[:2, 3], tip_jacobian(theta)


e, J = tip_gap(stretched)
leap = newton_step(J, e)
guide.predict(
    f"The tip shall come {1000 * np.linalg.norm(e):.0f} mm closer, and the elbow is bent by 2°. How far does "
    "Newton turn the elbow in its first step?",
    f"By {np.degrees(leap[1]):.0f}°. Along the arm the step is the gap divided by $\\sigma_2 = "
    f"{sigma[1]:.4f}$. It grows without bound as the elbow comes nearer to 0°. *At* 0° no joint moves the tip "
    f"along the arm. Least squares then returns a step of zero, and the arm is stuck.",
)

# %% [markdown]
# ## Damping
#
# Find a compromise between the gap that remains and the size of the step. The **damping** $\lambda$ is the weight of
# the step:
#
# $$\min_\Delta\; \|J\Delta - e\|^2 + \lambda^2 \|\Delta\|^2$$
#
# At the minimum the derivative is zero: $J^T (J\Delta - e) + \lambda^2 \Delta = 0$. Solve for the step:
#
# $$\Delta = (J^T J + \lambda^2 I)^{-1} J^T e = J^T (J J^T + \lambda^2 I)^{-1} e$$
#
# Along a direction with the singular value $\sigma$ Newton multiplies the gap by $1/\sigma$. This step multiplies it by
# $\sigma / (\sigma^2 + \lambda^2)$, which is never more than $1/(2\lambda)$. It is called **damped least squares**
# (Nakamura & Hanafusa 1986, Wampler 1986). The damping has a unit: $\lambda$ is compared with $\sigma$, so here it is
# in metres (per radian).

# %%
guide.say(
    f"For the stretched arm $1/\\sigma_2 = {1 / sigma[1]:.0f}$. With $\\lambda = 0.05$ m the factor is "
    f"{sigma[1] / (sigma[1] ** 2 + 0.05**2):.1f}; for the direction of $\\sigma_1$ it is "
    f"{sigma[0] / (sigma[0] ** 2 + 0.05**2):.3f} instead of {1 / sigma[0]:.3f}, almost the same."
)


# %% tags=["shown"]
def damped_step(J, e, damping):
    """The step that weighs what is left of the gap against its own size."""
    return J.T @ np.linalg.solve(J @ J.T + damping**2 * np.eye(len(J)), e)


MOST = 200  # steps


def steps_to_arrive(damping, most=MOST):
    """How many steps bring the two-link arm within a tenth of a millimetre, or None."""
    theta = stretched
    for count in range(most + 1):
        e, J = tip_gap(theta)
        if np.linalg.norm(e) < 1e-4:
            return count
        theta = theta + damped_step(J, e, damping)
    return None


# %%
dampings = np.geomspace(1e-3, 1.0, 61)
first = np.array([damped_step(J, e, d) for d in dampings])
left = np.array([np.linalg.norm(tip_gap(stretched + step)[0]) for step in first])
needed = [steps_to_arrive(d) for d in dampings]
arrived = np.array([np.nan if count is None else count for count in needed])
best = int(np.nanargmin(arrived))
fig, panels = guide.axes2(columns=3, width=6.6, height=2.7, xlabel="damping λ [m]")
panels[0].loglog(dampings, np.degrees(np.linalg.norm(first, axis=1)))
panels[0].axhline(180, color=guide.GREY, linewidth=0.8, linestyle=":")
panels[0].set_title("size of the first step [°]")
panels[1].semilogx(dampings, 1000 * left, color=guide.ORANGE)
panels[1].axhline(1000 * np.linalg.norm(e), color=guide.GREY, linewidth=0.8, linestyle=":")
panels[1].set_title("gap after it [mm]")
panels[2].loglog(dampings, arrived, color=guide.GREEN, linestyle="-", marker=".", markersize=3)
panels[2].set_title("steps to arrive")
guide.figure(
    fig,
    "Three curves against the damping: the size of the first step falls steadily; the gap after it is large on "
    "the left, least in the middle and as large as before on the right; the steps needed are irregular on the left, "
    "fewest in the middle and grow on the right",
    "A sweep of the damping near the stretched arm. Dotted: half a turn, and the gap before the step. With "
    "too little damping the steps are wild, with too much they are tiny.",
)
crawl = f"{MOST} steps are not enough" if needed[-1] is None else f"it takes {needed[-1]}"
guide.say(
    f"The best damping of the sweep, {dampings[best]:.3f} m, needs {needed[best]} steps. With the largest, "
    f"{dampings[-1]:.0f} m, {crawl}."
)

# %% [markdown]
# Far from the target you want much damping. Near it you want none, because damping spoils Newton's doubling of digits.
# So let it shrink with the gap: $\lambda^2 = c\,\|e \|^2$ (Chan & Lawrence 1988). twistarm does the same.
#
# ## Out of reach
#
# The difference is clearest if there is no answer. Now the target is farther away than the stretched arm reaches.

# %%
too_far = 1.15 * tip / np.linalg.norm(tip) * planar.reach


def gaps_beyond(step):
    """The gaps of forty steps towards the target beyond reach."""
    theta, gaps = np.radians([60.0, 50.0]), []
    for _ in range(40):
        e = too_far - planar.fk(theta)[:2, 3]
        gaps.append(np.linalg.norm(e))
        theta = theta + step(tip_jacobian(theta), e)
    return np.array(gaps)


by_newton = gaps_beyond(newton_step)
by_damped = gaps_beyond(lambda J, e: damped_step(J, e, np.linalg.norm(e)))
least = np.linalg.norm(too_far) - planar.reach  # the arm stretched out towards it

# %%
fig, ax = guide.axes2(xlabel="step", ylabel="gap [m]", height=2.8)
ax.plot(by_newton, label="Newton")
ax.plot(by_damped, label="damped, λ = ‖e‖")
ax.axhline(least, color=guide.INK, linewidth=1.0, linestyle=":", label="the least there is")
ax.legend(loc="upper right", ncols=3)
ax.set_ylim(0, 1.25 * by_newton.max())
guide.figure(
    fig,
    "The gap over forty steps: Newton's jumps up and down without end, the damped one falls and stays near the dotted "
    "line of the least possible gap",
    "A target beyond reach. Newton never comes to rest; damped least squares stretches the arm towards it.",
)

# %% [markdown]
# ## Five joints
#
# A pose is six numbers, and five joints can meet at most five of them. The rank of the Jacobian, the number of its
# independent columns, says how many. So with five joints ask for less. A **position** has three numbers. An
# **approach** has five: the position and the direction in which the tool points. The roll about that direction is free.
#
# To leave a number free, leave its row out of $J$ and $e$. For that, write the rows in axes of which one is the free
# direction. Seen from a tool that points along its own $z$ axis, the roll is $\omega_z$, the last row.

# %%
few = guide.arm_with("three to five joints", lambda a: 3 <= a.n <= 5)
waiting = few.ready + 0.2 * (few.random_theta(1) - few.ready)
waiting = np.clip(waiting, few.limits.lower, few.limits.upper)
g = few.fk(waiting)
turn = np.array([0, 0, 0, 0.2, -0.15, 0.25])
g_wanted = g @ screws.exp(turn, 1.0)  # the same place, turned a little
targets = {
    "`Pose`, 6 numbers": Pose(g_wanted),
    "`Approach`, 5 numbers": Approach(g_wanted[:3, 3], g_wanted[:3, :3] @ few.tool_axis),
    "`Position`, 3 numbers": Position(g_wanted[:3, 3]),
}
answers = {words: solve_ik(few, target, waiting) for words, target in targets.items()}

# %%
roll = np.append([0, 0, 0], few.tool_axis)
samples = [
    few.body_jacobian(theta) / np.repeat([few.reach, 1.0], 3)[:, None]
    for theta in few.random_theta(0, 8)
]
rank, without = (
    max(int(np.linalg.matrix_rank(rows @ J, tol=1e-6)) for J in samples)
    for rows in (np.eye(6), np.eye(6) - np.outer(roll, roll))
)
rolls = [  # joints that turn the tool about its own direction, and do nothing else
    name
    for name, column in zip(few.joint_names, samples[0].T, strict=True)
    if np.allclose(column, (column @ roll) * roll, atol=1e-6) and abs(column @ roll) > 0.5
]
sentences = [
    f"`{few.name}` has {few.n} joints; the rank of its Jacobian is {rank} at best. Without the row of the roll it is "
    f"{without}."
]
if few.n == 5 and without < 5:
    sentences += [
        f"`{name}` only turns the tool about its own direction, so it changes none of the five numbers of an approach."
        for name in rolls[:1]
    ]
    sentences.append(
        "This arm reaches an approach only at some places. Five joints are not enough: their columns must be "
        "independent without the roll."
    )
guide.say(" ".join(sentences))
off = {
    words: [f"{1000 * answer.position_error:.2f}", f"{np.degrees(answer.orientation_error):.2f}"]
    for words, answer in answers.items()
}
guide.table(
    ["asked", "off by [mm]", "off by [°]", "the solver says"],
    [[words, *off[words], answer.stop.value] for words, answer in answers.items()],
    "The same place with the tool turned a little, as three kinds of target.",
)
pose, approach = answers["`Pose`, 6 numbers"], answers["`Approach`, 5 numbers"]
if pose.converged:
    guide.say("This arm reaches even the pose.")
elif approach.converged:
    guide.say("The arm reaches the approach, but not the pose: only the roll is wrong.")
else:
    guide.say(
        f"The arm does not reach even the approach here. The reason:\n\n```text\n{approach.explain()}\n```"
    )

# %% [markdown]
# ## What solve_ik says when it cannot
#
# `solve_ik` is such a damped solver, from many starts, inside the limits. It always returns a configuration. If it
# cannot reach the target, it returns the configuration that comes nearest (position first) and the reason:

# %%
beyond = arm.fk(arm.ready).copy()
beyond[:3, 3] += np.array([3.0, 0.5, 0.2]) * arm.reach
far = solve_ik(arm, Position(beyond[:3, 3]))
cases = [] if far.converged else [("a place far outside", far)]  # slides without limits reach it
for k in np.flatnonzero(np.isfinite(arm.limits.upper)):
    over = arm.ready.copy()
    over[k] = arm.limits.upper[k] + (0.4 if arm.units[k] == "rad" else 0.2 * arm.reach)
    blocked = solve_ik(arm, Pose(arm.fk(over)))
    if blocked.stop.name == "BLOCKED_BY_LIMITS":
        cases.append((f"a pose for which `{arm.joint_names[k]}` must leave its limits", blocked))
        break
turned = arm.fk(goal) @ screws.exp(np.array([0, 0, 0, 0.3, 0.2, 0.1]), 1.0)
if arm.n < 6:
    cases.append(("the tool turned where the arm cannot turn it", solve_ik(arm, Pose(turned), goal)))
cases.append(("the pose of one of its configurations", solve_ik(arm, Pose(g_d))))
guide.table(
    ["asked", "`stop`", "in words"],
    [[words, f"`{answer.stop.name}`", answer.stop.value] for words, answer in cases],
    f"Asked of `{arm.name}`.",
)
guide.say("And `explain()` of the first:\n\n```text\n" + cases[0][1].explain() + "\n```")

# %% [markdown]
# If you need an exact answer, call `solution.require()`. It returns $\theta$, or raises an error with the reason. If
# you read `theta` without `converged`, the arm may drive to the wrong place.
#
# ## What goes wrong in practice
#
# - **The gap and the Jacobian seen from different frames.** The gap is in base axes, and the Jacobian is that of the
#   body. Each step is then turned by the tool's rotation. The solver converges slowly or not at all.
# - **A start that is exactly singular.** An arm that is stretched out at zero and shall come straight in gets a zero
#   step, with or without damping. Bend it a little first.
# - **Degrees in the step.** The Jacobian is per radian.
# - **Metres against radians.** To add both, choose a length that is worth a radian. Damping that is right in metres is
#   a thousand times too weak in millimetres.
# - **One start.** The steps go downhill, and may end in the wrong valley. Then start again elsewhere. A solution
#   reports its `restarts`.
# - **Limits clipped at the end.** An answer that is clipped afterwards misses the target. Keep the limits at every
#   step.


# %%
def mixed_up(theta, count=8):
    """Newton with the gap seen from the base and the body Jacobian."""
    for _ in range(count):
        e = screws.log(g_d @ screws.inverse(arm.fk(theta)))
        theta = theta + newton_step(arm.body_jacobian(theta), e)
    return size(arm, screws.log(screws.inverse(arm.fk(theta)) @ g_d))


def in_degrees(theta):
    """One step with its angles turned into degrees before they are added."""
    e = screws.log(screws.inverse(arm.fk(theta)) @ g_d)
    factor = np.where(np.array(arm.units) == "rad", np.degrees(1.0), 1.0)
    g = arm.fk(theta + factor * newton_step(arm.body_jacobian(theta), e))
    return size(arm, screws.log(screws.inverse(g) @ g_d))


guide.table(
    ["steps", "gap at the end"],
    [
        ["as above, eight steps", f"${guide.rough(max(size(arm, gaps)[-1], 1e-16))}$"],
        ["gap from the base, Jacobian from the tool, eight steps", f"${guide.rough(mixed_up(start))}$"],
        ["degrees in the step, one step", f"${guide.rough(in_degrees(start))}$"],
        ["before the first step", f"${guide.rough(size(arm, gaps)[0])}$"],
    ],
    f"On `{arm.name}`; lengths in shares of its reach.",
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_2_numeric_solvers")
