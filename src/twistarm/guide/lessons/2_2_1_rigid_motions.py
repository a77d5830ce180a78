# %% [markdown]
# # Rigid motions
#
# A camera on a link of your arm sees a rock and reports its position, measured from the lens. The gripper holds a
# screwdriver, and its tip shall touch the rock. Where is the rock, seen from the base? Where is the tip? And how far
# must the tip go to touch the rock?
#
# To answer, you change from one frame to another. This lesson puts a turn and a shift into one matrix. To change the
# frame, you then multiply.
#
# ## The law
#
# A **rigid motion** keeps every distance, and it keeps a right-handed frame right-handed. Every such motion is a turn
# and a shift. Source: Murray, Li and Sastry, *A Mathematical Introduction to Robotic Manipulation* (MLS), section 2.1.
# Let $R_{st}$ be the orientation of frame T seen from S, and $p_{st}$ the position of its origin. A point with the
# coordinates $q_t$ in T has the coordinates in S
#
# $$q_s = R_{st}\,q_t + p_{st}$$
#
# Put a 1 under each point, $\bar q = (q, 1)$, and this becomes a product with one $4\times 4$ matrix:
#
# $$\bar q_s = \begin{bmatrix} q_s \\ 1 \end{bmatrix}
# = \begin{bmatrix} R_{st} & p_{st} \\ 0 & 1 \end{bmatrix} \begin{bmatrix} q_t \\ 1 \end{bmatrix} = g_{st}\,\bar q_t$$
#
# The matrix $g_{st}$ is called the **pose** of T seen from S. The set of all of them, with $p \in \mathbb{R}^3$ and
# $R \in SO(3)$, is called $SE(3)$, the *special Euclidean group*. Source: MLS, section 2.3.1.
#
# A **vector** is the difference of two points, so its last entry is 0. The shift then drops out, as it should: a
# direction does not change when the origin moves.
#
# Your arm has four frames here. S is the base, T the tool, F the tip of a screwdriver in the gripper, and C a camera.

# %%
import numpy as np

from twistarm import guide, rotations, screws

arm = guide.arm()
theta = 0.6 * arm.ready + 0.4 * arm.random_theta(5)  # between ready and a random configuration
g_st = arm.fk(theta)
point = np.array([0.0, 0.0, 0.12, 1.0])  # the tip of a screwdriver, in the tool's axes [m]
vector = np.array([0.0, 0.0, 0.12, 0.0])  # the direction and length of its blade
guide.table(
    ["", "$x$ [m]", "$y$ [m]", "$z$ [m]", "last"],
    [["the tip, a point", *(g_st @ point)], ["the blade, a vector", *(g_st @ vector)]],
    f"The same three numbers with a 1 and with a 0 below them, taken from the tool of `{arm.name}` to its base.",
)

# %% [markdown]
# ## Frames in a row
#
# Frame F seen from T, and T seen from S, give F seen from S:
#
# $$g_{sf} = g_{st}\,g_{tf} = \begin{bmatrix} R_{st}R_{tf} & R_{st}\,p_{tf} + p_{st} \\ 0 & 1 \end{bmatrix}$$
#
# The letters that meet in the middle cancel. Check each product by its letters.
#
# Frame F at the tip of the screwdriver is shifted along the tool's $z$ axis and tilted about its $x$ axis.

# %%
g_tf = np.eye(4)
g_tf[:3, :3], g_tf[:3, 3] = rotations.exp([1, 0, 0], 0.5), point[:3]
g_sf, swapped = g_st @ g_tf, g_tf @ g_st
miss = np.linalg.norm((g_sf - swapped)[:3, 3])
guide.predict(
    "A teammate writes $g_{tf}\\,g_{st}$ instead of $g_{st}\\,g_{tf}$. Does the tip come out in the same "
    "place? Why, or why not?",
    f"It does not: the screwdriver lies along the tool's axes. The swapped product adds it along the base's "
    f"axes, and turns the tool's position with it."
    f" On `{arm.name}` the tip is at $({', '.join(f'{x:.3f}' for x in g_sf[:3, 3] + 0.0)})$ m, and the swapped "
    f"product says $({', '.join(f'{x:.3f}' for x in swapped[:3, 3] + 0.0)})$ m, {100 * miss:.1f} cm away.",
)

# %% [markdown]
# The plane shows best why the order matters. Take one turn and one shift. Each new factor on the right moves along the
# axes that the factors before it have turned.

# %%
turn, shift = np.eye(4), np.eye(4)
turn[:3, :3], shift[:3, 3] = rotations.exp([0, 0, 1], np.pi / 3), [1.0, 0.0, 0.0]
fig, columns = guide.axes2(2, width=6.4, height=3.0, equal=False)
for ax, motions, title in (
    (columns[0], [turn, turn @ shift], "first turn, then shift"),
    (columns[1], [shift, shift @ turn], "first shift, then turn"),
):
    for k, g in enumerate([np.eye(4), *motions]):
        colours = (guide.ORANGE, guide.GREEN) if k == 2 else (guide.GREY, guide.GREY)
        for axis, (letter, colour) in enumerate(zip("xy", colours, strict=True)):
            name = f"${letter}_{'ABD'[k]}$" if k != 1 else ""
            guide.plot_vector(ax, g[:2, 3], 0.45 * g[:2, axis], "", colour)
            ax.text(*(g[:2, 3] + 0.58 * g[:2, axis]), name, color=colour, ha="center", va="center")
    ax.set(title=title, xlim=(-0.7, 1.7), ylim=(-0.3, 1.6), xlabel="x", ylabel="y", aspect="equal")
guide.figure(
    fig,
    "Two plane drawings. On the left a frame turns by sixty degrees and then moves along its own new x axis, up and to "
    "the right. On the right it moves along x first and turns on the spot. The two end in different places.",
    "The same turn and the same shift in two orders. The orientations agree, the positions do not.",
)

# %% [markdown]
# ## The way back
#
# The inverse of $g_{st}$ is the pose of S seen from T:
#
# $$g_{ts} = g_{st}^{-1} = \begin{bmatrix} R_{st}^T & -R_{st}^T p_{st} \\ 0 & 1 \end{bmatrix}$$
#
# The shift is not $-p$ alone. Seen from T, the origin of S lies at $-p$ *written in T's axes*.

# %% tags=["shown"]
g_ts = screws.inverse(g_st)
careless = np.eye(4)
careless[:3, :3], careless[:3, 3] = g_st[:3, :3].T, -g_st[:3, 3]

# %%
guide.say(
    f"With $-p$ in place of $-R^T p$, `{arm.name}` believes its base to be "
    f"{100 * np.linalg.norm((careless - g_ts)[:3, 3]):.1f} cm from where its tool would see it."
)

# %% [markdown]
# $SE(3)$ has an identity, inverses, products and associativity, so it is a group, as $SO(3)$ is. The sum of two poses
# is not a pose: its last row ends with a 2.
#
# ## In use: the camera and the rock
#
# Camera C sits on a link half way along your arm. The table names the link. The camera reports the rock at
# $q_c$. Let $p_{tf}$ be the tip, seen from the tool. Three equations answer the questions of the beginning:
#
# $$\bar q_s = g_{sc}\,\bar q_c, \qquad \bar q_t = g_{st}^{-1}\,\bar q_s, \qquad d_t = q_t - p_{tf}$$

# %%
links = arm.description.joints if arm.description else {}
moving = [links[name].child for name in arm.moving_names if name in links]
camera = moving[(len(moving) - 1) // 2] if moving else arm.base
g_sc = arm.pose(theta, camera)
tip = (g_st @ point)[:3]
eye = np.array([0.52, -0.77, 0.37])  # from where the picture below is seen
beside = np.cross(eye, tip - g_sc[:3, 3])
beside /= np.linalg.norm(beside) or 1.0
rock = tip + 0.35 * arm.reach * (beside if beside[2] < 0 else -beside)
q_c = np.round(screws.inverse(g_sc) @ [*rock, 1], 3)  # what the camera says, to the millimetre

# %%
q_s = g_sc @ q_c
q_t = screws.inverse(g_st) @ q_s
d_t = q_t - point
guide.table(
    ["", "$x$ [m]", "$y$ [m]", "$z$ [m]"],
    [
        [f"$q_c$, seen from the camera on `{camera}`", *q_c[:3]],
        ["$q_s$, seen from the base", *q_s[:3]],
        ["$q_t$, seen from the tool", *q_t[:3]],
        ["$d_t$, from the tip, in the tool's axes", *d_t[:3]],
    ],
    f"One rock, seen from four frames. From the tip of the screwdriver it is {100 * np.linalg.norm(d_t):.1f} cm away.",
)

# %%
fig, ax = guide.axes3(width=5.2, height=4.6)
guide.plot_arm(ax, arm, theta, alpha=0.4, tool=False)
for g, name in ((np.eye(4), "S"), (g_sc, "C"), (g_st, "T")):
    guide.plot_frame(ax, g, None, 0.16 * arm.reach)
    ax.text(
        *(g[:3, 3] - 0.06 * arm.reach * g[:3, :3].sum(axis=1)), f"${name}$", ha="center", va="center"
    )
ax.plot(*np.array([g_st[:3, 3], tip]).T, color=guide.GREY, linestyle="-", linewidth=4.0)
for start, name, colour in ((g_sc[:3, 3], "q", guide.PINK), (tip, "d", guide.AMBER)):
    guide.plot_vector(ax, start, 0.96 * (q_s[:3] - start), "", colour)
    side = {"q": "right", "d": "left"}[name]
    ax.text(*(start + 0.6 * (q_s[:3] - start)), f"   ${name}$   ", color=colour, ha=side)
guide.plot_point(ax, q_s[:3], "", guide.INK)
ax.text(*q_s[:3], "\nrock", color=guide.INK, ha="center", va="top")
guide.figure(
    fig,
    f"{arm.name} with the frames of its base, of a camera on one of its links and of its tool, which holds a "
    "screwdriver. One arrow goes from the camera to a rock, another from the tip of the screwdriver to the same rock.",
    "Base $S$, camera $C$, tool $T$ with the screwdriver, grey. The arrow $q$ from the camera to the rock is "
    "known. The arrow $d$ from the tip is the answer.",
)

# %%
moved = {name: theta + 0.1 * unit for name, unit in zip(arm.joint_names, np.eye(arm.n), strict=True)}
carrying = [f"`{name}`" for name, x in moved.items() if not np.allclose(arm.pose(x, camera), g_sc)]
guide.predict(
    f"The camera sits on `{camera}`. Which joints change $g_{{sc}}$, and which change $g_{{st}}$?",
    f"Those before the camera change $g_{{sc}}$: {', '.join(carrying) or 'here there are none'}. Every joint changes "
    "$g_{st}$. Move them in the view below, and watch the link of the camera and the tool.",
)
guide.scene(arm, theta=theta, caption="The arm as in the picture above.", quantity="joints")

# %% [markdown]
# ## What goes wrong in practice
#
# **The letters do not meet.** `T_base_tool` in one program and `tool_to_base` in another are often the same matrix. Ask
# of each: in which frame are the coordinates that go in, and in which those that come out?
#
# **The inverse by changing signs.** It works while nothing is turned, or while the shift lies along the axis of the
# turn. Test with a turn and a shift across its axis.
#
# **The 1 forgotten, or put under a direction.** With a 0 under a point the position of the frame is left out. With a 1
# under a direction, the position of the frame is added to it. The gripper then approaches from the wrong side.
#
# **The camera's axes.** Optical frames have $z$ ahead, $x$ right and $y$ down. Most frames of links have $x$ ahead and
# $z$ up. The turn between the two is a constant matrix. Put it in the chain.

# %%
guide.say(
    f"**Millimetres.** CAD exports in mm, URDF means metres. The tip of a tool that is {100 * point[2]:.0f} cm long "
    f"ends {1000 * point[2]:.0f} m away, which you see at once. A shift in inches is harder to see."
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("2_2_1_rigid_motions")
