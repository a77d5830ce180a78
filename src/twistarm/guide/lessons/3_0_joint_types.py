# %% [markdown]
# # A rail, a bearing and a threaded rod
#
# These parts lie on your bench, and the arm is not built yet. How can each of them move the tool? How many motors does
# it need? And which numbers describe it? Two rigid parts can slide on each other over a whole surface in only six ways.
# Such joints are called **lower pairs**. This lesson builds all six from two motions, a turn and a slide.

# %%
import numpy as np

from twistarm import ArmBuilder, crosscheck, guide, joints, screws
from twistarm.theory.lower_pairs import lower_pairs

arm = guide.arm()

# %% [markdown]
# ## One freedom: revolute, prismatic, helical
#
# The lesson on twists and screws has the first three, with their twists. Take a point $q$ on the axis of a joint and
# the unit vector $\omega$ along it.
#
# - A part in a **bearing** turns about the axis.
# - On a **rail** it slides, along the unit vector $v$.
# - On a **threaded rod** it does both in a fixed ratio, the **pitch** $h$: metres of slide for each radian.
#
# Their twists $\xi = (v, \omega)$, in this order:
#
# $$\xi = \begin{bmatrix} -\omega \times q \\ \omega \end{bmatrix}, \qquad
#   \xi = \begin{bmatrix} v \\ 0 \end{bmatrix}, \qquad
#   \xi = \begin{bmatrix} -\omega \times q + h\,\omega \\ \omega \end{bmatrix}$$
#
# The third is a screw (Murray, Li and Sastry, *A Mathematical Introduction to Robotic Manipulation* (MLS), section
# 2.3.3). The first is a screw of pitch zero. The second is the limit of $\xi/h$, with $\xi$ of the third, for $h \to
# \infty$ and $v = \omega$.

# %%
axis, point = [0, 0, 1], [0.3, 0, 0]
one_each = {
    "revolute": joints.revolute(axis, point),
    "prismatic": joints.prismatic(axis),
    "helical": joints.helical(axis, point, pitch=0.05),
}


# %%
fig, panels = guide.axes3(columns=3, width=6.6, height=2.8, box=False, elev=20, azim=-60)
amounts = {
    "revolute": np.linspace(0, 4.5, 80),
    "prismatic": np.linspace(0, 0.45, 80),
    "helical": np.linspace(0, 9, 160),
}
start = np.eye(4)
start[:3, 3] = [0.62, 0, -0.25]
for ax, (name, columns) in zip(panels, one_each.items(), strict=True):
    xi = columns[:, 0]
    path = screws.exp(xi, amounts[name])[:, :3] @ start[:, 3]
    guide.plot_screw(
        ax, xi, 0.95, r"$\xi$", guide.ORANGE if name == "prismatic" else guide.PINK, near=point
    )
    ax.plot(*path.T, color=guide.GREY, linestyle="-", linewidth=1.2)
    guide.plot_frame(ax, start, None, 0.16, alpha=0.4)
    poses = screws.exp(xi, np.linspace(0, amounts[name][-1], 30)) @ start
    guide.plot_motion(guide.plot_frame, ax, poses, None, 0.16)
    ax.set_title(name)
guide.figure(
    fig,
    "Three drawings of an axis and of a frame that is carried by it: along a circle, along a straight "
    "line without being turned, and along a helix",
    "A bearing, a rail and a threaded rod. Pale: the part at rest.",
)

# %%
lead = 0.00125  # [m] for a whole turn: the thread of an M8 rod
pitch = lead / (2 * np.pi)
guide.predict(
    f"An M8 rod moves its nut by {1000 * lead:.2f} mm in each whole turn. What is the pitch $h$ of its twist?",
    f"{1000 * pitch:.3f} mm per radian, which is {pitch:.6f} m/rad. The workshop calls "
    f"{1000 * lead:.2f} mm the pitch of the thread. It is the **lead**, the advance in a whole turn. "
    f"The pitch of a twist is the advance in a radian, {2 * np.pi:.2f} times less. If you put the "
    f"lead in its place, the nut of your program moves {1000 * lead * 2 * np.pi:.1f} mm in one turn.",
)

# %% [markdown]
# ## Several freedoms: cylindrical, planar, spherical
#
# The other three need no new twists. Each is a product of turns and slides in one place:
#
# $$g(\theta) = e^{\hat\xi_1 \theta_1} \cdots e^{\hat\xi_k \theta_k}$$
#
# - A **cylindrical** joint is a rod in a plain bush. It turns and slides along one line, independently: two freedoms.
# - A **planar** joint is a block on a table. It slides in two directions and turns about the normal: three.
# - A **spherical** joint is a ball in a socket. It turns about three axes that meet in its centre: three.

# %%
several = {
    "cylindrical": joints.cylindrical(axis, point),
    "planar": joints.planar(axis, point),
    "spherical": joints.spherical(point),
}
all_six = one_each | several
freedoms = {name: int(np.linalg.matrix_rank(twists)) for name, twists in all_six.items()}

# %%
fig, panels = guide.axes3(columns=3, width=6.6, height=2.8, box=False, elev=24, azim=-58)
for ax, (name, twists) in zip(panels, several.items(), strict=True):
    for k, xi in enumerate(twists.T, start=1):
        slides = np.linalg.norm(xi[3:]) < 0.5
        beside = np.array([0.12, 0, 0]) if slides and name == "cylindrical" else np.zeros(3)
        colour = guide.ORANGE if slides else guide.PINK
        near = np.asarray(point) + beside
        guide.plot_screw(ax, xi, 0.8, "", colour, near=near)
        along = xi[:3] if slides else xi[3:]
        ax.text(*(near - 0.5 * along), rf"$\xi_{k}$", color=colour, ha="center", va="center")
    guide.plot_point(ax, point)
    ax.set_title(name)
guide.figure(
    fig,
    "Three drawings: a turn and a slide along one line; two slides at right angles and a turn about "
    "their normal; three turns about axes that meet in one point",
    "Slides are drawn as arrows (orange), turns as axes (pink). The slide of the cylindrical joint "
    "lies on the axis; it is drawn beside it.",
)
coordinates = {
    "revolute": "angle [rad]",
    "prismatic": "length [m]",
    "helical": "angle [rad]",
    "cylindrical": "angle [rad], length [m]",
    "planar": "two lengths [m], angle [rad]",
    "spherical": "three angles [rad]",
}
in_workshop = {
    "revolute": "bearing, servo",
    "prismatic": "drawer rail, linear motor",
    "helical": "threaded rod",
    "cylindrical": "rod in a bush",
    "planar": "block on a table",
    "spherical": "ball and socket",
}
guide.table(
    ["joint", "freedoms", "coordinates", "in the workshop"],
    [[f"**{name}**", str(freedoms[name]), coordinates[name], in_workshop[name]] for name in all_six],
    "The six joints. The freedoms are counted as the independent ones among the twists: the rank of "
    "the matrix with the twists in its columns.",
)

# %%
guide.slider(
    "joint",
    "Choose each type in turn. Which one never turns the frame? Then take the spherical joint and set its "
    "middle turn, about $y'$, to 90°. What do the other two sliders do to the frame now?",
    "Only the prismatic joint never turns it. For the ball at 90°, the two other sliders turn the frame "
    "about the same line, in opposite directions. Move both up by the same angle: the frame does not move.",
    type="spherical",
)

# %% [markdown]
# ## Does the order matter?
#
# The order of the factors matters in a product of matrices. For some joints it makes no difference.


# %%
def both_orders(first, second, amount_1, amount_2):
    """Two of a joint's moves, one after the other, in either order."""
    a, b = screws.exp(first, amount_1), screws.exp(second, amount_2)
    return a @ b, b @ a


x_slide, _, plane_turn = several["planar"].T
by_order = [g[:3, 3] for g in both_orders(x_slide, plane_turn, 0.3, np.pi / 2)]
distance = np.linalg.norm(by_order[0] - by_order[1])
guide.predict(
    "For a rod in a bush, does it matter which of its two exponentials is on the left? And for a "
    "block on a table that slides 30 cm and turns by 90°?",
    "Not for the rod: its two moves are about and along one line, and commute. The block ends in two "
    f"places that are {100 * distance:.0f} cm apart: in one order the slide carries the axis of the turn "
    "along, in the other it does not. So the coordinates of a planar joint have an order, $x$, $y$, "
    "angle, and so have those of a ball: $z$, $y$, $x$.",
)

# %% [markdown]
# ## The ball and its coordinates
#
# A ball in its socket can turn in every direction, from every position. Its three coordinates are Euler angles, and
# they fail where Euler angles fail. Turn the middle one by 90°: the first and the third axis then lie on one line.

# %%
z_turn, y_turn, x_turn = several["spherical"].T


def axes_now(middle):
    """The three axes of the ball's coordinates, when the middle one has turned."""
    moved = screws.adjoint(screws.exp(y_turn, middle)) @ x_turn
    return np.column_stack([z_turn, y_turn, moved])


angles = (0.0, 1.0, np.pi / 2)
ranks = [int(np.linalg.matrix_rank(axes_now(angle), tol=1e-9)) for angle in angles]
guide.say(
    f"Of the three axes, {ranks[0]} are independent at 0°, {ranks[1]} at {np.degrees(1.0):.0f}° and "
    f"{ranks[2]} at 90°. The ball itself is as free there as anywhere. Only its coordinates have lost a "
    f"direction. A wrist of three motors with axes through one point is the same product of three turns. In "
    f"this configuration the *wrist* loses a direction: it is singular, which is the subject of a later lesson."
)

# %% [markdown]
# ## Build all six
#
# Now build an arm from each joint and a tool, and check it with another program. Pinocchio, a library of robot
# dynamics, has a model for each of the six joints. `crosscheck` compares its poses and velocities with those of the
# product of exponentials.

# %% tags=["shown"]
home = np.eye(4)
home[:3, 3] = [0.5, 0, 0.4]
built = {
    "revolute": ArmBuilder("one").revolute("j", axis, point),
    "prismatic": ArmBuilder("one").prismatic("j", axis),
    "helical": ArmBuilder("one").helical("j", axis, point, pitch),
    "cylindrical": ArmBuilder("one").cylindrical("j", axis, point),
    "planar": ArmBuilder("one").planar("j", axis, point),
    "spherical": ArmBuilder("one").spherical("j", point),
}
arms = {name: builder.tool(home).build() for name, builder in built.items()}
proofs = {name: crosscheck(single) for name, single in arms.items()}

# %%
rows = []
for name, proof in proofs.items():
    worst = max(proof.worst("pinocchio"), 1e-16)
    rows.append(
        [name, ", ".join(f"`{joint}`" for joint in arms[name].joint_names), f"${guide.rough(worst)}$"]
    )
guide.table(
    ["joint", "coordinates", "largest difference from Pinocchio"],
    rows,
    "Six arms of one joint each, compared with Pinocchio.",
)

# %% [markdown]
# A URDF file describes a robot. It has three of the six: revolute, prismatic and planar. The others become several
# joints in one place, with links of no length between them. A threaded rod becomes a turn and a slide that follows it
# (`<mimic>`, with the pitch as multiplier). `builder.urdf()` writes such a file.
#
# ## Your arm
#
# Conversely, a chain of turns and slides may contain lower pairs that the file does not name. A turn and a slide on one
# line make a cylindrical joint. Three turns with axes through one point make a spherical one.

# %%
pairs = lower_pairs(arm.screws, arm.coupling.A)
lengths = np.repeat([arm.reach, 1.0], 3)[:, None]  # metres become shares of the reach
spanned = np.linalg.matrix_rank(arm.spatial_jacobian(arm.ready) / lengths, tol=1e-6)

# %%
rows = []
for pair in pairs:
    names = ", ".join(f"`{arm.moving_names[row]}`" for row in sorted(pair.rows))
    rows.append(
        [names, pair.kind, str(len(pair.rows)), guide.tex(np.round(pair.axis, 3) + 0.0).join("$$")]
    )
guide.predict(
    f"`{arm.name}` moves {len(arm.moving_names)} joints with {arm.n} coordinates. Which of the six types do "
    f"they form, from base to tip? In how many independent ways can the tool move in the ready configuration?",
    "As "
    + ", ".join(pair.kind for pair in pairs)
    + f". The tool moves in {spanned} independent ways, because {spanned} of its joints' twists are "
    f"independent there. There are at most six. Joints with parallel axes may give fewer ways than joints.",
)
guide.table(
    ["moving joints", "make a joint that is", "freedoms", "along, or about [x, y, z]"],
    rows,
    f"The lower pairs of `{arm.name}`, all joints at zero. Joints that follow another have no freedom "
    "of their own.",
)

# %%
fig, ax = guide.axes3(width=5.0, height=4.2)
guide.plot_arm(ax, arm, np.zeros(arm.n))
where = guide.arm_points(arm, np.zeros(arm.n))[1:-1]
for xi, near in zip(arm.screws.T, where, strict=True):
    slides = np.linalg.norm(xi[3:]) < 0.5
    guide.plot_screw(ax, xi, 0.35 * arm.reach, "", guide.ORANGE if slides else guide.PINK, near=near)
guide.figure(
    fig,
    f"{arm.name} with all joints at zero: round marks and lines for joints that turn; square marks "
    "and arrows for joints that slide",
    f"What moves in `{arm.name}`. Circles and pink axes turn, squares and orange arrows slide.",
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **Lead for pitch.** The data sheet gives the advance in a turn. The twist has the advance in a radian.
# - **A slide that turns.** Nut and rod are a helical joint. A carriage that is fixed to the nut and has no rail turns
#   about the rod while it advances. Add a rail that keeps it from turning, and a motor that turns the rod. The carriage
#   then only slides: together the parts are a prismatic joint.
# - **The axis of a planar joint.** In URDF it is the normal of the plane, not a direction of sliding.
# - **A joint in a file with no limits.** A `revolute` joint turns as far as its limits; a `continuous` one has none. If
#   the file mixes them up, the solver leaves out half of the workspace, or winds up your cable.
# - **A ball in three numbers.** Its angles fail at 90°. Turn the joint's frame so that these 90° lie where the arm
#   never goes.

# %%
turns = 40
with_lead = screws.exp(joints.helical(axis, point, lead)[:, 0], 2 * np.pi * turns)[2, 3]
with_pitch = screws.exp(joints.helical(axis, point, pitch)[:, 0], 2 * np.pi * turns)[2, 3]
railed, unrailed = (
    screws.exp(joints.prismatic(axis)[:, 0], 0.05),
    screws.exp(joints.helical(axis, point, pitch)[:, 0], 2.0),
)
tool_of_held, tool_of_loose = (
    np.linalg.norm((g @ home)[:2, 3] - home[:2, 3]) for g in (railed, unrailed)
)
guide.table(
    ["mistake", "how it shows"],
    [
        [
            "lead for pitch",
            f"after {turns} turns the program says {1000 * with_lead:.0f} mm, and the nut has moved "
            f"{1000 * with_pitch:.0f} mm",
        ],
        [
            "a slide that turns",
            f"after two radians of the thread the tool is {1000 * tool_of_loose:.0f} mm to the side",
        ],
        ["a ball at 90°", f"{ranks[2]} independent axes, where {ranks[0]} are expected"],
    ],
    "Three of these mistakes in numbers.",
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_0_joint_types")
