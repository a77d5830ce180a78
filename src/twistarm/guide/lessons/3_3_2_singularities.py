# %% [markdown]
# # Why does the arm get stuck when it is stretched out?
#
# You drive the tool outward with the joystick, slowly and straight. All is well until the arm is nearly straight. Then
# the elbow motor runs at full speed, and the tool hardly moves. You look for a loose wire and find none. The arm is
# near a **singular configuration**, and its Jacobian shows the reason.

# %%
import numpy as np
from scipy.optimize import minimize

from twistarm import guide, screws

arm = guide.arm()
theta = arm.ready

# %% [markdown]
# ## The law
#
# The columns of $J(\theta)$ are the twists of the joints. Every velocity of the tool is a sum of their multiples. If
# the columns are no longer independent, a direction is missing among these sums. A configuration is **singular** if the
# rank of $J(\theta)$ is smaller there than elsewhere. Source: Murray, Li and Sastry, *A Mathematical Introduction to
# Robotic Manipulation* (MLS), section 3.4.3. You can take either Jacobian: $J^s$ and $J^b$ differ by an Adjoint, which
# has an inverse.
#
# Begin with two links in a plane and the position of the tool alone. The Jacobian is then $2 \times 2$. Its determinant
# is
#
# $$\det J = l_1 l_2 \sin\theta_2$$

# %% tags=["shown"]
planar = guide.bundled("rr_planar")
elbow_at = screws.to_screw(planar.screws[:, 1]).point
l1 = float(np.linalg.norm(elbow_at - screws.to_screw(planar.screws[:, 0]).point))
l2 = float(np.linalg.norm(planar.home[:3, 3] - elbow_at))

bends = np.radians(np.linspace(-179, 179, 359))
configurations = np.stack([0.4 + 0 * bends, bends], axis=-1)
J = planar.hybrid_jacobian(configurations)[:, :2]  # x and y of the tool's origin

# %%
guide.predict(
    r"For which angles is this arm singular? And does $\theta_1$ matter?",
    r"At $\theta_2 = 0$, stretched, and at $\theta_2 = 180°$, folded. $\theta_1$ does not matter: it turns "
    r"the whole arm. Whether an arm is singular depends on how its axes lie relative to each other. The first "
    r"joint never changes that.",
)
guide.slider(
    "ellipsoid",
    r"You met this ellipse in *Walking to the target*: the velocities that the tool gets from joint rates with "
    r"$|\dot\theta| = 1$. Bring $\theta_2$ to 0. What happens to it, and in which direction can the tool no "
    r"longer have a velocity?",
    r"It becomes a line, at a right angle to the arm: $\sigma_2 = 0$. At this instant both joints move the tool "
    "only sideways: its velocity along the arm is zero, whatever their rates. This holds inward too, although "
    "there is room. Bend the elbow at a constant rate, and the tool starts inward from rest. No rates give it 5 cm/s "
    "at once.",
    l1=round(l1, 3),
    l2=round(l2, 3),
    theta1=25,
    theta2=70,
)

# %% [markdown]
# ## What the elbow must do
#
# Let the tool move outward at five centimetres per second, along the line from the base. From the law of cosines,
# $r^2 = l_1^2 + l_2^2 + 2 l_1 l_2 \cos\theta_2$, and therefore
#
# $$\dot\theta_2 = -\frac{r\, \dot r}{l_1 l_2 \sin\theta_2}$$
#
# If $\theta_2$ is small, the rate is large.

# %%
outward = 0.05
nearly = np.radians(np.array([90.0, 30.0, 10.0, 3.0, 1.0]))
rates = []
for bend in nearly:
    at = np.array([0.0, bend])
    tool = planar.fk(at)[:2, 3] - screws.to_screw(planar.screws[:, 0]).point[:2]
    r = np.linalg.norm(tool)
    rate = np.linalg.solve(planar.hybrid_jacobian(at)[:2], outward * tool / r)
    rates.append(abs(float(np.degrees(rate[1]))))
guide.table(
    ["elbow still bent by", "it must turn at"],
    [[f"{np.degrees(bend):.0f}°", f"{rate:.0f}°/s"] for bend, rate in zip(nearly, rates, strict=True)],
    f"Outward at {100 * outward:.0f} cm/s with links of {l1:g} m and {l2:g} m.",
)

# %% [markdown]
# ## How far from singular: the ellipsoid
#
# The rank says only whether a configuration is singular. The ellipse says how near it is. With more joints and
# directions it becomes the **manipulability ellipsoid**: the velocities $J\dot\theta$ for all joint rates with
# $|\dot\theta| = 1$ (MLS, section 3.4.4).
#
# The **singular value decomposition** gives its half axes. It splits any matrix into three simple ones:
#
# $$J = U\, \Sigma\, W^T$$
#
# Read it from the right, as it acts on joint rates $\dot\theta$:
#
# - $W^T$ turns. The columns $w_1, w_2, \dots$ of $W$ are sets of joint rates, of length one and at right angles to each
#   other. (Most books write $V$ for $W$, but $V$ is a velocity here.)
# - $\Sigma$ stretches. It is diagonal and holds the singular values $\sigma_1 \ge \sigma_2 \ge \dots \ge 0$.
# - $U$ turns again. Its columns $u_1, u_2, \dots$ are directions of the tool, of length one and at right angles to each
#   other.
#
# For each column this says $J w_i = \sigma_i u_i$: the joint rates $w_i$ move the tool along $u_i$, at the speed
# $\sigma_i$. So the half axes of the ellipsoid are $\sigma_i u_i$. `np.linalg.svd` returns $U$, the singular values and
# $W^T$.
#
# Along a long half axis the tool is fast and weak: by $\tau = J^T F$, a unit of joint torque balances the force
# $1/\sigma$ there. Along a short half axis it is slow and strong. The product of all singular values, $\sqrt{\det
# JJ^T}$, is Yoshikawa's **manipulability**. The ratio $\sigma_{\max}/\sigma_{\min}$ is the **condition number**. It is
# one for a sphere, and infinite if a direction is lost.

# %%
fig, axes = guide.axes2(3, width=6.6, height=2.6)
turn = np.linspace(0, 2 * np.pi, 200)
circle = np.array([np.cos(turn), np.sin(turn)])
for ax, bend in zip(axes, (90.0, 30.0, 0.0), strict=True):
    at = np.radians([30.0, bend])
    line = guide.arm_points(planar, at)[1:, :2]
    ellipse = line[-1][:, None] + 0.35 * planar.hybrid_jacobian(at)[:2] @ circle
    ax.plot(*line.T, color=guide.INK, linewidth=3.5, linestyle="-", solid_capstyle="round")
    ax.plot(*line[:-1].T, "o", color=guide.BLUE, markersize=6, linestyle="none")
    ax.plot(*ellipse, color=guide.ORANGE, linestyle="-")
    number = np.linalg.cond(planar.hybrid_jacobian(at)[:2])
    ax.set_title(
        rf"$\theta_2 = {bend:.0f}°$" + "\ncondition " + (f"{number:.1f}" if number < 1e6 else "∞")
    )
    ax.set(xlim=(-0.35, 1.05), ylim=(-0.3, 0.95), xticks=[], yticks=[], aspect="equal")
guide.figure(
    fig,
    "The two-link arm with its elbow bent by 90, by 30 and by 0 degrees; the ellipse at its tool gets "
    "thinner. For the straight arm it is a line at a right angle to the arm",
    "The velocities of the tool that joint rates with $|\\dot\\theta| = 1$ give, as the arm is stretched.",
)

# %% [markdown]
# ## Rates that cancel
#
# Stretch the two links out. The last singular value is then $\sigma_2 = 0$. It has two columns, $w_2$ and $u_2$. Take
# $w_2$ first:
#
# $$J w_2 = \sigma_2 u_2 = 0$$
#
# With these joint rates the motors run, but the tool does not move. $w_2$ is called a **null vector** of $J$.

# %%
straight = np.array([0.0, 0.0])
J = planar.hybrid_jacobian(straight)[:2]
U, sigma, Wt = np.linalg.svd(J)
null = Wt[1] * np.sign(Wt[1, 1])
guide.say(
    f"Here $w_2 = {guide.tex(null, 2)}$. Let the shoulder turn at {null[0]:.2f} rad/s".replace("-", "−")
    + f" and the elbow at {null[1]:.2f} rad/s: the tool moves at {np.linalg.norm(J @ null):.2f} m/s. The "
    f"first column alone would give {abs(J[1, 0] * null[0]):.2f} m/s, and the second column cancels it."
)

# %% [markdown]
# ## A force that no motor feels
#
# Now read $u_2$ as a force at the tool. By $\tau = J^T F$ the motors hold
#
# $$\tau = J^T u_2 = \sigma_2 w_2 = 0$$
#
# Pull along the stretched arm: the bearings carry the pull, and the motors need no torque. Pull across the arm: the
# motors must hold.

# %%
along, across = 10.0 * np.array([1.0, 0.0]), 10.0 * np.array([0.0, 1.0])  # [N]
guide.table(
    ["10 N at the tool", "the shoulder holds", "the elbow holds"],
    [
        [words, *(f"{abs(torque):.1f} N m" for torque in J.T @ F)]
        for words, F in (("along the arm", along), ("across the arm", across))
    ],
    f"Two links of {l1:g} m and {l2:g} m, stretched out along $x$.",
)

# %% [markdown]
# ## Reciprocal wrenches
#
# Power is force times velocity. The force $u_2$ has no power in any motion that the joints can make:
#
# $$u_2^T (J \dot\theta) = (J^T u_2)^T \dot\theta = 0 \quad\text{for every } \dot\theta$$
#
# Such a force, or wrench, is called **reciprocal** to the joints (MLS, section 2.5.3). It shows what is lost: the
# joints cannot make any velocity $V$ in which the wrench has power, $F^T V \ne 0$. In millimetres the same wrench is
# reciprocal.

# %%
inward = np.array([-0.05, 0.0])  # [m/s]
guide.say(
    f"Let both joints turn at 1 rad/s: the pull along the arm has the power {abs(along @ J @ np.ones(2)):.1f} "
    f"W. A velocity of 5 cm/s inward against it would need {abs(along @ inward):.1f} W. No motor can supply "
    f"this power here, so the tool cannot have this velocity."
)

# %% [markdown]
# ## On your arm: six directions, two units
#
# The whole Jacobian has rows in metres and rows in radians. A sum of squares of both needs a length that is worth one
# radian. `arm.manipulability` measures lengths in units of the arm's reach. The singular values then have no unit, but
# they depend on that choice. Whether one of them is zero does not depend on it.

# %%
slides = np.array(arm.units) == "m"
m = arm.manipulability(theta)
configurations = arm.random_theta(0, 2000)
rank = int(arm.manipulability(configurations).rank.max())  # where the tool moves in most


def least(x):
    """The singular value that reaches zero first."""
    return float(arm.manipulability(x).singular_values[rank - 1])


all_there_are = "the greatest number there is."
if rank < 6:
    all_there_are = (
        f"the most that its joints allow. Of the six, {6 - rank} {'are' if rank < 5 else 'is'} missing in "
        f"*every* configuration. That is not a singularity: {arm.n} joint{'s' if arm.n > 1 else ''} cannot do more."
    )
guide.say(
    rf"`{arm.name}`, ready: $\sigma = {guide.tex(m.singular_values)}$. It can move its tool in {rank} independent "
    f"direction{'s' if rank > 1 else ''}, {all_there_are} The condition of these {rank} is "
    f"{float(m.condition_in(rank)):.1f}."
)

# %%
linear = arm.hybrid_jacobian(theta)[:3] * np.where(slides, arm.reach, 1.0)
U, sigma, _ = np.linalg.svd(linear)
sigma = np.append(sigma, np.zeros(3 - len(sigma)))
around, height = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(0, np.pi, 13))
ball = np.array([np.sin(height) * np.cos(around), np.sin(height) * np.sin(around), np.cos(height)])
size = 0.35 * arm.reach / sigma[0]
surface = arm.fk(theta)[:3, 3, None, None] + size * np.einsum("ij,jkl->ikl", U * sigma, ball)
fig, ax = guide.axes3(width=5.0, height=4.4)
ax.plot_wireframe(*surface, color=guide.ORANGE, linewidth=0.6, alpha=0.7, rstride=2, cstride=2)
guide.plot_arm(ax, arm, theta)
for k in range(3):
    if sigma[k] > 0.02 * sigma[0]:
        guide.plot_vector(ax, arm.fk(theta)[:3, 3], 1.05 * size * sigma[k] * U[:, k], "", guide.ORANGE)
flat = int((sigma > 1e-6 * sigma[0]).sum())
shape = {3: "an ellipsoid", 2: "a flat ellipse", 1: "a line", 0: "a point"}[flat]
guide.figure(
    fig,
    f"{arm.name} as it waits, and at its tool {shape} with its half axes: long where joint rates move the tool far",
    f"The tool's velocities for joint rates with $|\\dot\\theta| = 1$: {shape}, with half axes in the ratio "
    f"{' : '.join(f'{s / sigma[0]:.2f}' for s in sigma[:flat])}.",
)
guide.scene(
    arm, theta, caption="Drag the tool outward: which half axis gets short?", quantity="ellipsoid"
)

# %% [markdown]
# ## The worst configuration inside your limits
#
# Where is your own arm singular? The program takes the worst of two thousand random configurations. From there it
# minimises the last singular value $\sigma$, within the joint limits.

# %%
low, high = arm.sampling_bounds
bounds = list(zip(low, high, strict=True))
worst = configurations[np.argsort(arm.manipulability(configurations).singular_values[:, rank - 1])[:4]]
found = [minimize(lambda x: least(x) ** 2, x, method="L-BFGS-B", bounds=bounds) for x in worst]
singular = min((np.clip(result.x, low, high) for result in found), key=least)

# A whole turn of a joint changes nothing: take the copy inside the limits that is nearest to the ready one.
nearest = singular + 2 * np.pi * np.round((theta - singular) / (2 * np.pi)) * ~slides
nearest = np.where((nearest >= low) & (nearest <= high), nearest, singular)
if np.allclose(arm.fk(nearest), arm.fk(singular)):
    singular = nearest

ratio_there = least(singular) / arm.manipulability(singular).singular_values[0]
is_singular = ratio_there < 1e-4

# %% [markdown]
# As on the two links, read the last columns there. $w$ has the rates that cancel, and $u$ the wrench that no motor
# feels.
#
# In the singular configuration itself several singular values may be 0 at once. Then every mixture of their columns is
# valid, and rounding chooses one. So the program reads both columns slightly beside the configuration.

# %%
lengths = np.where(slides, arm.reach, 1.0)  # slides are counted in units of the reach, too
beside = singular + 0.02 * (theta - singular)
J = arm.body_jacobian(beside) * np.array([1 / arm.reach] * 3 + [1.0] * 3)[:, None] * lengths
U, sigma, Wt = np.linalg.svd(J, full_matrices=False)
lost, idle = U[:, rank - 1], Wt[rank - 1] * lengths

# %%
weights = np.abs(Wt[rank - 1])
against = [name for name, w in zip(arm.joint_names, weights, strict=True) if w > 0.15 * weights.max()]
force, torque = lost[:3], arm.reach * lost[3:]  # J has lengths in units of the reach
turns = bool(np.linalg.norm(lost[3:]) > np.sqrt(0.5))  # the wrench is mostly a torque
push, along_with = (
    ("Twist about", "a force of {} N along") if turns else ("Push along", "a torque of {} N m about")
)
main, other = (torque, force) if turns else (force, torque)
sign = 1.0 if main[np.argmax(np.abs(main))] > 0 else -1.0
axis = sign * main / np.linalg.norm(main)
ratio = sign * other / np.linalg.norm(main)  # for each newton, or newton metre
also = ""
if np.linalg.norm(ratio) > 0.005:
    size = f"{np.linalg.norm(ratio):.2f}"
    also = f", with {along_with.format(size)} ${guide.tex(ratio / np.linalg.norm(ratio), 2)}$ for each {'N m' if turns else 'N'}"


def cell(x, unit, digits):
    number = f"{round(float(x), digits) + 0.0:.{digits}f}".replace("-", "−")
    return f"{number}{unit if unit == '°' else ' ' + unit}"


guide.table(
    ["joint", "ready", "worst", "rates that cancel"],
    [
        [
            f"`{name}`",
            *(cell(x, "m", 3) if slide else cell(np.degrees(x), "°", 1) for x in (a, b)),
            cell(w, "m/s" if slide else "rad/s", 2),
        ]
        for name, slide, a, b, w in zip(arm.joint_names, slides, theta, singular, idle, strict=True)
    ],
    f"The worst configuration that was found inside the limits of `{arm.name}`.",
)
verdict = (
    rf"There $\sigma_{{{rank}}}/\sigma_1 = {guide.rough(ratio_there)}$: singular."
    if is_singular
    else rf"There $\sigma_{{{rank}}}/\sigma_1 = {ratio_there:.3f}$. It is not singular: inside your limits this arm keeps all its directions. That is good, and not every arm does."
)
guide.say(
    f"{verdict} {push} ${guide.tex(axis, 2)}$ in the tool's axes{also}, and "
    + (
        f"no motor feels it: there the tool cannot {'turn' if turns else 'move'}. "
        if is_singular
        else f"the motors feel it least: there the tool can hardly {'turn' if turns else 'move'}. "
    )
    + f"The joints that work against each other: {', '.join(f'`{name}`' for name in against)}."
)

# %%
fig, ax = guide.axes3(width=5.2, height=4.4)
guide.plot_arm(ax, arm, theta, colour=guide.GREY, alpha=0.4, tool=False)
guide.plot_arm(ax, arm, singular)
axes_there = arm.spatial_jacobian(singular)
follows = [int(np.argmax(np.abs(arm.coupling.A[:, k]))) for k in range(arm.n)]
points = guide.arm_points(arm, singular)[1:-1]
for k, name in enumerate(arm.joint_names):
    if name in against:
        guide.plot_screw(ax, axes_there[:, k], 0.5 * arm.reach, near=points[follows[k]])
guide.figure(
    fig,
    f"{arm.name} in its worst configuration, with the axes of the joints that work against each other; behind it, "
    "grey, the configuration in which it waits",
    f"The worst configuration, and the axes of {', '.join(f'`{name}`' for name in against)}. Grey: waiting.",
)
guide.scene(arm, singular, caption="Drag it along the lost direction.", quantity="singular")

# %% [markdown]
# ## Three patterns to know by sight
#
# Three kinds are common (MLS, section 3.4.3). Each is a pattern of axes that you can see:
#
# - **two turning axes on one line**: the first and the last joint of a wrist roll about the same line. If one turns
#   against the other, nothing moves;
# - **three parallel turning axes in one plane**: shoulder, elbow and wrist of a stretched arm. The two links above are
#   such a case, with the tool's point in place of the third axis;
# - **four turning axes through one point**: the wrist's centre lies on the axis of the base.

# %%
rng = np.random.default_rng(3)


def turning(axis, point):
    axis = np.asarray(axis) / np.linalg.norm(axis)
    return np.append(np.cross(point, axis), axis)  # (−ω × q, ω)


def lines(count):
    return [turning(rng.normal(size=3), rng.normal(size=3)) for _ in range(count)]


w, q, d = rng.normal(size=(3, 3))
square = np.cross(w, d)
first, ahead = turning(w, q), turning(w, q + d)
patterns = {
    "six lines anywhere": lines(6),
    "two on one line": [first, turning(w, q + 0.7 * w), *lines(4)],
    "three parallel, in one plane": [first, ahead, turning(w, q - 0.4 * d), *lines(3)],
    "three parallel, not in one plane": [first, ahead, turning(w, q + square), *lines(3)],
    "four through one point": [*(turning(x, q) for x in rng.normal(size=(4, 3))), *lines(2)],
}
ranks = {words: int(np.linalg.matrix_rank(pattern, tol=1e-9)) for words, pattern in patterns.items()}
guide.table(
    ["six turning axes", "rank"],
    list(ranks.items()),
    "The axes are the columns of $J^s$. The rank of this matrix counts the independent ones.",
)

# %% [markdown]
# ## Driving through
#
# Move from the ready configuration to the worst one, every joint in proportion. At each step, take the twist of size
# one that needs the largest joint rates. Their size is $1/\sigma$.
#
# A controller that inverts $J$ sends these rates to the motors. **Damped least squares** does not. It is the damped
# step of the numeric solver. The twist $V$ takes the place of the gap, and the rates take that of the step:
#
# $$\dot\theta = J^T (J J^T + \lambda^2 I)^{-1} V$$
#
# As there, it replaces $1/\sigma$ by $\sigma/(\sigma^2 + \lambda^2)$, which is never more than $1/(2\lambda)$. In
# return, the tool moves only at the share $\sigma^2/(\sigma^2 + \lambda^2)$ of the commanded twist. Here $\sigma$ and
# $\lambda$ have no unit, because lengths are in units of the reach.

# %% tags=["shown"]
damping = 0.05
s = np.linspace(0, 1, 400)
on_the_way = theta + s[:, None] * (singular - theta)
small = np.maximum(arm.manipulability(on_the_way).singular_values[:, rank - 1], 1e-12)
plain, damped = 1 / small, small / (small**2 + damping**2)


# %%
guide.predict(
    f"With $\\lambda = {damping}$, how large can the damped rates be for a twist of size one?",
    rf"$1/(2\lambda) = {1 / (2 * damping):.0f}$, reached where $\sigma = \lambda$. Nearer to the singularity "
    rf"the rates fall, and in it they are zero. The arm gives up the direction that it has lost, and keeps the others.",
)

# %%
fig, ax = guide.axes2(
    xlabel="from waiting (0) to the worst configuration (1)", ylabel="joint rates per unit of twist"
)
top = 30 / damping
ax.semilogy(s, np.minimum(plain, 10 * top), label="inverse, 1/σ")
ax.semilogy(s, damped, label=f"damped, λ = {damping}")
ax.axhline(1 / (2 * damping), color=guide.GREY, linewidth=1.0, linestyle=":", label="1/(2λ)")
ax.set_ylim(min(0.3 / damping / 10, plain.min() / 2, damped[0] / 2), top)
ax.legend(loc="upper left")
guide.figure(
    fig,
    "The rates of the inverse grow without bound towards the singular configuration; those of damped least "
    "squares stay below"
    f" {1 / (2 * damping):.0f} and fall to zero there"
    if is_singular
    else "The rates of the inverse and of damped least squares on the way to the worst configuration",
    "The worst direction, on the way to the worst configuration.",
)

# %% [markdown]
# Damping is for driving by hand; twistarm's servo and its solver are damped. When you *plan* a motion, you have more
# choices. Move past such a place in joint space (`JointMove`), choose another solution of inverse kinematics, or move
# the work elsewhere.
#
# ## Strength near a singularity
#
# By $\tau = J^T F$, the wrench $F$ with $F^T J = 0$ needs no motor torque: the structure carries it. In the same way
# you hold a suitcase with a straight arm.

# %%
straight = np.array([0.4, np.radians(1.0)])
pull = planar.fk(straight)[:2, 3] - screws.to_screw(planar.screws[:, 0]).point[:2]
force = 100 * pull / np.linalg.norm(pull)
stretched = planar.hybrid_jacobian(straight)[:2].T @ force
bent = planar.hybrid_jacobian([0.4, np.radians(90.0)])[:2]
tool = planar.fk([0.4, np.radians(90.0)])[:2, 3] - screws.to_screw(planar.screws[:, 0]).point[:2]
at_right_angle = bent.T @ (100 * tool / np.linalg.norm(tool))
guide.predict(
    "The two-link arm pulls outward with 100 N, along the line from its base. What torque must the elbow hold when "
    "it is bent by 90°, and what when it is bent by 1°?",
    f"{abs(at_right_angle[1]):.1f} N m at 90°, and {abs(stretched[1]):.2f} N m at 1°. The motor can "
    f"hardly move the tool outward there, but it need hardly hold against the pull either.",
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **Only the ends are checked.** Both ends of a straight line are fine, and the middle is singular. Check the whole
#   path. `plan` does, and `PathError` names the place.
# - **The determinant as a distance.** It also shrinks with the size of the arm. Use the condition number or the
#   smallest singular value.
# - **Metres beside radians.** In millimetres the same configuration has another condition number. Say what length is
#   worth a radian.
# - **A hard switch.** Some programs solve $J\dot\theta = V$ by $1/\sigma_i$, and set it to 0 for a small $\sigma_i$ (a
#   pseudo-inverse). The rates jump when one crosses the threshold, and the motors jerk. Damping is smooth.
# - **Zero is singular.** In many descriptions the arm is stretched out at zero. Do not start Newton's method or a
#   joystick there.

# %%
determinant = float(np.linalg.det(planar.hybrid_jacobian([0.4, 1.2])[:2]))
zero = arm.manipulability(np.zeros(arm.n))
lowest = zero.singular_values[rank - 1] / zero.singular_values[0]
at_zero = "singular" if lowest < 1e-6 else f"condition {float(zero.condition_in(rank)):.1f}"
same = [
    float(arm.manipulability(theta, length).condition_in(rank)) for length in (arm.reach, 1.0, 0.001)
]
guide.table(
    ["what", "number"],
    [
        ["determinant of the two-link arm, well bent", f"{determinant:.4f}"],
        ["the same arm built a tenth as large", f"{determinant / 10**2:.6f}"],
        [f"condition of `{arm.name}`, waiting, by its reach", f"{same[0]:.1f}"],
        ["the same, one metre worth one radian", f"{same[1]:.1f}"],
        ["the same, one millimetre worth one radian", f"{same[2]:.0f}"],
        [f"`{arm.name}`, all joints at zero", at_zero],
    ],
    "The mistakes in numbers.",
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_3_2_singularities")
