# %% [markdown]
# # A rail, a bearing and a threaded rod
#
# They lie on your bench, and the arm is not built yet. Which of them makes a joint? What does each one let the tool do,
# how many motors does it need, and what do you write down for it? There are six ways in which two rigid parts can slide
# on each other over a whole surface. This lesson builds all six out of two moves, a turn and a slide.

# %%
import numpy as np

from twistarm import ArmBuilder, crosscheck, guide, joints, screws
from twistarm.theory.lower_pairs import lower_pairs

arm = guide.arm()

# %% [markdown]
# ## One freedom: revolute, prismatic, helical
#
# Take a point $q$ on the axis of a joint and the unit vector $\omega$ along it. A part that is held by a **bearing**
# turns about the axis. On a **rail** it slides, along the unit vector $v$. On a **threaded rod** it does both at
# once in a fixed proportion, the **pitch** $h$: metres of slide for each radian of turn. Here is what each does to a
# point $p$ of the part:
#
# $$\dot p = \omega \times (p - q), \qquad \dot p = v, \qquad \dot p = \omega \times (p - q) + h\,\omega$$
#
# Written as twists $\xi = (v, \omega)$, in the order of the three:
#
# $$\xi = \begin{bmatrix} -\omega \times q \\ \omega \end{bmatrix}, \qquad
#   \xi = \begin{bmatrix} v \\ 0 \end{bmatrix}, \qquad
#   \xi = \begin{bmatrix} -\omega \times q + h\,\omega \\ \omega \end{bmatrix}$$
#
# The third is the screw of MLS, section 2.3.3. The first is a screw of pitch zero, the second the limit of one whose
# pitch grows without bound. You may find the first formula for $\dot p$ under the words "a joint that is translating
# and rotating". It is the bearing alone: what slides is $h\,\omega$.

# %%
axis, point = [0, 0, 1], [0.3, 0, 0]
one_each = {
    "revolute": joints.revolute(axis, point),
    "prismatic": joints.prismatic(axis),
    "helical": joints.helical(axis, point, pitch=0.05),
}

p = np.array([0.7, 0.1, 0.2])
for xi in (columns[:, 0] for columns in one_each.values()):
    velocity = np.cross(xi[3:], p) + xi[:3]  # what the twist says
    step = 1e-6
    ahead, behind = ((screws.exp(xi, s) @ np.append(p, 1))[:3] for s in (step, -step))
    assert np.allclose((ahead - behind) / (2 * step), velocity, atol=1e-8)

# %% tags=["hidden"]
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
    path = np.array([(screws.exp(xi, s) @ start)[:3, 3] for s in amounts[name]])
    guide.plot_screw(
        ax, xi, 0.95, r"$\xi$", guide.ORANGE if name == "prismatic" else guide.PINK, near=point
    )
    ax.plot(*path.T, color=guide.GREY, linestyle="-", linewidth=1.2)
    guide.plot_frame(ax, start, None, 0.16, alpha=0.4)
    guide.plot_frame(ax, screws.exp(xi, amounts[name][-1]) @ start, None, 0.16)
    ax.set_title(name)
    guide.fit(ax, [[-0.12, -0.45, -0.45], [0.75, 0.45, 0.45]])
guide.figure(
    fig,
    "Three drawings of an axis and of a frame that is carried by it: along a circle, along a straight line "
    "without being "
    "turned, and along a spiral",
    "A bearing, a rail and a threaded rod. Pale: the part at rest.",
)

# %%
lead = 0.00125  # [m] for a whole turn: the thread of an M8 rod
pitch = lead / (2 * np.pi)
after_a_turn = screws.exp(joints.helical(axis, point, pitch)[:, 0], 2 * np.pi)
assert np.allclose(after_a_turn[:3, 3], [0, 0, lead])
assert np.allclose(after_a_turn[:3, :3], np.eye(3))
guide.predict(
    f"An M8 rod carries its nut {1000 * lead:.2f} mm for each whole turn. What is its pitch $h$, as a twist has it?",
    f"{1000 * pitch:.3f} mm per radian, which is {pitch:.6f} m/rad. The number on the box is the lead, for a "
    f"whole turn; "
    f"the pitch of a twist is for a radian, {2 * np.pi:.2f} times less. Written in, the lead would send the nut "
    f"{1000 * lead * 2 * np.pi:.1f} mm in one turn.",
)

# %% [markdown]
# ## Several freedoms: cylindrical, planar, spherical
#
# The other three need no new twists. Each is a product of turns and slides that share a place:
#
# $$g(x) = e^{\hat\xi_1 x_1} \cdots e^{\hat\xi_k x_k}$$
#
# - A **cylindrical** joint is a rod in a plain bush. It turns and slides along one line, each by itself: two freedoms.
# - A **planar** joint is a block on a table. It slides two ways and turns about the normal: three.
# - A **spherical** joint is a ball in a socket. It turns about three axes that meet in its centre: three.

# %%
several = {
    "cylindrical": joints.cylindrical(axis, point),
    "planar": joints.planar(axis, point),
    "spherical": joints.spherical(point),
}
all_six = one_each | several
freedoms = {name: int(np.linalg.matrix_rank(twists)) for name, twists in all_six.items()}
assert list(freedoms.values()) == [1, 1, 1, 2, 3, 3]

# %% tags=["hidden"]
fig, panels = guide.axes3(columns=3, width=6.6, height=2.8, box=False, elev=24, azim=-58)
for ax, (name, twists) in zip(panels, several.items(), strict=True):
    for k, xi in enumerate(twists.T, start=1):
        slides = np.linalg.norm(xi[3:]) < 0.5
        shift = np.array([0.12, 0, 0]) if slides and name == "cylindrical" else np.zeros(3)
        guide.plot_screw(
            ax,
            xi,
            0.8,
            rf"$\xi_{k}$",
            guide.ORANGE if slides else guide.PINK,
            near=np.asarray(point) + shift,
        )
    guide.plot_point(ax, point)
    ax.set_title(name)
    guide.fit(ax, np.asarray(point) + [[-0.42] * 3, [0.42] * 3])
guide.figure(
    fig,
    "Three drawings: a turn and a slide along one line; two slides square to each other and a turn about their normal; "
    "three turns about axes that meet in one point",
    "Slides are drawn as arrows (vermilion), turns as axes (pink). The slide of the cylindrical joint lies on "
    "the axis; it "
    "is drawn beside it.",
)
coordinates = {
    "revolute": "angle [rad]",
    "prismatic": "length [m]",
    "helical": "angle [rad]",
    "cylindrical": "angle [rad], length [m]",
    "planar": "two lengths [m], angle [rad]",
    "spherical": "three angles [rad]",
}
met = {
    "revolute": "bearing, servo",
    "prismatic": "drawer rail, linear motor",
    "helical": "threaded rod",
    "cylindrical": "rod in a bush",
    "planar": "block on a table",
    "spherical": "ball and socket, and every wrist",
}
guide.table(
    ["joint", "freedoms", "coordinates", "in the workshop"],
    [[f"**{name}**", str(freedoms[name]), coordinates[name], met[name]] for name in all_six],
    "The six joints, and how many twists each one's columns span.",
)

# %%
guide.slider(
    "joint",
    "Choose each type in turn. Which one never turns the frame? Then take the spherical joint and set its middle turn, "
    "about $y'$, to 90°. What do the other two sliders do to the frame now?",
    "Only the prismatic joint never turns it. In the ball, at 90°, the two other sliders do the same thing: "
    "their axes lie "
    "on one line. Move one up and the other up as much, or down, and the frame stands still.",
    type="spherical",
)

# %% [markdown]
# ## Does the order matter?
#
# In a product of exponentials the order is the order of the parts. For some joints it makes no difference.


# %%
def carried(first, second, amount_1, amount_2):
    """Two of a joint's moves, one after the other, in either order."""
    a, b = screws.exp(first, amount_1), screws.exp(second, amount_2)
    return a @ b, b @ a


turn, slide = several["cylindrical"].T
either_way = carried(turn, slide, 1.2, 0.3)
assert np.allclose(*either_way)
x_slide, _, plane_turn = several["planar"].T
by_order = [g[:3, 3] for g in carried(x_slide, plane_turn, 0.3, np.pi / 2)]
apart = np.linalg.norm(by_order[0] - by_order[1])
assert apart > 0.1
guide.predict(
    "For a rod in a bush, does it matter which of its two exponentials stands on the left? And for a block on a "
    "table that "
    "slides 30 cm and turns by 90°?",
    f"Not for the rod: its two moves are about and along one line, and commute. The block ends {100 * apart:.0f} "
    f"cm apart, for "
    f"the axis "
    "of its turn rides along with the slide in one order and stays behind in the other. So the coordinates of a planar "
    "joint have an order, $x$, $y$, angle, and so have those of a ball: $z$, $y$, $x$.",
)

# %% [markdown]
# ## The ball and its coordinates
#
# A ball in its socket turns every way, in every position. Its three angles do not keep up with that. They are Euler
# angles, and you have met where those fail: turn the middle one by 90° and the first and the third axis lie on one
# line.

# %%
z_turn, y_turn, x_turn = several["spherical"].T


def axes_now(middle):
    """The three axes of the ball's coordinates, when the middle one has turned."""
    moved = screws.adjoint(screws.exp(y_turn, middle)) @ x_turn
    return np.column_stack([z_turn, y_turn, moved])


angles = (0.0, 1.0, np.pi / 2)
ranks = [int(np.linalg.matrix_rank(axes_now(angle), tol=1e-9)) for angle in angles]
assert ranks == [3, 3, 2]
guide.say(
    f"The rank of the three axes is {ranks[0]} at 0°, {ranks[1]} at {np.degrees(1.0):.0f}° and {ranks[2]} at "
    f"90°. The ball "
    "is as free there as anywhere. It is the coordinates that have lost a direction. Three motors on three axes "
    "lose it "
    "too: a wrist *is* a spherical joint made of three revolute ones, and that posture is its singularity."
)

# %% [markdown]
# ## Build all six
#
# Now build an arm of each, with one joint and a tool, and let somebody else judge it. Pinocchio has a model of its own
# for each of the six joints. `crosscheck` compares its poses and Jacobians with those of the product of exponentials.

# %%
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
proofs = {name: crosscheck(one) for name, one in arms.items()}
assert all(proof.ok for proof in proofs.values())
assert [one.n for one in arms.values()] == list(freedoms.values())

# %% tags=["hidden"]
rows = []
for name, proof in proofs.items():
    worst = max(proof.worst("pinocchio"), 1e-16)
    rows.append(
        [name, ", ".join(f"`{each}`" for each in arms[name].joint_names), f"${guide.rough(worst)}$"]
    )
guide.table(
    ["joint", "coordinates", "largest difference from Pinocchio"],
    rows,
    "Six arms of one joint each, judged by Pinocchio.",
)

# %% [markdown]
# Of the six, a URDF file knows three: revolute, prismatic and planar. The others are written as joints in one place,
# with links of no length between them, and a thread as a turn with a slide that follows it (`<mimic>`, with the
# pitch for its multiplier). The builder writes such a file: `builder.urdf()`.
#
# ## Your arm
#
# Read the other way round, a chain of turns and slides may hold joints that nobody named. Two axes on one line, a turn
# and a slide, make a cylindrical joint. Three turns that meet make a ball.

# %%
pairs = lower_pairs(arm.screws, arm.coupling.A)
lengths = np.repeat([arm.reach, 1.0], 3)[:, None]  # metres become shares of the reach
spanned = np.linalg.matrix_rank(arm.spatial_jacobian(arm.ready) / lengths, tol=1e-6)

# %% tags=["hidden"]
rows = []
for pair in pairs:
    names = ", ".join(f"`{arm.moving_names[row]}`" for row in sorted(pair.rows))
    rows.append(
        [
            names,
            pair.kind,
            str(len(pair.rows)),
            guide.tex(np.round(pair.frame[:3, 2], 3) + 0.0).join("$$"),
        ]
    )
guide.predict(
    f"`{arm.name}` moves {len(arm.moving_names)} joints with {arm.n} coordinates. Into which of the six types do "
    "they group, base to tip? In how many independent ways does the tool move where the arm waits?",
    "As "
    + ", ".join(pair.kind for pair in pairs)
    + f". The tool moves in {spanned} independent ways: the rank of the Jacobian there. There cannot be more than six, "
    "and joints with parallel axes may give less than they number.",
)
guide.table(
    ["moving joints", "make a joint that is", "freedoms", "along, or about [x, y, z]"],
    rows,
    f"The lower pairs of `{arm.name}`, all joints at zero. Joints that follow another have no freedom of their own.",
)

# %% tags=["hidden"]
fig, ax = guide.axes3(width=5.0, height=4.2)
guide.plot_arm(ax, arm, np.zeros(arm.n))
where = guide.arm_points(arm, np.zeros(arm.n))[1:-1]
for xi, near in zip(arm.screws.T, where, strict=True):
    slides = np.linalg.norm(xi[3:]) < 0.5
    guide.plot_screw(ax, xi, 0.35 * arm.reach, "", guide.ORANGE if slides else guide.PINK, near=near)
guide.fit(ax)
guide.figure(
    fig,
    f"{arm.name} with all joints at zero: round marks for joints that turn, with their axes; square ones for "
    f"joints that "
    "slide, with an arrow",
    f"What moves in `{arm.name}`. Circles and pink axes turn, squares and vermilion arrows slide.",
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **Lead for pitch.** The box says how far the nut goes in a turn, the twist how far in a radian.
# - **A slide that turns.** A carriage on one threaded rod turns with the rod unless a rail holds it. With the rail
#   it is a prismatic joint, without it a helical one.
# - **The axis of a planar joint.** In URDF it is the normal of the plane, not a direction of sliding.
# - **A joint in a file with no limits.** A revolute joint turns as far as its limits; a `continuous` one has none.
#   Taken for each other, the solver either stays away from half of the room or winds up your cable.
# - **A ball in three numbers.** Its angles fail at 90°; turn the joint's frame until that lies where the arm never
#   goes.

# %% tags=["hidden"]
turns = 40
with_lead = screws.exp(joints.helical(axis, point, lead)[:, 0], 2 * np.pi * turns)[2, 3]
with_pitch = screws.exp(joints.helical(axis, point, pitch)[:, 0], 2 * np.pi * turns)[2, 3]
held, loose = (
    screws.exp(joints.prismatic(axis)[:, 0], 0.05),
    screws.exp(joints.helical(axis, point, pitch)[:, 0], 2.0),
)
tool_of_held, tool_of_loose = (np.linalg.norm((g @ home)[:2, 3] - home[:2, 3]) for g in (held, loose))
assert np.isclose(with_pitch, turns * lead)
assert np.isclose(tool_of_held, 0)
guide.table(
    ["slip", "how it shows"],
    [
        [
            "lead for pitch",
            f"after {turns} turns {1000 * with_lead:.0f} mm are computed, and {1000 * with_pitch:.0f} mm made",
        ],
        [
            "a slide that turns",
            f"two radians of the rod take a tool {1000 * tool_of_loose:.0f} mm to the side",
        ],
        ["a ball at 90°", f"rank {ranks[2]} where {ranks[0]} is expected"],
    ],
    "The slips, by their numbers.",
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_0_joint_types")
