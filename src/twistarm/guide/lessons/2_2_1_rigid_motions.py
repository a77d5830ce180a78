# %% [markdown]
# # Rigid motions
#
# A camera on a link of your arm sees a rock and says where it lies: so much to the right, so much ahead, all of it
# measured from the lens. You want the tip of the screwdriver that the gripper holds to touch the rock. Where is the
# rock for the base? Where is the tip? And how far has the one to go to meet the other?
#
# Frames that have moved and turned lie between the questions and their answers. This lesson puts a turn and a shift
# into one matrix, so that passing from frame to frame becomes a product.
#
# ## The law
#
# Let $R_{ab}$ be the orientation of frame B seen from A, and $p_{ab}$ the place of its origin. A point with coordinates
# $q_b$ in B has in A the coordinates
#
# $$q_a = R_{ab}\,q_b + p_{ab}$$
#
# Put a 1 under each point, $\bar q = (q, 1)$, and this becomes a product with one $4\times 4$ matrix:
#
# $$\bar q_a = \begin{bmatrix} q_a \\ 1 \end{bmatrix}
# = \begin{bmatrix} R_{ab} & p_{ab} \\ 0 & 1 \end{bmatrix} \begin{bmatrix} q_b \\ 1 \end{bmatrix} = g_{ab}\,\bar q_b$$
#
# The pairs $(p, R)$ are the rigid motions; their set is called $SE(3)$. Source: MLS, section 2.3.1.
#
# A **vector** is the difference of two points, so it carries a 0 underneath. The shift then drops out, as it should: a
# direction or a speed does not change when the origin moves.

# %%
import numpy as np
import pinocchio as pin

from twistarm import guide, screws

arm = guide.arm()
theta = 0.6 * arm.ready + 0.4 * arm.random_theta(5)
g_st = arm.fk(theta)
point = np.array([0.0, 0.0, 0.12, 1.0])  # the tip of a screwdriver, in the tool's axes [m]
vector = np.array([0.0, 0.0, 0.12, 0.0])  # the direction and length of its blade
assert np.allclose((g_st @ point)[:3], g_st[:3, :3] @ point[:3] + g_st[:3, 3])
assert np.isclose(np.linalg.norm(g_st @ vector), np.linalg.norm(vector))
guide.table(
    ["", "$x$ [m]", "$y$ [m]", "$z$ [m]", "last"],
    [["the tip, a point", *(g_st @ point)], ["the blade, a vector", *(g_st @ vector)]],
    f"The same three numbers with a 1 and with a 0 below them, taken from the tool of `{arm.name}` to its base.",
)

# %% [markdown]
# ## Frames in a row
#
# Frame C seen from B, and B seen from A, give C seen from A:
#
# $$g_{ac} = g_{ab}\,g_{bc} = \begin{bmatrix} R_{ab}R_{bc} & R_{ab}\,p_{bc} + p_{ab} \\ 0 & 1 \end{bmatrix}$$
#
# The letters that meet in the middle cancel. You may find "$g_{ab}$, $g_{ac}$ are given" written here; it is $g_{ab}$
# and $g_{bc}$ that must be given, and $g_{ac}$ is what you get. Check each product by its letters and you will not go
# wrong.
#
# On your arm: C is a screwdriver's tip frame, which is shifted along the tool's $z$ axis and tilted.

# %%
g_tc = screws.exp([0, 0, 0, 0.5, 0, 0])
g_tc[:3, 3] = point[:3]
g_sc, swapped = g_st @ g_tc, g_tc @ g_st
assert np.allclose(g_sc[:3, 3], (g_st @ point)[:3])
assert np.allclose(g_sc, (pin.SE3(g_st) * pin.SE3(g_tc)).homogeneous)
assert np.allclose(arm.with_tool(g_tc, "screwdriver").fk(theta), g_sc)
miss = np.linalg.norm((g_sc - swapped)[:3, 3])
guide.predict(
    "How far from the screwdriver's true tip do you look for it if you write $g_{tc}\\,g_{st}$ instead of "
    "$g_{st}\\,g_{tc}$?",
    f"On `{arm.name}`, {100 * miss:.1f} cm. The tip is at $({', '.join(f'{x:.3f}' for x in g_sc[:3, 3] + 0.0)})$ m; "
    f"the swapped product says $({', '.join(f'{x:.3f}' for x in swapped[:3, 3] + 0.0)})$ m.",
)

# %% [markdown]
# Why the order matters is best seen in the plane. Take one turn and one shift. Each new factor on the right is done in
# the axes that the motions before have left.

# %% tags=["hidden"]
turn, shift = screws.exp([0, 0, 0, 0, 0, 1], np.pi / 3), screws.exp([1.0, 0, 0, 0, 0, 0])
fig, columns = guide.axes2(2, width=6.4, height=3.0, equal=False)
for ax, motions, title in (
    (columns[0], [turn, turn @ shift], "first turn, then shift"),
    (columns[1], [shift, shift @ turn], "first shift, then turn"),
):
    for k, g in enumerate([np.eye(4), *motions]):
        colours = (guide.ORANGE, guide.GREEN) if k == 2 else (guide.GREY, guide.GREY)
        for axis, (letter, colour) in enumerate(zip("xy", colours, strict=True)):
            name = f"${letter}_{'ABC'[k]}$" if k != 1 else ""
            guide.plot_vector(ax, g[:2, 3], 0.45 * g[:2, axis], name, colour)
    ax.set(title=title, xlim=(-0.7, 1.7), ylim=(-0.3, 1.6), xlabel="x", ylabel="y", aspect="equal")
guide.figure(
    fig,
    "Two plane drawings. On the left a frame turns by sixty degrees and then moves along its own new x axis, up and to "
    "the right. On the right it moves along x first and turns on the spot. The two end in different places.",
    "The same turn and the same shift in two orders. The orientations agree, the places do not.",
)

# %% [markdown]
# ## The way back
#
# The motion that undoes $g_{ab}$ is B's view of A:
#
# $$g_{ba} = g_{ab}^{-1} = \begin{bmatrix} R_{ab}^\top & -R_{ab}^\top p_{ab} \\ 0 & 1 \end{bmatrix}$$
#
# The shift is not $-p$ alone: seen from B, the origin of A lies in the direction $-p$ *turned into B's axes*.

# %%
g_ts = screws.inverse(g_st)
careless = np.eye(4)
careless[:3, :3], careless[:3, 3] = g_st[:3, :3].T, -g_st[:3, 3]
assert np.allclose(g_ts @ g_st, np.eye(4))
assert np.allclose(g_ts, np.linalg.inv(g_st))
guide.say(
    f"With $-p$ in place of $-R^\\top p$, `{arm.name}` believes its base to be "
    f"{100 * np.linalg.norm((careless - g_ts)[:3, 3]):.1f} cm from where its tool would see it."
)

# %% [markdown]
# With an identity, an inverse, a product that stays inside and associativity, $SE(3)$ is a group, as $SO(3)$ is. The
# sum of two poses is no pose: its last row ends with a 2.
#
# ## In use: the camera and the rock
#
# The camera sits on a link of your arm, half way along the chain where the description has links. The rock is where the
# camera says. Three products answer the questions of the beginning:
#
# $$\bar q_s = g_{sc}\,\bar q_c, \qquad \bar q_t = g_{st}^{-1}\,\bar q_s, \qquad d = q_t - p_{\text{tip}}$$

# %%
links = arm.description.joints if arm.description else {}
moving = [links[name].child for name in arm.moving_names if name in links]
camera = moving[(len(moving) - 1) // 2] if moving else arm.base
g_scam = arm.pose(theta, camera)
tip = (g_st @ point)[:3]
lies = tip + 0.4 * arm.reach * np.array([0.64, 0.48, -0.6])
seen = np.round(screws.inverse(g_scam) @ [*lies, 1], 3)  # what the camera says, to the millimetre

rock_s = g_scam @ seen
rock_t = screws.inverse(g_st) @ rock_s
way = rock_t - point
assert np.allclose(g_st @ (point + way), rock_s)
assert np.isclose(np.linalg.norm(way), np.linalg.norm(rock_s - g_st @ point))
guide.table(
    ["seen from", "$x$ [m]", "$y$ [m]", "$z$ [m]"],
    [
        [f"the camera, on `{camera}`", *seen[:3]],
        ["the base", *rock_s[:3]],
        ["the tool", *rock_t[:3]],
        ["the tip (tool's axes)", *way[:3]],
    ],
    f"One rock, four views. From the tip of the screwdriver it is {100 * np.linalg.norm(way):.1f} cm away.",
)

# %% tags=["hidden"]
fig, ax = guide.axes3(width=5.2, height=4.6)
guide.plot_arm(ax, arm, theta, alpha=0.5, tool=False)
for g, name in ((np.eye(4), "s"), (g_scam, "c"), (g_st, "t")):
    guide.plot_frame(ax, g, None, 0.2 * arm.reach)
    ax.text(
        *(g[:3, 3] - 0.06 * arm.reach * g[:3, :3].sum(axis=1)), f"${name}$", ha="center", va="center"
    )
guide.plot_vector(ax, g_scam[:3, 3], (rock_s[:3] - g_scam[:3, 3]), "", guide.PINK)
guide.plot_vector(ax, tip, rock_s[:3] - tip, "", guide.AMBER)
guide.plot_point(ax, rock_s[:3], "rock", guide.INK)
guide.fit(ax)
guide.figure(
    fig,
    f"{arm.name} with the frames of its base, of a camera on one of its links and of its tool. One arrow goes from the "
    "camera to a rock, another from the tip of the tool to the same rock.",
    "Base $s$, camera $c$, tool $t$: the camera's arrow is what is known, the tip's arrow is what is asked for.",
)

# %%
guide.scene(
    arm,
    theta=theta,
    caption="Move a joint beyond the camera's link, then one before it: which moves its view?",
)

# %% [markdown]
# ## What goes wrong in practice
#
# **The letters do not meet.** A transform that is named `T_base_tool` in one program and `tool_to_base` in another is
# often the same matrix. Ask of each: which point's coordinates go in, and which come out?
#
# **The inverse by changing signs.** It works while nothing is turned, and fails on the first day that something is.
#
# **The 1 forgotten, or put under a direction.** With a 0 under a point every frame seems to sit at the base. With a 1
# under a direction, the gripper approaches along a line that has the arm's own position added to it.
#
# **The camera's axes.** Optical frames have $z$ ahead, $x$ right and $y$ down; frames of links mostly have $x$ ahead
# and $z$ up. The turn between the two is a constant matrix, and it belongs in the chain.

# %%
guide.say(
    f"**Millimetres.** CAD exports in mm, URDF means metres. The tip of a tool that is {100 * point[2]:.0f} cm long "
    f"ends {1000 * point[2]:.0f} m away, which shows at once; a shift in inches does not."
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("2_2_1_rigid_motions")
