# %% [markdown]
# # What can the arm reach?
#
# You are about to drill the holes for the base of the arm. Will it reach the ground in front of the wheels? Will it
# reach its own battery box? And can it point the gripper straight down there? These questions are about all
# configurations at once. Forward kinematics answers them if you try very many.

# %%
import numpy as np

from twistarm import Approach, Pose, Position, guide, rotations, screws, solve_ik, solve_ik_batch

arm = guide.arm()

# %% [markdown]
# ## The law
#
# Let $\Theta$ be the set of all configurations $\theta$ that the joints allow. Let $p(\theta)$ and $R(\theta)$ be the
# position and the orientation of the tool. The **reachable workspace** is the set of all places where the tool can be.
# The **dextrous workspace** is the set of places where it can have *every* orientation. Source: Murray, Li and Sastry,
# *A Mathematical Introduction to Robotic Manipulation* (MLS), section 3.2.4.
#
# $$W_R = \{\, p(\theta) : \theta \in \Theta \,\}$$
#
# $$W_D = \{\, p : \text{for every } R \in SO(3) \text{ there is a } \theta \in \Theta
# \text{ with } g_{st}(\theta) = (p, R) \,\}$$
#
# ## Two links: a ring
#
# The distance of the tip from the shoulder does not depend on $\theta_1$. By the law of cosines
#
# $$r^2 = l_1^2 + l_2^2 + 2\, l_1 l_2 \cos\theta_2$$
#
# The cosine runs from $-1$ to $1$. So $r$ runs from $\left|l_1 - l_2\right|$, with the arm folded, to $l_1 + l_2$, with
# the arm stretched. The first joint carries each of these points around a full circle. So the workspace is a ring.

# %%
planar = guide.bundled("rr_planar")
q1, q2 = (screws.to_screw(xi).point for xi in planar.screws.T)
l1, l2 = np.linalg.norm(q2 - q1), np.linalg.norm(planar.home[:3, 3] - q2)
tips = planar.fk(planar.random_theta(0, 4000))[:, :2, 3] - q1[:2]
r = np.linalg.norm(tips, axis=1)
guide.predict(
    f"The links are {l1:.2f} and {l2:.2f} m long. How large is the hole in the middle? You have "
    f"{l1 + l2:.2f} m of tube for both links: how would you cut it so that there is no hole?",
    f"Its radius is the difference of the links, {abs(l1 - l2):.2f} m; the nearest of {len(r):,} "
    f"random configurations comes to {r.min():.3f} m. Cut two links of {(l1 + l2) / 2:.2f} m: folded, the "
    "tip lies on the shoulder. (The arm then collides with itself. This lesson does not check that.)",
)
guide.slider(
    "two_link",
    r"Watch $r$. Which of the two sliders changes it? Find the smallest and the largest.",
    rf"Only $\theta_2$. The largest is {l1 + l2:.2f} m at 0°, the smallest {abs(l1 - l2):.2f} m at "
    "180°. Both are the same for the elbow on either side.",
    inverse=False,
    l1=round(float(l1), 3),
    l2=round(float(l2), 3),
    theta1=40,
    theta2=70,
)

# %% [markdown]
# Motors have stops. Let the shoulder turn only from 0° to 180°, and the elbow by 120° to either side. A part of the
# ring is then lost.

# %%
rng = np.random.default_rng(1)
stops = np.radians([[0, 180], [-120, 120]])
few_configurations = rng.uniform(stops[:, 0], stops[:, 1], (4000, 2))
stopped = planar.fk(few_configurations)[:, :2, 3] - q1[:2]

# %%
fig, panels = guide.axes2(columns=2, width=6.4, height=3.3, xlabel="x [m]", ylabel="y [m]", equal=True)
turn = np.linspace(0, 2 * np.pi, 200)
for ax, cloud, words in zip(panels, (tips, stopped), ("no stops", "with stops"), strict=True):
    ax.plot(*cloud[:500].T, ".", color=guide.BLUE, markersize=2)
    for radius in (abs(l1 - l2), l1 + l2):
        ax.plot(
            radius * np.cos(turn),
            radius * np.sin(turn),
            color=guide.ORANGE,
            linestyle="-",
            linewidth=1.2,
        )
    ax.plot(0, 0, "^", color=guide.INK)
    ax.set_title(words)
guide.figure(
    fig,
    "Two clouds of points in a ring between two circles: on the left they fill it all round, on the "
    "right only a part of its upper half and a piece below",
    "The tip of the two-link arm in five hundred random configurations. The circles have the radii $|l_1 - "
    "l_2|$ and $l_1 + l_2$.",
)

# %% [markdown]
# ## In every direction
#
# In a plane an orientation is a direction. With two links you cannot choose it: at each place the tip has two
# directions, one for each elbow. So the dextrous workspace of this arm is empty. Add a third link, a hand of length
# $l_3$. The wrist must be $l_3$ behind the tip, in the given direction. For all directions together, these wrists form
# a circle about the tip. Its distances from the shoulder run from $\left|r - l_3\right|$ to $r + l_3$. The place is
# dextrous if the whole circle lies in the ring of the first two links:
#
# $$\left|r - l_3\right| \ge \left|l_1 - l_2\right|, \qquad r + l_3 \le l_1 + l_2$$
#
# For a hand shorter than $\left|l_1 - l_2\right|$ this is again a ring, from $\left|l_1 - l_2\right| + l_3$ to $l_1 +
# l_2 - l_3$.


# %%
def share_of_directions(l3, radii):
    """The share of all directions that a hand of length l3 can have there."""
    turn = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    wrist = np.hypot(radii[:, None] - l3 * np.cos(turn), l3 * np.sin(turn))
    return ((wrist >= abs(l1 - l2)) & (wrist <= l1 + l2)).mean(axis=1)


radii = np.linspace(0, 1.0, 300)
hands = [0.06, 0.2]  # a short one and a long one [m]
shares = {l3: share_of_directions(l3, radii) for l3 in hands}

# %%
reach_of = {l3: l1 + l2 + l3 for l3 in hands}
all_round = {l3: radii[share == 1] for l3, share in shares.items()}
guide.predict(
    f"A hand of {hands[0]:.2f} m, or one of {hands[1]:.2f} m: with which does the arm reach farther? With "
    f"which are there more places where the hand can have every direction?",
    f"The long hand reaches farther, {reach_of[hands[1]]:.2f} m against {reach_of[hands[0]]:.2f} m. "
    f"The short one has more dextrous places: the outermost is at {all_round[hands[0]].max():.2f} m, "
    f"with the long hand at {all_round[hands[1]].max():.2f} m. With the long hand there is also a "
    "small disc of them about the shoulder: when the tip is there, the wrist circles around the hole "
    "in the ring of the first two links.",
)
fig, ax = guide.axes2(
    xlabel="distance r of the tip from the shoulder [m]", ylabel="possible directions [%]", height=3.0
)
for l3, share in shares.items():
    ax.plot(radii, 100 * share, label=f"hand of {l3:.2f} m")
ax.legend(loc="upper right")
ax.set_ylim(-3, 130)
guide.figure(
    fig,
    "The share of possible directions against the distance for two hands: the curve of the short hand "
    "is level at a hundred percent over a wide range, that of the long one over a narrow range and "
    "near the shoulder; both fall to zero at full stretch",
    f"Links of {l1:.2f} and {l2:.2f} m with either hand. Where a curve is at 100\u00a0% the place is "
    "dextrous. At full stretch there is only one direction.",
)

# %% [markdown]
# ## Your arm
#
# Most arms have no such formula, and you do not need one. Draw configurations at random inside the limits, and compute
# where the tool is.

# %% tags=["shown"]
cloud = arm.fk(arm.random_theta(2, 20_000))[:, :3, 3]
low, high = cloud.min(axis=0), cloud.max(axis=0)
drawn = cloud[:700]  # those of the picture

# %%
guide.table(
    ["", "from [m]", "to [m]"],
    [[f"${axis}$", float(a), float(b)] for axis, a, b in zip("xyz", low, high, strict=True)],
    f"The range of the tool of `{arm.name}` in {len(cloud):,} random configurations, seen from its base.",
)
at_ready = guide.arm_points(arm, arm.ready)
fig, panels = guide.axes2(columns=2, width=6.4, height=3.3, equal=True)
for ax, (i, j), words in zip(panels, ((0, 2), (0, 1)), ("from the side", "from above"), strict=True):
    ax.plot(*drawn[:, [i, j]].T, ".", color=guide.BLUE, markersize=1.8)
    ax.plot(
        *at_ready[:, [i, j]].T, color=guide.INK, linestyle="-", linewidth=2.5, marker="o", markersize=4
    )
    ax.set(xlabel=f"{'xyz'[i]} [m]", ylabel=f"{'xyz'[j]} [m]")
    ax.set_title(words)
guide.figure(
    fig,
    f"The places that the tool of {arm.name} comes to, as a cloud of points, from the side and from "
    "above, with the arm at its ready configuration in it",
    f"The reachable workspace of `{arm.name}` as a cloud of {len(drawn)} configurations.",
)

# %% [markdown]
# Is the cloud as large as the workspace? Ask `solve_ik`, a solver of inverse kinematics, for a place that is much too
# far away. Do so along each axis, to either side. It returns the configuration that comes nearest. Later lessons
# explain how it finds it. Forward kinematics checks the answer.

# %%
short = {}
for k, axis in enumerate("xyz"):
    for sign in (1, -1):
        far_away = (low + high) / 2
        far_away[k] = sign * 1000 * arm.reach
        end = arm.fk(solve_ik(arm, Position(far_away)).theta)[k, 3]
        short[axis, sign] = end, (sign * drawn[:, k]).max() * sign
worst = max(short, key=lambda side: abs(short[side][0] - short[side][1]))
(axis, sign), (end, seen) = worst, short[worst]
guide.predict(
    f"In the {len(drawn)} configurations of the picture the tool comes out to ${axis} = {seen:.3f}$ m on "
    f"the {'positive' if sign > 0 else 'negative'} side. Is that the edge of the workspace, to a "
    "millimetre, to a centimetre, or worse?",
    f"The tool comes to ${axis} = {end:.3f}$ m, {1000 * abs(end - seen):.0f} mm farther. The outermost places "
    f"need one particular configuration, and random samples do not find it. The cloud is dense where many "
    f"configurations lead. Its density does not show how far the arm can go.",
)

# %% [markdown]
# ## And pointing there?
#
# Now back to the question at the beginning. Lay a grid over the workspace and ask two things at each point. Can the
# tool be there at all? That is a `Position`. Can it be there and point in a given direction? That is an `Approach`. An
# arm that picks things up from the ground needs it.

# %%
size = high - low
# a section seen from the side, but for an arm that moves in a plane
upright = size[2] > 0.3 * size.max()
i, j = (int(np.argmax(size[:2])), 2) if upright else (0, 1)
grid_i, grid_j = (
    np.linspace(low[k] - 0.03 * arm.reach, high[k] + 0.03 * arm.reach, 13) for k in (i, j)
)
places = np.tile(at_ready[-1], (13 * 13, 1))
places[:, [i, j]] = np.array([[a, b] for a in grid_i for b in grid_j])
reached = solve_ik_batch(
    arm, [Position(p) for p in places], position_tol=1e-4, orientation_tol=1e-3
).converged


def pointing(direction):
    """At which of the places the tool can point that way."""
    found = reached.copy()
    targets = [Approach(p, direction, arm.tool_axis) for p in places[reached]]
    found[reached] = (
        solve_ik_batch(arm, targets, position_tol=1e-4, orientation_tol=1e-3).converged
        if targets
        else []
    )
    return found


down, words = np.array([0.0, 0.0, -1.0]), "straight down"
also = pointing(down)
if not also.any():
    down, words = arm.fk(arm.ready)[:3, :3] @ arm.tool_axis, "as it does at the ready configuration"
    also = pointing(down)
    guide.say(
        f"`{arm.name}` can point its tool straight down at none of them. The picture asks for the "
        "direction that the tool has at the ready configuration."
    )
fig, ax = guide.axes2(
    width=5.0, height=4.2, xlabel=f"{'xyz'[i]} [m]", ylabel=f"{'xyz'[j]} [m]", equal=True
)
for which, marker, colour, label in (
    (~reached, "x", guide.GREY, "not reached"),
    (reached & ~also, "o", guide.BLUE, "reached"),
    (also, "s", guide.ORANGE, f"reached, pointing {words}"),
):
    face = colour if marker == "s" else "none"
    ax.plot(
        *places[which][:, [i, j]].T,
        marker,
        color=colour,
        markerfacecolor=face,
        markersize=5,
        label=label,
    )
ax.plot(*at_ready[:, [i, j]].T, color=guide.INK, linestyle="-", linewidth=2.5)
ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=3)
guide.figure(
    fig,
    f"A grid of {len(places)} points around {arm.name}: {int(reached.sum())} are reached, and at "
    f"{int(also.sum())} of them the tool can point {words}",
    f"A section of the workspace of `{arm.name}`, where ${'xyz'[3 - i - j]} = "
    f"{at_ready[-1, 3 - i - j]:.2f}$ m, with the arm at its ready configuration.",
)
guide.predict(
    f"At what share of the places in this section that the tool reaches can it point {words}?",
    f"At {int(also.sum())} of {int(reached.sum())}"
    + (f", {100 * also.sum() / reached.sum():.0f}\u00a0%." if reached.any() else ".")
    + " Choose the height of the base by the squares, not by the circles.",
)

# %% [markdown]
# A direction leaves the roll about it free. The dextrous workspace leaves nothing free. Take the place of the tool at
# the ready configuration, and ask for many random orientations there.

# %%
here = arm.fk(arm.ready)
targets = []
for xyzw in np.random.default_rng(5).normal(size=(60, 4)):
    g = here.copy()
    g[:3, :3] = rotations.from_xyzw(xyzw / np.linalg.norm(xyzw))
    targets.append(Pose(g))
reached_there = solve_ik_batch(arm, targets).converged
guide.say(
    f"There `{arm.name}` can give its tool {int(reached_there.sum())} of {len(reached_there)} random orientations. "
    + (
        f"That alone does not prove that the place is dextrous: {len(reached_there)} are not all."
        if reached_there.all()
        else "So the place is outside the dextrous workspace."
    )
)
if arm.n < 6:
    guide.say(
        "A place and an orientation are six numbers, three and three. An arm of $n$ joints controls "
        "$n$ of them, and its dextrous workspace has the dimension $n - 3$ at most. "
        + (
            f"With {arm.n} joints it has "
            + (
                "no point at all."
                if arm.n < 3
                else f"{('single points', 'lines', 'surfaces')[arm.n - 3]} at most, "
            )
            + ("" if arm.n < 3 else "and often none; it never fills a region.")
        )
    )

# %%
guide.scene(
    arm, caption="Move each joint from stop to stop, and watch where the tool goes.", quantity="joints"
)
nearest = arm.random_theta(2, 20_000)[np.linalg.norm(cloud, axis=1).argmin()]
guide.predict(
    "In which configuration is the tool nearest to the base? Look for it in the view.",
    f"In the nearest of the {len(cloud):,} random configurations it is "
    f"{np.linalg.norm(cloud, axis=1).min():.2f} m from the base's origin: "
    + ", ".join(
        f"`{name}` at " + (f"{x:.2f} m" if unit == "m" else f"{np.degrees(x):.0f}°").replace("-", "−")
        for name, x, unit in zip(arm.joint_names, nearest, arm.units, strict=True)
    )
    + ".",
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **Reachable taken for usable.** The tool gets there, but it points the wrong way.
# - **The edge as a work place.** At full stretch there is one configuration and one direction. The tool cannot move
#   outwards there, even with fast motors.
# - **Another tool.** A longer gripper shifts the whole workspace and shrinks the dextrous one. Draw it again.
# - **The arm itself.** Kinematics does not know the shapes of the links. Between two reachable places the forearm may
#   have to pass through the mast.
# - **No stops.** A cloud from whole turns contains places that the motors' stops may forbid.

# %%
turns = np.array(arm.units) == "rad"
wide = arm.random_theta(2, 20_000)
wide[:, turns] = np.random.default_rng(2).uniform(-np.pi, np.pi, (len(wide), int(turns.sum())))
promised = arm.fk(wide)[:, :3, 3]
size_of = {"inside the limits": cloud, "as if it had none": promised}
cell = 0.1 * arm.reach
rows, cells = [], []
for words, points in size_of.items():
    cells.append(len(np.unique(np.floor(points / cell), axis=0)))
    heights = f"{points[:, 2].min():.2f} to {points[:, 2].max():.2f}".replace("-", "−")
    rows.append([words, str(cells[-1]), heights])
guide.table(
    ["turning joints", f"cells of {100 * cell:.0f} cm that are reached", "height $z$ [m]"],
    rows,
    f"`{arm.name}` in {len(cloud):,} random configurations each.",
)
guide.say(
    f"The stops of `{arm.name}` make a difference: without them {cells[1] - cells[0]} cells more seem "
    "to be reachable."
    if cells[1] > 1.05 * cells[0]
    else f"The stops of `{arm.name}` forbid almost nothing. The two counts differ by chance."
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_1_workspace")
