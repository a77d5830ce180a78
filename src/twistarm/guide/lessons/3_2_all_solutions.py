# %% [markdown]
# # How many ways are there?
#
# The gripper is where it should be, and the forearm leans against the camera mast. Is there another posture that holds
# the gripper in exactly the same pose? For two links in a plane the answer was the flip. For a whole arm the answer is
# a number, at most sixteen for six joints that turn. This lesson takes the question apart into three small ones, puts
# them together again for an arm with a wrist, and then counts the ways of your own arm.

# %%
import numpy as np

from twistarm import (
    Approach,
    Pose,
    arm_from_screws,
    guide,
    poe,
    rotations,
    screws,
    solve_ik_all,
    subproblems,
)


def turning(arm):
    """Which joints turn."""
    return np.flatnonzero(np.linalg.norm(arm.screws[3:], axis=0) > 0.5)


arm = guide.arm_with("a joint that turns", lambda a: len(turning(a)) > 0)

# %% [markdown]
# ## Three small questions
#
# One joint carries a point around a circle. Everything below is made of circles.
#
# **Subproblem 1.** The point $p$ is to come to $q$. By which angle? Take a point $r$ on the axis and keep what lies
# across the axis: $u' = (I - \omega\omega^T)(p - r)$ and $v' = (I - \omega\omega^T)(q - r)$. Then
#
# $$e^{\hat\xi\theta}\, p = q \quad\Rightarrow\quad
#   \theta = \mathrm{atan2}\big(\omega \cdot (u' \times v'),\; u' \cdot v'\big)$$
#
# There is an answer only if $p$ and $q$ are equally far from the axis, and equally far along it.
#
# **Subproblem 2.** Two joints, one after the other, are to bring $p$ to $q$:
# $e^{\hat\xi_1\theta_1} e^{\hat\xi_2\theta_2}\, p = q$. The second joint moves $p$ along a circle. The first one, run
# backwards, moves $q$ along another. Where the circles cross, they can hand over. Two circles about axes that meet
# cross in two points, in one, or not at all.
#
# **Subproblem 3.** The point $p$ is to come to the distance $\delta$ from $q$:
# $\|e^{\hat\xi\theta} p - q\| = \delta$. A circle meets a sphere in two points, in one, or not at all. This is the
# elbow of the lesson before, and the law of cosines answers it. Along the axis nothing changes, so that
# $\delta'^2 = \delta^2 - (\omega \cdot (p - q))^2$ is left to be met across it. With $\theta_0$ for the angle from
# $u'$ to $v'$ of subproblem 1:
#
# $$\theta = \theta_0 \pm \arccos \frac{\|u'\|^2 + \|v'\|^2 - \delta'^2}{2\, \|u'\|\, \|v'\|}$$
#
# They carry the names of Paden and Kahan (MLS, section 3.3.2).


# %%
def turn_to(xi, p, q):
    """Subproblem 1, for a joint that turns."""
    w, r = xi[3:], np.cross(xi[3:], xi[:3])  # the axis' direction, and a point of it
    across = np.eye(3) - np.outer(w, w)
    u, v = across @ (p - r), across @ (q - r)
    return np.arctan2(w @ np.cross(u, v), u @ v)


def turns_to_distance(xi, p, q, distance):
    """Subproblem 3, for a joint that turns: both angles, where there are two."""
    w, r = xi[3:], np.cross(xi[3:], xi[:3])
    across = np.eye(3) - np.outer(w, w)
    u, v = np.linalg.norm(across @ (p - r)), np.linalg.norm(across @ (q - r))
    cosine = (u**2 + v**2 - distance**2 + (w @ (p - q)) ** 2) / (2 * u * v)
    return turn_to(xi, p, q) + np.array([-1, 1]) * np.arccos(np.clip(cosine, -1, 1))


k = int(turning(arm)[0])
xi = arm.screws[:, k]
beside_the_tool = arm.reach * np.array([0.1, 0.07, 0.05])
finger = (arm.home @ np.append(beside_the_tool, 1))[:3]
moved = (screws.exp(xi, 0.7) @ np.append(finger, 1))[:3]
assert np.isclose(turn_to(xi, finger, moved), 0.7)
assert np.isclose(subproblems.subproblem_1(xi, finger, moved).values[0], 0.7)

half_way = np.linalg.norm((screws.exp(xi, 0.4) @ np.append(finger, 1))[:3] - moved)
both = turns_to_distance(xi, finger, moved, half_way)
by_library = subproblems.subproblem_3(xi, finger, moved, half_way).values
assert np.allclose(both, [0.4, 1.0])
assert np.allclose(np.sort(by_library % (2 * np.pi)), both)
guide.say(
    f"A point on the gripper of `{arm.name}`, turned by `{arm.moving_names[k]}` from ${guide.tex(finger)}$ to "
    f"${guide.tex(moved)}$ m: subproblem 1 reads off {np.degrees(turn_to(xi, finger, moved)):.2f}°, which is what was "
    "put in. `twistarm.subproblems` has all three, for joints that slide too."
)

# %% tags=["hidden"]
about_z, about_x = np.array([0, 0, 0, 0, 0, 1.0]), np.array([0, 0, 0, 1.0, 0, 0])


def circle(xi, p):
    """Where one joint takes p."""
    return np.array([(screws.exp(xi, a) @ np.append(p, 1))[:3] for a in np.linspace(0, 2 * np.pi, 120)])


fig, panels = guide.axes3(columns=3, width=6.6, height=2.6, box=False, elev=25, azim=-50)
p = np.array([0.75, 0.0, 0.45])
q = (screws.exp(about_z, 1.9) @ np.append(p, 1))[:3]
guide.plot_screw(panels[0], about_z, 1.7, r"$\xi$")
panels[0].plot(*circle(about_z, p).T, color=guide.GREY, linestyle="-", linewidth=1.2)
guide.plot_point(panels[0], p, "$p$", guide.BLUE)
guide.plot_point(panels[0], q, "$q$", guide.ORANGE)

p = np.array([0.45, 0.6, 0.45])
q = (screws.exp(about_z, 1.1) @ screws.exp(about_x, -0.5) @ np.append(p, 1))[:3]
guide.plot_screw(panels[1], about_z, 1.7, r"$\xi_1$")
guide.plot_screw(panels[1], about_x, 1.9, r"$\xi_2$", guide.SKY)
panels[1].plot(*circle(about_x, p).T, color=guide.BLUE, linestyle="-", linewidth=1.2)
panels[1].plot(*circle(about_z, q).T, color=guide.ORANGE, linestyle="--", linewidth=1.2)
guide.plot_point(panels[1], p, "$p$", guide.BLUE)
guide.plot_point(panels[1], q, "$q$", guide.ORANGE)
handovers = subproblems.subproblem_2(about_z, about_x, p, q).values
assert len(handovers) == 2
for pair in handovers:
    guide.plot_point(
        panels[1], (screws.exp(about_x, pair[1]) @ np.append(p, 1))[:3], "", guide.INK, "D"
    )

p, q, delta = np.array([0.75, 0.0, 0.2]), np.array([0.1, 0.7, 0.2]), 0.55
guide.plot_screw(panels[2], about_z, 1.7, r"$\xi$")
panels[2].plot(*circle(about_z, p).T, color=guide.GREY, linestyle="-", linewidth=1.2)
guide.plot_point(panels[2], p, "$p$", guide.BLUE)
guide.plot_point(panels[2], q, "$q$", guide.ORANGE)
a, b = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(0, np.pi, 13))
ball = q[:, None, None] + delta * np.array([np.cos(a) * np.sin(b), np.sin(a) * np.sin(b), np.cos(b)])
panels[2].plot_wireframe(*ball, color=guide.ORANGE, linewidth=0.4, alpha=0.5)
meetings = subproblems.subproblem_3(about_z, p, q, delta).values
assert len(meetings) == 2
for value in meetings:
    guide.plot_point(panels[2], (screws.exp(about_z, value) @ np.append(p, 1))[:3], "", guide.INK, "D")
for ax, words in zip(panels, ("1: to a point", "2: by two axes", "3: to a distance"), strict=True):
    ax.set_title(words)
    guide.fit(ax, [[-0.85] * 3, [0.85] * 3])
guide.figure(
    fig,
    "Three drawings: a circle about an axis from p to q; two circles about two axes that cross in two marked points; a "
    "circle that meets a sphere about q in two marked points",
    "The three subproblems. Diamonds mark the answers where there are two.",
)

# %% [markdown]
# ## A wrist divides the question
#
# Now six joints, the elbow arm of MLS: two axes that meet in the shoulder, an elbow, and a wrist of three axes that
# meet in one point $q_w$. All six together are to bring the tool to $g_d$. Move the home pose to the other side:
#
# $$e^{\hat\xi_1\theta_1} \cdots e^{\hat\xi_6\theta_6} = g_d\, g_{st}(0)^{-1} =: g_1$$
#
# A point on an axis stays where it is when that joint turns. That is the whole trick, used four times:
#
# 1. $q_w$ lies on the last three axes. Apply both sides to it and these three are gone:
#    $e^{\hat\xi_1\theta_1} e^{\hat\xi_2\theta_2} e^{\hat\xi_3\theta_3}\, q_w = g_1\, q_w$.
# 2. The shoulder point $q_b$ lies on the first two. They do not change a distance from it, so that
#    $\|e^{\hat\xi_3\theta_3} q_w - q_b \| = \|g_1 q_w - q_b \|$: subproblem 3 for $\theta_3$.
# 3. With $\theta_3$ known, subproblem 2 gives $\theta_1$ and $\theta_2$.
# 4. With all three known, the wrist has to do the rest. A point on the last axis alone gives $\theta_4$ and $\theta_5$
#    (subproblem 2). A point beside it gives $\theta_6$ (subproblem 1).
#
# Two answers in step 2, two in step 3, two in step 4. This is the method of MLS, section 3.3.3; that three axes which
# meet are enough was shown by Pieper in 1968.

# %%
elbow_arm = guide.bundled("elbow")
xi = elbow_arm.screws.T


def meeting_point(*twists):
    """The point nearest to the axes of some twists: where they meet, if they do."""
    across = [np.eye(3) - np.outer(x[3:], x[3:]) for x in twists]
    on_axis = [np.cross(x[3:], x[:3]) for x in twists]
    moments = [P @ q for P, q in zip(across, on_axis, strict=True)]
    return np.linalg.solve(sum(across), sum(moments))


def apply(g, p):
    """Where a rigid motion takes a point."""
    return g[:3, :3] @ p + g[:3, 3]


q_b, q_w = meeting_point(xi[0], xi[1]), meeting_point(xi[3], xi[4], xi[5])
on_6, beside = q_w + xi[5, 3:], q_w + xi[4, 3:]


def ways(g_d):
    """All configurations of the elbow arm with its tool at g_d, by subproblems."""
    g_1 = g_d @ screws.inverse(elbow_arm.home)
    there = apply(g_1, q_w)
    far = np.linalg.norm(there - q_b)
    for t3 in subproblems.subproblem_3(xi[2], q_w, q_b, far).values:
        e_3 = screws.exp(xi[2], t3)
        wrist = apply(e_3, q_w)
        for t1, t2 in subproblems.subproblem_2(xi[0], xi[1], wrist, there).values:
            before = screws.exp(xi[0], t1) @ screws.exp(xi[1], t2) @ e_3
            g_2 = screws.inverse(before) @ g_1  # what the wrist has to do
            goal = apply(g_2, on_6)
            for t4, t5 in subproblems.subproblem_2(xi[3], xi[4], on_6, goal).values:
                so_far = screws.exp(xi[3], t4) @ screws.exp(xi[4], t5)
                goal = apply(screws.inverse(so_far) @ g_2, beside)
                t6 = subproblems.subproblem_1(xi[5], beside, goal).values[0]
                yield np.array([t1, t2, t3, t4, t5, t6])


meant = np.array([0.4, -0.7, 1.3, 0.5, 0.8, -0.3])
g_d = elbow_arm.fk(meant)
eight = np.array(list(ways(g_d)))
guide.predict(
    "How many configurations come out, and how many of them really hold the tool at the target?",
    f"{len(eight)}: two for the elbow, times two for the shoulder, times two for the wrist. Put back into forward "
    f"kinematics, all {len(eight)} meet the target, to ${guide.rough(np.abs(elbow_arm.fk(eight) - g_d).max())}$.",
)
assert len(eight) == 8
assert np.allclose(elbow_arm.fk(eight), g_d, atol=1e-9)

# %% [markdown]
# There is a solver in twistarm that goes the same way for every arm with such a group of axes, and checks each answer.
# It must find the same eight.


# %%
def wrap(angle):
    """The same direction, in (−π, π]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


by_twistarm = solve_ik_all(elbow_arm, g_d)
everything = np.array([*by_twistarm, *by_twistarm.outside])
assert by_twistarm.complete
assert len(everything) == len(eight)
for theta in eight:
    assert np.abs(wrap(everything - theta)).max(axis=1).min() < 1e-6

# %% [markdown]
# The two wrists of a posture are each other's flip: the middle joint bends to the other side, and its two neighbours
# turn by half a turn to make up for it. For a wrist with axes $z$, $y$, $z$ these are the ZYZ angles of your first
# lesson, told in two ways:
#
# $$R_z(\alpha)\, R_y(\beta)\, R_z(\gamma) = R_z(\alpha + \pi)\, R_y(-\beta)\, R_z(\gamma + \pi)$$

# %%
zyz = np.array([0.5, 0.8, -0.3])
flip = np.array([zyz[0] + np.pi, -zyz[1], zyz[2] + np.pi])
assert np.allclose(rotations.from_euler("ZYZ", zyz), rotations.from_euler("ZYZ", flip))

# %% tags=["hidden"]
SHADES = (guide.BLUE, guide.ORANGE, guide.GREEN, guide.PINK)


def in_words(value, unit):
    """A joint's value for a table."""
    return (f"{np.degrees(value) + 0.0:.0f}°" if unit == "rad" else f"{value + 0.0:.3f} m").replace(
        "-", "−"
    )


def draw_all(arm, configurations, words):
    """Every configuration: those whose links are the same on one panel, four panels at most."""
    shapes = []
    for theta in configurations:
        points = guide.arm_points(arm, theta)
        for shape in shapes:
            if np.abs(shape[0] - points).max() < 1e-3 * arm.reach:
                shape[1].append(theta)
                break
        else:
            shapes.append((points, [theta]))
    columns = min(4, len(shapes))
    everywhere = np.vstack([points for points, _ in shapes])
    tool = everywhere[len(shapes[0][0]) - 1]
    across = float(np.degrees(np.arctan2(tool[1], tool[0]))) - 70.0  # looked at from the side
    fig, panels = guide.axes3(
        columns=columns, width=6.6 if columns > 1 else 4.0, height=3.0, box=False, elev=15, azim=across
    )
    for j, ax in enumerate(np.atleast_1d(panels)):
        group = shapes[j::columns]
        for i, (_, same) in enumerate(group):
            guide.plot_arm(ax, arm, same[0], SHADES[(j + i) % 4], 1.0 if i == 0 else 0.45, tool=i == 0)
        count = sum(len(same) for _, same in group)
        ax.set_title(f"{count} way{'s' * (count > 1)}")
        guide.fit(ax, everywhere)
    guide.figure(
        fig,
        f"{arm.name} with its tool at one and the same pose, drawn for {len(configurations)} different configurations "
        f"on {columns} panels",
        words,
    )


draw_all(
    elbow_arm,
    eight,
    "The eight ways of the elbow arm, four on each panel. Those four have their links in the same places: the "
    "shoulder may "
    "be turned round and bend over backwards, and the wrist may be turned round too.",
)

# %% [markdown]
# ## Your arm
#
# What can be asked of an arm depends on how many joints it has. Six joints can be asked for a **pose**. Five cannot
# meet every pose; they can be asked for a position and the direction in which the tool points, with the roll about that
# direction left free. That is an **approach**. Fewer joints meet only the poses that they happen to make. So let us
# take a posture of your arm, look where its tool is, and ask for all ways to bring it there.

# %%
own = guide.arm()
rng = np.random.default_rng(4)
theta = own.ready + 0.25 * (own.random_theta(rng) - own.ready)
theta = np.clip(theta, own.limits.lower, own.limits.upper)
g = own.fk(theta)
target = Approach(g[:3, 3], g[:3, :3] @ own.tool_axis) if own.n == 5 else Pose(g)
found = solve_ik_all(own, target, theta)

# %% tags=["hidden"]
if not found.complete and any(found.free):
    held = found.free[0][0]
    guide.say(
        f"`{own.name}` has {own.n} joints, more than the target fixes: the ways are not a number but curves, and "
        f"the arm "
        f"can move along each while the tool stands still. Hold one joint, and they are a number again. Here `{held}` "
        f"stands at {in_words(theta[own.joint_names.index(held)], own.units[own.joint_names.index(held)])}."
    )
    found = solve_ik_all(own, target, theta, given={held: float(theta[own.joint_names.index(held)])})
assert np.abs(found.theta - theta).max(axis=1).min() < 1e-4 if len(found) else False, (
    "the posture itself is among them"
)
assert (found.position_error < 1e-6).all()
assert (found.orientation_error < 1e-6).all()
asked = "the position and direction of its tool" if own.n == 5 else "the pose of its tool"
total = len(found) + len(found.outside)
guide.predict(
    f"`{own.name}` has {own.n} joints. In how many ways does it reach {asked}? And in how many, if its joints had no "
    "limits?",
    f"In {len(found)} inside its limits, in {total} without them"
    + (", and there are no others" if found.complete else "; there may be more")
    + f". They were found by {found.method}: {found.family}.",
)

# %% tags=["hidden"]
listed = [(each, "yes") for each in found] + [(each, "no") for each in found.outside]
guide.table(
    ["way", *(f"`{name}`" for name in own.joint_names), "inside the limits"],
    [
        [str(i), *(in_words(v, u) for v, u in zip(each, own.units, strict=True)), inside]
        for i, (each, inside) in enumerate(listed[:16], start=1)
    ],
    f"The ways of `{own.name}`, nearest to where it stands first.",
)
draw_all(own, [each for each, _ in listed[:16]], f"`{own.name}`, every way from the table.")
guide.say("What the solver says of itself:\n\n```text\n" + found.explain() + "\n```")

# %% [markdown]
# The solver says *which* group of axes made it easy: axes that meet in a point leave the point alone, and parallel axes
# leave every plane across them alone. Both let you drop three unknowns at once. Six joints that turn with neither are
# solved by elimination, an eigenvalue problem, and may have sixteen ways (MLS, section 3.3.4).
#
# ## The flips of a rover arm
#
# The bundled rover arm has a slide, three parallel pitches and a roll. Its slide alone settles where the tool is across
# the plane of the pitches. The roll settles nothing that an approach asks. There remain three parallel joints in a
# plane, for a point and a direction: the two-link arm, with a third link that points where it must.

# %%
rover = guide.bundled("rover_arm")
g = rover.fk(rover.ready)
flips = solve_ik_all(rover, Approach(g[:3, 3], g[:3, :3] @ rover.tool_axis), rover.ready)
both = np.array([*flips, *flips.outside])
assert flips.complete
assert len(both) == 2
assert np.isclose(both[0, 2], -both[1, 2])  # the elbow bends to the other side by as much
assert np.isclose(both[0, 1:4].sum(), both[1, 1:4].sum())  # the tool points the same way

# %% tags=["hidden"]
if own.name == rover.name:
    guide.say(
        f"It is the arm that you have just seen, with its {len(both)} ways. Where it waits, the elbow bends by "
        f"{in_words(abs(both[0, 2]), 'rad')} to the one side or to the other, and the three pitches add up to the "
        "same."
    )
else:
    guide.table(
        [f"`{name}`" for name in rover.joint_names],
        [[in_words(v, u) for v, u in zip(each, rover.units, strict=True)] for each in both],
        f"Both ways; {len(flips)} inside the limits.",
    )
    draw_all(
        rover,
        both,
        "`rover_arm`: elbow up and elbow down, with the tool in the same place and direction.",
    )

# %% [markdown]
# ## The eight of a UR5
#
# A UR5 has no wrist whose axes meet. Its second, third and fourth axes are parallel, and that does as well. The six
# lengths below are the maker's; they are all that is needed.

# %%
d1, a2, a3, d4, d5, d6 = 0.089159, 0.425, 0.39225, 0.10915, 0.09465, 0.0823  # [m]
x, y, z = np.eye(3)
axes = [(z, 0 * x), (y, d1 * z), (y, a2 * x + d1 * z), (y, (a2 + a3) * x + d1 * z),
        (-z, (a2 + a3) * x + d4 * y), (y, (a2 + a3) * x + (d1 - d5) * z)]  # fmt: skip
home = np.eye(4)
home[:3, :3] = np.column_stack([-x, z, y])
home[:3, 3] = (a2 + a3) * x + (d4 + d6) * y + (d1 - d5) * z
twists = np.column_stack([np.append(-np.cross(w, q), w) for w, q in axes])
ur5 = arm_from_screws(twists, home, name="ur5")

standing = np.radians([20.0, -70.0, 95.0, -60.0, -80.0, 30.0])
g = ur5.fk(standing)
eight = solve_ik_all(ur5, g, standing)
assert eight.complete
assert len(eight) == 8

# %% tags=["hidden"]
guide.table(
    ["way", *(f"$\\theta_{i}$" for i in range(1, 7))],
    [[str(i), *(in_words(wrap(v), "rad") for v in each)] for i, each in enumerate(eight, start=1)],
    "All configurations of a UR5 for one pose: left or right shoulder, elbow up or down, wrist flipped or not.",
)
draw_all(ur5, list(eight), "The eight ways of a UR5, two on each panel.")

# %% [markdown]
# ## What goes wrong in practice
#
# - **Whole turns counted as ways.** 190° and −170° are one posture. Wrap before you compare. But for the cable they are
#   not the same: `solve_ik_all(…, copies=True)` lists both.
# - **The first of the list, every time.** Along a path, take the answer nearest to the last one, or the arm changes
#   elbows on the way.
# - **Solving first, limits last.** A closed form knows no limits. What it returns may be outside all of them.
# - **A wrist that does not quite meet.** The closed form believes that three axes meet in a point. If the bracket holds
#   one of them a little beside, the tool is off by about as much, and nobody reports an error.
# - **Singular.** With two wrist axes in line the ways are no longer separate: a joint may turn forward and another one
#   back. An answer with `free` joints says so.

# %% tags=["hidden"]
bracket = 0.003  # [m]
off_axes = elbow_arm.screws.copy()
shift = bracket * np.cross(off_axes[3:, 4], off_axes[3:, 3])
off_axes[:3, 4] -= np.cross(off_axes[3:, 4], shift)
off = np.linalg.norm(poe.fk(off_axes, elbow_arm.home, meant)[:3, 3] - g_d[:3, 3])
in_line = meant.copy()
in_line[4] = np.pi / 2  # the last axis lies along the fourth
singular = solve_ik_all(elbow_arm, elbow_arm.fk(in_line), in_line)
nearest = [names for names in singular.free if names]
assert nearest, "a wrist in line leaves two joints free against each other"
guide.table(
    ["slip", "how it shows"],
    [
        [
            f"the middle wrist axis is {1000 * bracket:.0f} mm beside the others",
            f"the elbow arm's tool is {1000 * off:.1f} mm off",
        ],
        [
            "the first and last wrist axis in line",
            f"{len(singular)} ways listed, with free joints: "
            + ", ".join(f"`{name}`" for name in nearest[0]),
        ],
        [
            "a new elbow between two points of a path",
            f"a joint jumps by {in_words(np.abs(both[0] - both[1]).max(), 'rad')}",
        ],
    ],
    "The slips, by their numbers.",
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_2_all_solutions")
