# %% [markdown]
# # What is true of your arm
#
# In the capstone, three programs read your file alike. On the table the tool is still a centimetre beside its target. A
# printed bracket has shrunk, a motor horn is one tooth off, and an axis is tilted by a third of a degree. The file does
# not contain these errors.
#
# This lesson measures them. You write a model of the arm with small errors, and find out which of them a set of
# measurements can show. Then you fit these, and test the fit on other measurements. `twistarm calibrate` does all of
# this.
#
# ## The arm in the file, and the arm on the table
#
# The **nominal** arm is that of the file. The **real** arm is the one that you have built. Here a hidden arm plays the
# real one: each of your joints, and the tool, is slightly displaced. Shifts have a standard deviation of 1 mm along
# each axis, and turns of 0.3° about each. That is typical of good printed parts.
#
# A **displacement** $\delta_i \in se(3)$ is a twist. Its motion $e^{\hat\delta_i}$ moves joint $i$ and everything
# beyond it. So the product of exponentials becomes
#
# $$g(\theta) = e^{\hat\delta_1} e^{\hat\xi_1\theta_1} \; e^{\hat\delta_2} e^{\hat\xi_2\theta_2} \cdots
# e^{\hat\delta_n} e^{\hat\xi_n\theta_n} \; e^{\hat\delta_{n+1}} g_{st}(0)$$
#
# This is the **local product of exponentials** (Chen, Yang, Tan and Yeo, *Local POE model for robot kinematic
# calibration*, 2001). The displacement is easiest to read at the joint's own position $q_i$: for instance, $d_i$ is 1
# mm along $y$ and 0.3° about $x$. The Adjoint of the shift to $q_i$ gives $\delta_i = \mathrm{Ad}_{T(q_i)}\, d_i$.

# %%
import numpy as np

from twistarm import Position, calibrate, guide, rotations, screws, solve_ik
from twistarm.calibration import Measurements

arm = guide.arm()
rng = np.random.default_rng(4)
m = arm.screws.shape[1]  # moving joints, those that follow another too


def at(q):
    g = np.eye(4)
    g[:3, 3] = q
    return screws.adjoint(g)


places = [at(q) for q in guide.arm_points(arm, np.zeros(arm.n))[1:]]  # of every joint, and of the tool


# %% tags=["shown"]
def real_tool(d, theta):
    """The tool (K, 4, 4) of an arm with joints and tool displaced by d (m + 1, 6)."""
    g, x = np.eye(4), theta @ arm.coupling.A.T
    for i in range(m):
        g = g @ screws.exp(places[i] @ d[i]) @ screws.exp(arm.screws[:, i], x[:, i])
    return g @ screws.exp(places[m] @ d[m]) @ arm.home


# %%
build = np.array([1e-3] * 3 + [np.radians(0.3)] * 3)  # standard deviations of the workshop [m, rad]
hidden = rng.normal(size=(m + 1, 6)) * build

fresh = arm.random_theta(rng, 400)
off = np.linalg.norm((real_tool(hidden, fresh) - arm.fk(fresh))[:, :3, 3], axis=1)

# %%
guide.say(
    f"`{arm.name}`, nominal and real, at 400 random configurations: the mean error of the tool is "
    f"{1000 * off.mean():.1f} mm, and the largest {1000 * off.max():.1f} mm. Nothing is loose: the real arm "
    f"comes back to the same place every time."
    f" It is **repeatable**, and it is not **accurate**."
)
alone = []
for i in range(m + 1):
    only_one = np.zeros_like(hidden)
    only_one[i] = hidden[i]
    alone.append(np.linalg.norm((real_tool(only_one, fresh) - arm.fk(fresh))[:, :3, 3], axis=1).mean())
names = arm.moving_names if len(arm.moving_names) == m else [f"screw {i + 1}" for i in range(m)]
guide.table(
    ["only this is displaced", "shift $d$ [mm]", "turn $d$ [°]", "the tool is off by"],
    [
        [
            name,
            f"{1000 * np.linalg.norm(d_i[:3]):.1f}",
            f"{np.degrees(np.linalg.norm(d_i[3:])):.2f}",
            f"{1000 * far:.1f} mm",
        ]
        for name, d_i, far in zip(
            [*(f"`{name}`" for name in names), "the tool"], hidden, alone, strict=True
        )
    ],
    "Mean over the configurations. The effect of a turn grows with the length of the arm beyond it.",
)

# %% [markdown]
# ## Four numbers for an axis, two for a slide
#
# A displacement has six numbers. Not all of them change the axis. The twist $\xi$ of a displaced joint is
# $\mathrm{Ad}_{e^{\hat\delta}}\xi$. To first order it changes by the Lie bracket $[\delta, \xi]$. A shift along the
# axis of a turning joint, or a turn about it, does not change its twist. A slide has a direction but no position. Only
# the two turns that tilt it change its twist.

# %%
changes = [
    np.linalg.matrix_rank(screws.bracket(np.eye(6), np.broadcast_to(xi, (6, 6))), tol=1e-9)
    for xi in arm.screws.T
]
guide.table(
    ["joint", "kind", r"numbers that change its axis: the rank of $\delta \mapsto [\delta, \xi]$"],
    [
        [f"`{name}`", "slide" if np.linalg.norm(xi[3:]) < 1e-9 else "turns", int(k)]
        for name, xi, k in zip(names, arm.screws.T, changes, strict=True)
    ],
)
guide.predict(
    "What about the other numbers of a displacement? They matter: if a joint is shifted along its axis, the "
    "tool is shifted too.",
    r"They commute with the joint, $e^{\hat\delta} e^{\hat\xi\theta} = e^{\hat\xi\theta} e^{\hat\delta}$. So "
    r"they can be added to the displacement of the next joint, and in the end to that of the tool. A turn "
    r"about the joint's own axis is an error of its zero. So your arm has at most"
    f" {sum(changes)} numbers for its axes and 6 for its tool.",
)

# %% [markdown]
# ## What a measurement shows
#
# A device measures the position $p$ of the tool's origin. How far does $p$ move for each number of each displacement?
# The joints before $\delta_i$ move it, as they move a column of the Jacobian. The resulting twist $(v, \omega)$ moves
# $p$ by $v + \omega \times p$. So a configuration gives three rows, with six columns for each displacement:
#
# $$p_\text{real} - p_\text{nominal} \approx A(\theta)\, d, \qquad
# A_i = \begin{bmatrix} I & -\hat p \end{bmatrix} \mathrm{Ad}_{e^{\hat\xi_1\theta_1} \cdots e^{\hat\xi_{i-1}\theta_{i-1}}}
# \mathrm{Ad}_{T(q_i)}$$


# %%
def slopes(theta):
    """The derivatives (K, 3, 6 (m + 1)) of the tool's position by d."""
    p, x, g = arm.fk(theta)[:, :3, 3], theta @ arm.coupling.A.T, np.tile(np.eye(4), (len(theta), 1, 1))
    columns = []
    for i in range(m + 1):
        V = screws.adjoint(g) @ places[i]
        columns.append(V[:, :3] + np.cross(V[:, 3:], p[:, :, None], axis=1))
        if i < m:
            g = g @ screws.exp(arm.screws[:, i], x[:, i])
    return np.concatenate(columns, axis=2)


theta = arm.random_theta(rng, 60)
noise = 2e-4  # standard deviation of each coordinate [m]
measured = real_tool(hidden, theta)[:, :3, 3] + rng.normal(scale=noise, size=(60, 3))
A = slopes(theta).reshape(180, -1)
r = (measured - arm.fk(theta)[:, :3, 3]).ravel()

# %%
by_slopes = (slopes(fresh) @ hidden.ravel()) - (real_tool(hidden, fresh) - arm.fk(fresh))[:, :3, 3]
left = np.linalg.norm(by_slopes, axis=1).mean()
guide.say(
    f"You move the real arm to 60 configurations, and a camera measures the tool, with a noise of "
    f"{1000 * noise:.1f} mm. "
    f"That gives {len(r)} numbers. The linear model explains the hidden errors of {1000 * off.mean():.1f} mm "
    f"up to {1000 * left:.2f} mm (means): for small displacements it is accurate."
)

# %% [markdown]
# ## What a log can show
#
# Divide every row of $A$ by its noise. Count each number of $d$ in units of the workshop's errors, 1 mm or 0.3°. Each
# **singular value** of this matrix belongs to a combination of displacements. It is the ratio of signal and noise: how
# far a typical error of that combination moves the measurements, divided by their noise. Above 1 the log shows the
# combination. Far below 1 the noise hides it. At 0 no log can show it: two different arms give the same measurements.

# %% tags=["shown"]
unit = np.tile(build, m + 1)
U, s, Vt = np.linalg.svd(A * unit / noise, full_matrices=False)
shown = int((s > 1).sum())
rank = int((s > 1e-9 * s[0]).sum())

# %%
at_most = sum(changes) + 3
fig, ax = guide.axes2(height=2.9, xlabel="combination of displacements", ylabel="errors over noise")
ax.semilogy(np.arange(1, rank + 1), s[:rank], "o", color=guide.BLUE, markersize=4)
ax.axhline(1.0, color=guide.GREY, linestyle="--", linewidth=1)
guide.figure(
    fig,
    f"The singular values over their number, on a logarithmic scale: {rank} of {6 * (m + 1)} are not zero, "
    f"and {shown} are "
    "above the dashed line at 1",
    f"`{arm.name}`: {6 * (m + 1)} numbers, {rank} combinations that positions can show at all, {shown} above "
    f"the noise.",
)
guide.say(
    f"Positions do not show how the tool is turned. So they show at most {at_most} combinations: "
    f"{sum(changes)} for the axes, and 3 for the tool's point. Here they show {rank}. "
    + (
        "Parallel or crossing axes hide the rest, to first order."
        if rank < at_most
        else "This arm hides none of them."
    )
)

# %%
still = theta.copy()
still[:, -1] = arm.ready[-1]
frozen = np.linalg.svd(slopes(still).reshape(180, -1) * unit / noise, compute_uv=False)
p_hat = rotations.skew(arm.fk(theta)[:, :3, 3])
of_base = np.concatenate([np.tile(np.eye(3), (60, 1, 1)), -p_hat], axis=2).reshape(180, 6)
with_base = np.linalg.matrix_rank(np.hstack([A * unit, of_base * build]) / noise, tol=1e-9 * s[0])
guide.predict(
    "The camera's frame is unknown too: six more numbers, a displacement of the base. How many more "
    "combinations does the log then show? And how many if the last joint never moves?",
    f"{with_base - rank or 'None'} more. The base comes before joint 1, as $\\delta_1$ does: both have the "
    f"same six columns. A log shows where the first axis is, seen from the camera. It cannot show how much of "
    f"that is an error of the arm. So `calibrate` fits the base, and holds the first axis."
    f" If `{arm.joint_names[-1]}` never moves, {int((frozen > 1).sum())} combinations show, instead of "
    f"{shown}: its axis and zero cannot be separated from the tool.",
)

# %% [markdown]
# ## Least squares in units of the noise
#
# A tape has an error of a millimetre, a camera of a fifth of one. To combine them, divide each row by its standard
# deviation $\sigma_k$. Then every row has noise of 1, and the sum of squares weighs them correctly:
#
# $$\min_d \sum_k \left( \frac{A_k d - r_k}{\sigma_k} \right)^2, \qquad B_k = \frac{A_k}{\sigma_k}, \qquad
# \mathrm{cov}(d) = (B^T B)^{-1}$$
#
# The covariance exists only for the combinations that the log shows. So leave out the hidden ones. Combination $j$ of
# the singular values above has the estimate $u_j^T r / \sigma / s_j$. Its standard deviation is $1 / s_j$ in the
# workshop's units.

# %%
estimate = (U.T @ r / noise) / s  # of each combination
truth = Vt @ (hidden.ravel() / unit)


def signed(number):
    return f"{number:.2f}".replace("-", "−")


rows = [j for j in (0, shown // 2, shown - 1, min(shown + 1, rank - 1)) if j < rank]
guide.table(
    ["combination", "singular value", "estimate", "standard deviation", "hidden truth"],
    [
        [str(j + 1), f"{s[j]:.3g}", signed(estimate[j]), f"{1 / s[j]:.2g}", signed(truth[j])]
        for j in sorted(set(rows))
    ],
    "In the workshop's units. A deviation of 1 or more adds no information: the workshop's errors are no larger.",
)
surprise = (estimate - truth)[:shown] * s[:shown]
guide.say(
    f"Over the {shown} combinations shown, estimate minus truth is {np.sqrt(np.mean(surprise**2)):.2f} "
    f"standard deviations (root mean square). About 1 is right: then the stated noise is correct."
)

# %% [markdown]
# ## Rows left out of the fit
#
# With every combination that you add, the residual of the fit falls. That proves nothing: a fit with as many numbers as
# rows has no residual. Leave some rows out of the fit, and predict *them*. When their error stops falling, the fit has
# begun to follow the noise. A rougher device shows it better: a ruler held to the tool, with a noise of 3 mm.

# %% tags=["shown"]
rough = 3e-3
ruler = r + rng.normal(scale=rough, size=180)
# twelve configurations for the fit, and the others for the test
U2, s2, Vt2 = np.linalg.svd(A[:36] * unit / rough, full_matrices=False)
most = int((s2 > 1e-9 * s2[0]).sum())
fit_error, held_out = [], []
for k in range(most + 1):
    d = unit * (Vt2[:k].T @ ((U2[:, :k].T @ ruler[:36] / rough) / s2[:k]))
    fit_error.append(np.sqrt(np.mean((A[:36] @ d - ruler[:36]) ** 2)))
    held_out.append(np.sqrt(np.mean((A[36:] @ d - ruler[36:]) ** 2)))

# %%
best = int(np.argmin(held_out))
fig, ax = guide.axes2(height=3.0, xlabel="combinations fitted", ylabel="error of a coordinate [mm]")
ax.plot(1000 * np.array(fit_error), "o-", markersize=3, color=guide.BLUE, label="rows of the fit")
ax.plot(1000 * np.array(held_out), "s--", markersize=3, color=guide.ORANGE, label="rows left out")
ax.axhline(1000 * rough, color=guide.GREY, linestyle=":", linewidth=1, label="noise")
ax.legend(fontsize=8)
guide.figure(
    fig,
    "The error of the fitted rows falls with every combination, below the noise; that of the rows left out falls no "
    "farther than to about the noise",
    f"The least error on rows left out is {1000 * held_out[best]:.2f} mm, with {best} combinations. With all "
    f"{most} it is "
    f"{1000 * held_out[-1]:.2f} mm, while that of the fit is {1000 * fit_error[-1]:.2f} mm.",
)

# %% [markdown]
# ## All steps in one call
#
# `twistarm calibrate my_arm.urdf log.csv -o corrected.urdf`
#
# `calibrate` does these steps with the exact, nonlinear equations, and gives outliers less weight. It fits base and
# tool first, then zeros, then axes. It holds at 0 what the log does not show. It writes the corrected file only if the
# rows left out confirm it.

# %% tags=["shown"]
found = calibrate(arm, Measurements(theta, measured), position_noise=noise)
real = real_tool(hidden, fresh)[:, :3, 3]
after = np.linalg.norm(found.predict(fresh) - real, axis=1)

# %%
guide.table(
    ["", "base and tool alone", "with zeros and axes"],
    [
        [
            "rows of the log",
            f"{1000 * found.before.mean():.2f} mm",
            f"{1000 * found.after.mean():.2f} mm",
        ],
        ["rows left out", f"{1000 * found.held_out_before:.2f} mm", f"{1000 * found.held_out:.2f} mm"],
        [
            "the hidden arm, 400 fresh configurations",
            f"{1000 * off.mean():.2f} mm in the file",
            f"{1000 * after.mean():.2f} mm",
        ],
    ],
    "Mean errors. For a real arm you know the second row. Only a simulation has the last one.",
)
lines = found.changes()
guide.say(
    f"The result for `{arm.name}`:\n\n"
    + "\n".join(f"- {line}" for line in lines[:7])
    + f"\n\nHeld at 0, because this log does not separate them from the others: {len(found.unseen)} numbers, "
    f"such as *{found.unseen[0]}*."
)
guide.predict(
    "Compare these numbers with the hidden displacements. Do you expect them to be equal?",
    "No. A shift of one axis and a longer tool may have the same effect. The fit chooses the smallest "
    "numbers with that effect. The prediction of the tool's position is right, so check that, not the numbers.",
)

# %% [markdown]
# ## A tape, and a ball in two sockets
#
# A laser tracker costs more than your rover. Two simpler tools:
#
# - **A tape.** Drive three nails into the table and the wall, far apart. Hook the tape on a nail, and read the distance
#   to the tool's point: columns `wire` and `length`. Forward kinematics gives the direction $u$ to the nail, and the
#   row is $u^T A$. The positions of the nails are unknown, three numbers each.
# - **A ball in two sockets.** The tool holds a ball. It stays in a printed socket while the arm takes many
#   configurations: column `point`. The position of the socket is unknown. A second socket, at a known distance, gives
#   the scale (Franzese and others, *MUKCa*, 2025). The documentation page *Calibrate the geometry* has the plate to
#   print.
#
# You can compute what each of them will show before you measure. Start with the workshop's errors, a covariance $P$ of
# 1 mm and 0.3°. A log adds information: $C = (P^{-1} + B^T B)^{-1}$. The tool's error at a fresh configuration then has
# the covariance $A C A^T$.


# %%
def columns_of(theta):
    """The slopes (K, 3, 6 m) of all displacements but the first, the frame, in the workshop's units."""
    return slopes(theta)[:, :, 6:] * unit[6:]


def tracked(theta, noise):
    """A camera somewhere: its place is a displacement of the base."""
    seen = slopes(theta)
    return (
        np.concatenate([columns_of(theta), seen[:, :, :6]], axis=2).reshape(3 * len(theta), -1) / noise
    )


def taped(theta, nails, noise):
    """The distances from the nails, at unknown places."""
    way = arm.fk(theta)[:, None, :3, 3] - nails
    u = way / np.linalg.norm(way, axis=2, keepdims=True)
    own = np.stack([np.kron(np.eye(len(nails))[k], -u[:, k]) for k in range(len(nails))], axis=1)
    return (
        np.concatenate([u @ columns_of(theta), own], axis=2).reshape(len(nails) * len(theta), -1)
        / noise
    )


def rested(groups, ways, noise):
    """Configurations at each socket, at unknown places; sockets 2k and 2k + 1 are apart along ways[k]."""
    N = len(groups)
    rows = [
        np.concatenate(
            [columns_of(group), np.tile(np.kron(np.eye(N)[k], -np.eye(3)), (len(group), 1, 1))], axis=2
        )
        for k, group in enumerate(groups)
    ]
    ways_known = np.kron(np.eye(N)[::2] - np.eye(N)[1::2], np.ones(3)) * np.tile(ways, N)
    known = np.hstack([np.zeros((len(ways), 6 * m)), ways_known])
    return np.vstack([np.concatenate(rows).reshape(-1, 6 * m + 3 * N) / noise, known / 1e-5])


around = np.linalg.svd(slopes(fresh[:60])[:, :, :6].reshape(180, 6), full_matrices=False)
base = around[0][
    :, around[1] > 1e-9 * around[1][0]
]  # what motions of the base do at fresh configurations
afresh = columns_of(fresh[:60]).reshape(180, -1)
afresh = afresh - base @ (base.T @ afresh)  # a base that stands elsewhere is no error of the arm


def expected(B):
    """The error of the tool anywhere [m], root mean square. Behind the displacements B has columns for places."""
    P = np.zeros(B.shape[1])
    P[: 6 * m] = 1.0  # places: nothing is known
    C = np.linalg.pinv(B.T @ B + np.diag(P), hermitian=True)[: 6 * m, : 6 * m]
    return float(np.sqrt(3 * np.mean(np.einsum("ki,ij,kj->k", afresh, C, afresh))))


def in_socket(point, times):
    """Configurations with the tool at a point, each from another start."""
    tries = [solve_ik(arm, Position(point), arm.random_theta(rng)) for _ in range(2 * times)]
    return np.array([answer.theta for answer in tries if answer.converged][:times])


def plates(count, times):
    """Configurations in the two sockets of plates at several places, turned at random, and the ways between sockets."""
    groups, ways = [], []
    while len(ways) < count:
        place = arm.fk(0.5 * arm.ready + 0.5 * arm.random_theta(rng))[:3, 3]
        way = screws.exp([0, 0, 0, 0, 0, 1], rng.uniform(0, 2 * np.pi))[:3, 0]
        pair = [in_socket(place + 0.05 * k * way, times) for k in range(2)]
        if min(map(len, pair)) == times:
            groups, ways = groups + pair, [*ways, way]
    return groups, np.array(ways)


# %%
nails = arm.reach * np.array([[1.0, 0.8, 0.0], [1.0, -0.8, 0.2], [-0.5, 0.6, 0.9]])
spare = arm.n - int(np.linalg.matrix_rank(arm.hybrid_jacobian(fresh[0])[:3], tol=1e-6))
logs = [("no log", "", np.zeros((1, 6 * m)))]
logs += [
    ("tape from three nails, noise 1 mm", f"{3 * K} distances", taped(theta[:K], nails, 1e-3))
    for K in (10, 40)
]
if spare:
    for count, times in ((1, 20), (4, 20)):
        where = f"{2 * count * times} rows, {count} place{'s' * (count > 1)}"
        logs.append(("ball in two sockets, play 0.1 mm", where, rested(*plates(count, times), 1e-4)))
logs.append(("camera, noise 0.2 mm", "60 rows", tracked(theta, noise)))
guide.table(
    ["log", "how much", "error anywhere in reach"],
    [[what, much, f"{1000 * expected(B):.2f} mm"] for what, much, B in logs],
    f"The error that remains after each log, for `{arm.name}`, computed before any measurement.",
)
guide.say(
    "Sockets show little about places far from them. Move the plate to several places, low and high, near "
    "and far. A tape reaches everywhere. Many rough rows compensate for their noise: the error falls with "
    "the root of their number."
    + (
        " The distances between plates are unknown. So plates show little about a slide that moves the arm "
        "from one plate to the other."
        if "m" in arm.units
        else ""
    )
    if spare
    else f"`{arm.name}` has no redundant joint: in a socket it can hardly move, so a ball in sockets shows nothing. Take the tape. Many rough rows compensate for their noise: the error falls with the root of their number."
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **All rows from one corner.** Rows left out of the same corner confirm the fit, but it fails elsewhere. Measure
#   where you will work. Leave out all rows of one place, not only single rows.
# - **Too small a noise.** If you state 0.01 mm for a tape, the fit explains the tape's errors with tilted axes. Take
#   the same reading five times, and state the scatter.
# - **Correct the wiring first.** A swapped motor or a joint in degrees is not a small displacement. `twistarm wiring`
#   finds these.
# - **A base that moved.** The table was pushed after row 40. Measure the first configuration again at the end: both
#   rows must agree.
# - **An arm that bends.** A long arm sags under its load, and displaced axes cannot describe that. If the error of the
#   rows left out stays far above the noise, the model lacks something: bending, play, or an eccentric gear.
# - **The correction is lost.** The next export from CAD has the old numbers. Keep the log, and calibrate again.

# %%
corner = arm.ready + 0.15 * (arm.random_theta(rng, 60) - arm.ready)
away = expected(tracked(corner, noise))
guide.say(
    f"After sixty rows in the middle of the reach, where each joint uses a seventh of its range, the error "
    f"elsewhere is {1000 * away:.2f} mm. After sixty rows from everywhere it is "
    f"{1000 * expected(tracked(theta, noise)):.2f} mm, with the same camera."
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("4_calibration")
