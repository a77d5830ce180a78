# %% [markdown]
# # How many configurations are there?
#
# The gripper is where it should be, but the forearm touches the camera mast. Is there another configuration with
# exactly the same pose of the gripper? For two links in a plane the answer was the flip. An arm of six turning joints
# usually has several such configurations, at most sixteen. This lesson splits the question into three subproblems. It
# combines them for an arm with a wrist, and then counts the configurations of your own arm.

# %%
import numpy as np

from twistarm import Approach, Pose, guide, poe, screws, solve_ik_all, subproblems


def turning(arm):
    """Which joints turn."""
    return np.flatnonzero(np.linalg.norm(arm.screws[3:], axis=0) > 0.5)


arm = guide.arm_with("a joint that turns", lambda a: len(turning(a)) > 0)

# %% [markdown]
# ## Three small questions
#
# A joint that turns carries a point around a circle. All that follows uses such circles. Let $\omega$ be the direction
# of the joint's axis, a unit vector, and $r$ a point on the axis. Take the vectors $u$ and $v$ from $r$ to two points
# $p$ and $q$. Split each into a part along the axis and a part across it. The matrix $I - \omega\omega^T$ removes the
# part along the axis:
#
# $$u = p - r, \qquad v = q - r, \qquad u' = (I - \omega\omega^T)\, u, \qquad v' = (I - \omega\omega^T)\, v$$
#
# The three questions are the *Paden–Kahan subproblems*. Source: Murray, Li and Sastry, *A Mathematical Introduction to
# Robotic Manipulation* (MLS), section 3.3.2.
#
# **Subproblem 1.** Which angle of the joint brings $p$ to $q$? The angle from $u'$ to $v'$:
#
# $$e^{\hat\xi\theta}\, p = q \quad\Rightarrow\quad
#   \theta = \mathrm{atan2}\big(\omega^T (u' \times v'),\; u'^T v'\big)$$
#
# There is an answer only if $p$ and $q$ are equally far from the axis and equally far along it. If $p$ lies on the
# axis, $u' = 0$. The joint does not move it, and every angle is an answer.
#
# **Subproblem 2.** Two joints with axes that meet in $r$ bring $p$ to $q$: $e^{\hat\xi_1\theta_1}
# e^{\hat\xi_2\theta_2}\, p = q$. The second joint takes $p$ to a point $c$ of the circle through $p$ about its axis.
# The first joint takes $c$ to $q$, so $c$ also lies on the circle through $q$ about the first axis. The circles cross
# in $c$. Each of the two turns is subproblem 1. Write
#
# $$c = r + \alpha\,\omega_1 + \beta\,\omega_2 + \gamma\,(\omega_1 \times \omega_2)$$
#
# The first joint does not change the coordinate along $\omega_1$, so $c$ has that of $q$. In the same way $c$ has the
# coordinate of $p$ along $\omega_2$. Neither joint changes the distance from $r$:
#
# $$\alpha + \beta\,\omega_1^T\omega_2 = \omega_1^T v, \qquad \alpha\,\omega_1^T\omega_2 + \beta = \omega_2^T u$$
#
# $$\gamma^2 = \frac{\|u\|^2 - \alpha^2 - \beta^2 - 2\alpha\beta\,\omega_1^T\omega_2}{\|\omega_1 \times \omega_2\|^2}$$
#
# The sign of $\gamma^2$ decides: two crossings, one, or none. If both axes are one line, the equations for $\alpha$ and
# $\beta$ have no unique answer. The two joints then act as one, and only the sum (or difference) of their angles
# matters.
#
# **Subproblem 3.** Which angle of the joint brings $p$ to the distance $\delta$ from $q$, $\|e^{\hat\xi\theta} p -
# q\| = \delta$? A circle meets a sphere in two points, in one, or not at all. This is the elbow of the last lesson,
# and the law of cosines solves it. The distance along the axis does not change. Across the axis the distance must be
# $\delta'$, with $\delta'^2 = \delta^2 - (\omega^T (p - q))^2$. With $\theta_0$ for the angle from $u'$ to $v'$ of
# subproblem 1:
#
# $$\theta = \theta_0 \pm \arccos \frac{\|u'\|^2 + \|v'\|^2 - \delta'^2}{2\, \|u'\|\, \|v'\|}$$
#
# If $p$ or $q$ lies on the axis, the distance never changes. Then every angle is an answer, or none is.


# %% tags=["shown"]
def turn_to(xi, p, q):
    """Subproblem 1, for a joint that turns."""
    w, r = xi[3:], np.cross(xi[3:], xi[:3])  # ω, and a point on the axis
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


# %%
k = int(turning(arm)[0])
xi = arm.screws[:, k]
beside_the_tool = arm.reach * np.array([0.1, 0.07, 0.05])
finger = (arm.home @ np.append(beside_the_tool, 1))[:3]
moved = (screws.exp(xi, 0.7) @ np.append(finger, 1))[:3]

half_way = np.linalg.norm((screws.exp(xi, 0.4) @ np.append(finger, 1))[:3] - moved)
both = turns_to_distance(xi, finger, moved, half_way)
guide.say(
    f"A point on the gripper of `{arm.name}`, turned by `{arm.moving_names[k]}` from ${guide.tex(finger)}$ to "
    f"${guide.tex(moved)}$ m: subproblem 1 returns {np.degrees(turn_to(xi, finger, moved)):.2f}°, the angle "
    f"of this turn."
    " `twistarm.subproblems` has all three, for joints that slide too."
)

# %%
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
w1, w2 = about_z[3:], about_x[3:]  # both axes pass through the origin, r = 0
mixed = w1 @ w2
a, b = np.linalg.solve([[1, mixed], [mixed, 1]], [w1 @ q, w2 @ p])
normal = np.cross(w1, w2)
c = np.sqrt((p @ p - a**2 - b**2 - 2 * a * b * mixed) / (normal @ normal))
crossings = [a * w1 + b * w2 + sign * c * normal for sign in (1, -1)]
for crossing in crossings:
    guide.plot_point(panels[1], crossing, "", guide.INK, "D")
guide.plot_point(panels[1], crossings[0], "$c$", guide.INK, "D")

p, q, delta = np.array([0.75, 0.0, 0.2]), np.array([0.1, 0.7, 0.2]), 0.55
guide.plot_screw(panels[2], about_z, 1.7, r"$\xi$")
panels[2].plot(*circle(about_z, p).T, color=guide.GREY, linestyle="-", linewidth=1.2)
guide.plot_point(panels[2], p, "$p$", guide.BLUE)
guide.plot_point(panels[2], q, "$q$", guide.ORANGE)
a, b = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(0, np.pi, 13))
ball = q[:, None, None] + delta * np.array([np.cos(a) * np.sin(b), np.sin(a) * np.sin(b), np.cos(b)])
panels[2].plot_wireframe(*ball, color=guide.ORANGE, linewidth=0.4, alpha=0.5)
meetings = subproblems.subproblem_3(about_z, p, q, delta).values
for value in meetings:
    guide.plot_point(panels[2], (screws.exp(about_z, value) @ np.append(p, 1))[:3], "", guide.INK, "D")
for ax, words in zip(panels, ("1: to a point", "2: by two axes", "3: to a distance"), strict=True):
    ax.set_title(words)
guide.figure(
    fig,
    "Three drawings: a circle about an axis from p to q; two circles about two axes that cross in two marked points; a "
    "circle that meets a sphere about q in two marked points",
    "The three subproblems. Diamonds: the places where $p$ can be, two in subproblems 2 and 3.",
)

# %% [markdown]
# ## A wrist divides the problem
#
# Now take six joints, the elbow arm of MLS. Its first two axes meet in the shoulder point $r_b$. Then comes an elbow.
# The last three axes, the wrist, meet in one point $r_w$. The tool shall come to $g_d$. Multiply by the inverse of the
# home pose from the right, and call the result $g_1$:
#
# $$e^{\hat\xi_1\theta_1} \cdots e^{\hat\xi_6\theta_6} = g_1, \qquad g_1 = g_d\, g_{st}(0)^{-1}$$
#
# A point on an axis does not move when that joint turns. The method uses this four times:
#
# 1. $r_w$ lies on the last three axes. Apply both sides to it, and these three joints drop out: $e^{\hat\xi_1\theta_1}
#    e^{\hat\xi_2\theta_2} e^{\hat\xi_3\theta_3}\, r_w = g_1\, r_w$.
# 2. $r_b$ lies on the first two. These joints do not change a distance from it, so $\|e^{\hat\xi_3\theta_3} r_w - r_b
#    \| = \|g_1 r_w - r_b \|$: subproblem 3 for $\theta_3$.
# 3. With $\theta_3$ known, subproblem 2 gives $\theta_1$ and $\theta_2$.
# 4. With these three known, only the wrist remains. A point on the last axis alone gives $\theta_4$ and $\theta_5$
#    (subproblem 2). A point beside this axis gives $\theta_6$ (subproblem 1).
#
# Steps 2, 3 and 4 have two answers each. This is the method of MLS, section 3.3.3. Pieper showed in 1968 that three
# axes through one point are enough.

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


r_b, r_w = meeting_point(xi[0], xi[1]), meeting_point(xi[3], xi[4], xi[5])
on_6, beside = r_w + xi[5, 3:], r_w + xi[4, 3:]


def ways(g_d):
    """All configurations of the elbow arm with its tool at g_d, by subproblems."""
    g_1 = g_d @ screws.inverse(elbow_arm.home)
    there = apply(g_1, r_w)
    far = np.linalg.norm(there - r_b)
    for t3 in subproblems.subproblem_3(xi[2], r_w, r_b, far).values:
        e_3 = screws.exp(xi[2], t3)
        wrist = apply(e_3, r_w)
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
    "How many configurations does this give, and how many of them really bring the tool to the target?",
    f"{len(eight)}: two for the elbow, times two for the shoulder, times two for the wrist. By forward "
    f"kinematics all {len(eight)} reach the target, to"
    f" ${guide.rough(np.abs(elbow_arm.fk(eight) - g_d).max())}$.",
)

# %% [markdown]
# `solve_ik_all` of twistarm works in the same way for every arm with such a group of axes, and checks each answer. It
# finds the same eight.


# %% [markdown]
# The two wrists are each other's flip. The middle joint bends to the other side, and its two neighbours compensate by
# half a turn each. For a wrist with the axes $z$, $y$, $z$ these are the ZYZ angles of your first lesson. They have two
# triples for one rotation:
#
# $$R_z(\theta_4)\, R_y(\theta_5)\, R_z(\theta_6) = R_z(\theta_4 + \pi)\, R_y(-\theta_5)\, R_z(\theta_6 + \pi)$$

# %%
SHADES = (guide.BLUE, guide.ORANGE, guide.GREEN, guide.PINK)


def in_words(value, unit):
    """A joint's value for a table."""
    return (f"{np.degrees(value) + 0.0:.0f}°" if unit == "rad" else f"{value + 0.0:.3f} m").replace(
        "-", "−"
    )


def draw_all(arm, configurations, words):
    """Every configuration, with equal links on one panel, four panels at most."""
    shapes = []
    for theta in configurations:
        points = guide.arm_points(arm, theta)
        for shape in shapes:
            if np.abs(shape[0] - points).max() < 1e-3 * arm.reach:
                shape[1].append(theta)
                break
        else:
            shapes.append((points, [theta]))
    tool = arm.fk(configurations[0])
    across = float(np.degrees(np.arctan2(tool[1, 3], tool[0, 3]))) - 70.0  # looked at from the side
    groups = [shapes[j::4] for j in range(min(4, len(shapes)))]
    for first in range(0, len(groups), 2):
        row = groups[first : first + 2]
        ways = [sum(len(same) for _, same in group) for group in row]
        width = 6.6 if len(row) > 1 else 4.0
        fig, panels = guide.axes3(len(row), width=width, height=3.2, box=False, elev=15, azim=across)
        for j, (ax, group) in enumerate(zip(np.atleast_1d(panels), row, strict=True)):
            for i, (_, same) in enumerate(group):
                shade = SHADES[(first + j + i) % 4]
                guide.plot_arm(ax, arm, same[0], shade, 1.0 if i == 0 else 0.45, tool=i == 0)
            ax.set_title(f"{ways[j]} configuration{'s' * (ways[j] > 1)}")
        guide.figure(
            fig,
            f"{arm.name} with its tool at one and the same place, in {sum(ways)} of its configurations, on "
            f"{len(row)} panel{'s' * (len(row) > 1)}",
            words if first == 0 else "The other configurations.",
        )


draw_all(
    elbow_arm,
    eight,
    "All eight configurations of the elbow arm. The four of a panel look alike, because their links lie in the same "
    "places: the shoulder may turn round and bend backwards, and the wrist may be flipped.",
)

# %% [markdown]
# ## Your arm
#
# The number of joints decides which targets an arm can reach. Six joints reach a **pose**. Five joints cannot reach
# every pose. Ask them for an **approach**: the position of the tool and the direction in which it points. These are
# five numbers; the roll about the direction is free. Fewer joints reach only few poses. So take a configuration of your
# arm, compute the pose of its tool, and ask for all configurations that reach it.

# %%
own = guide.arm()
rng = np.random.default_rng(4)
theta = own.ready + 0.25 * (own.random_theta(rng) - own.ready)
theta = np.clip(theta, own.limits.lower, own.limits.upper)
g = own.fk(theta)
target = Approach(g[:3, 3], g[:3, :3] @ own.tool_axis) if own.n == 5 else Pose(g)
found = solve_ik_all(own, target, theta)

free = next((names for names in found.free if names), ())

# %%
held = ""
if free:
    k = own.joint_names.index(free[0])
    held = f", with `{free[0]}` held at {in_words(theta[k], own.units[k])}"
    roll = np.append([0, 0, 0], own.tool_axis)
    rows = (np.eye(6) - np.outer(roll, roll)) / np.repeat([own.reach, 1.0], 3)
    rank = int(np.linalg.matrix_rank(rows @ own.body_jacobian(theta), tol=1e-6))
    guide.say(
        f"`{own.name}` has infinitely many configurations there, which form curves: "
        + " and ".join(f"`{name}`" for name in free)
        + " may move while the tool stays at the target. "
        + (
            f"It has five joints for the five numbers of an approach, but can change only {rank} of these numbers "
            "independently. It reaches this target because it is there already. It cannot reach most other targets. "
            if own.n == 5 and rank < 5
            else ""
        )
        + "If you hold this joint, their number is finite again."
    )
    found = solve_ik_all(own, target, theta, fixed_joints={free[0]: float(theta[k])})
goal_words = "the position and direction of its tool" if own.n == 5 else "the pose of its tool"
total = len(found) + len(found.outside)
guide.predict(
    f"`{own.name}` has {own.n} joints. In how many configurations does it reach {goal_words}"
    + (", with that joint held" if free else "")
    + "? And in how many without joint limits?",
    f"In {len(found)} inside its limits and in {total} without them{held}"
    + (". There are no others" if found.complete else ". There may be more")
    + f". They were found by {found.method}: {found.family}.",
)

# %%
labelled = [(way, "yes") for way in found] + [(way, "no") for way in found.outside]
guide.table(
    ["", *(f"`{name}`" for name in own.joint_names), "inside the limits"],
    [
        [str(i), *(in_words(v, u) for v, u in zip(way, own.units, strict=True)), inside]
        for i, (way, inside) in enumerate(labelled[:16], start=1)
    ],
    f"The configurations of `{own.name}`, the nearest to the present configuration first.",
)
draw_all(own, [way for way, _ in labelled[:16]], f"`{own.name}`, every configuration from the table.")
guide.scene(
    elbow_arm,
    meant,
    caption="The elbow arm. The other configurations with the same pose are drawn faintly. Step through them with N and P.",
    quantity="configurations",
)
guide.say("The solver's own explanation:\n\n```text\n" + found.explain() + "\n```")

# %% [markdown]
# The solver says *which* group of axes it used. Axes that meet in a point do not move this point. Parallel axes do not
# move the planes at right angles to them. In both cases three unknowns drop out at once. So a UR5 has its eight
# configurations without a wrist with intersecting axes. Six turning joints with neither need the eigenvalues of a
# matrix, and may have sixteen configurations (MLS, section 3.3.4).
#
# The bundled rover arm is another case. It has a slide, three parallel pitch joints and a roll, and its target is an
# approach. The slide alone sets the position across the plane of the pitch joints. The roll turns the tool about the
# direction in which it points, which an approach leaves free. Three parallel joints in a plane remain, for a point and
# a direction. They are the two-link arm with a third link whose direction is given. So there are two configurations:
# the elbow bends to either side, and the three pitch angles have the same sum.
#
# ## What goes wrong in practice
#
# - **Whole turns counted twice.** 190° and −170° are the same pose of a link. Wrap angles before you compare them.
#   For a cable they differ: `solve_ik_all(…, include_turns=True)` lists both.
# - **The first of the list, every time.** Along a path, take the answer nearest to the last one. Otherwise the elbow
#   flips on the way.
# - **Limits forgotten.** A closed form ignores limits. All its answers may be outside them.
# - **A wrist that does not quite meet.** The closed form assumes that three axes meet in a point. If one of them is a
#   few millimetres beside it, the tool is off by about as much. No error appears.
# - **Infinitely many configurations.** If two wrist axes lie on one line, one joint may turn forward and the other
#   back. If the wrist point lies on the axis of the base joint, that joint may have any angle. The answer then lists
#   these joints as `free`.

# %%
bracket = 0.003  # [m]
off_axes = elbow_arm.screws.copy()
shift = bracket * np.cross(off_axes[3:, 4], off_axes[3:, 3])
off_axes[:3, 4] -= np.cross(off_axes[3:, 4], shift)
off = np.linalg.norm(poe.fk(off_axes, elbow_arm.home, meant)[:3, 3] - g_d[:3, 3])
in_line = meant.copy()
in_line[4] = np.pi / 2  # the last axis lies along the fourth
above = meant.copy()  # joint 2 brings the wrist point onto the axis of joint 1
elbowed = apply(screws.exp(xi[2], meant[2]), r_w)
above[1] = turn_to(xi[1], elbowed, r_b + np.linalg.norm(elbowed - r_b) * xi[0, 3:])
free_at = []
for configuration in (in_line, above):
    ways_there = solve_ik_all(elbow_arm, elbow_arm.fk(configuration), configuration)
    free_at.append(next((names for names in ways_there.free if names), ()))
guide.table(
    ["mistake", "how it shows"],
    [
        [
            f"the middle wrist axis is {1000 * bracket:.0f} mm beside the others",
            f"the elbow arm's tool is {1000 * off:.1f} mm off",
        ],
        *(
            [
                words,
                "infinitely many configurations; these may move: "
                + ", ".join(f"`{name}`" for name in names),
            ]
            for words, names in zip(
                ("first and last wrist axis on one line", "wrist point on the axis of the base joint"),
                free_at,
                strict=True,
            )
        ),
        [
            "a new elbow between two points of a path",
            f"a joint jumps by {in_words(np.abs(eight[0] - eight[-1]).max(), 'rad')}",
        ],
    ],
    "The mistakes in numbers.",
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_2_all_solutions")
