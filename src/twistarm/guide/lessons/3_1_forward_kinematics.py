# %% [markdown]
# # Where is the tool?
#
# The arm is built. Its encoders report an angle for every joint that turns and a length for every joint that slides.
# First you need a function from these numbers to the pose of the tool. This is **forward kinematics**. It always has
# exactly one answer. There are two short ways to write it.

# %% tags=["shown"]
import numpy as np

from twistarm import guide, poe, screws

arm = guide.arm()
theta = arm.ready  # the configuration in which the arm waits

# %% [markdown]
# ## Link by link
#
# The file that describes your arm says two things about each joint. The first is the pose $g_0$ of its frame on the
# link before it. The second is the axis about or along which it moves: a twist $\eta$ in the joint's own frame. At
# $\theta$ the pose of its link, seen from the link before, is $g_0\, e^{\hat\eta\theta}$. Go from base to tip and
# multiply, and the indices cancel as they did for rotations:
#
# $$g_{st} = g_{s1}\, g_{12} \cdots g_{nt}$$
#
# There are as many frames as links, and a person has chosen each of them. Many books write each factor with four
# numbers, the Denavit–Hartenberg parameters. For these, the frames must be placed by rules. Your file needs no such
# rules. The second way needs no frames on the links at all.

# %%
fig, ax = guide.axes3(width=5.0, height=4.2)
guide.plot_arm(ax, arm, theta)
if arm.description is not None:
    poses = arm.poses(theta)
    for k, name in enumerate(arm.moving_names, start=1):
        pose = poses[arm.description.joints[name].child]
        guide.plot_frame(ax, pose, None, 0.09 * arm.reach)
        beside = arm.reach * np.array([-0.035, -0.025, -0.035])
        ax.text(*(pose[:3, 3] + beside), str(k), ha="center", va="center")
guide.plot_frame(ax, np.eye(4), "S", 0.2 * arm.reach)
guide.figure(
    fig,
    f"The skeleton of {arm.name} from its base to its tool, with a numbered frame at each of its "
    f"{len(arm.moving_names)} moving links",
    f"A frame on every moving link of `{arm.name}`, numbered: the chain from S, the base, to T, the "
    "tool.",
)

# %% [markdown]
# ## Two frames and the axes: the product of exponentials
#
# Set every joint to zero. Take two photographs of the arm there. One shows the tool: its pose $g_{st}(0)$, the **home**
# pose. The other shows the axes of the joints, seen from the base: their twists $\xi_1, \dots, \xi_n$. Here are
# the twists of a joint that turns about a line through $q$ along the unit vector $\omega$, and of a joint that slides
# along $v$:
#
# $$\xi = \begin{bmatrix} -\omega \times q \\ \omega \end{bmatrix}, \qquad \xi = \begin{bmatrix} v \\ 0 \end{bmatrix}$$
#
# Now move the joints one after the other, **the last one first**. It moves the tool: $e^{\hat\xi_n\theta_n} g_{st}(0)$.
# It does not move the axes before it. So the axis of joint $n - 1$ is still where the photograph shows it. That joint
# moves everything beyond it, and so on down to the base:
#
# $$g_{st}(\theta) = e^{\hat\xi_1\theta_1}\, e^{\hat\xi_2\theta_2} \cdots e^{\hat\xi_n\theta_n}\, g_{st}(0)$$
#
# This is the **product of exponentials**. Source: Murray, Li and Sastry, *A Mathematical Introduction to Robotic
# Manipulation* (MLS), section 3.2.2; Lynch & Park, section 4.1, write $M$ for $g_{st}(0)$. Every twist comes from the
# photograph, because in this order no axis moves before it is used.

# %%
rows = []
for name, xi in zip(arm.moving_names, arm.screws.T, strict=True):
    screw = screws.to_screw(xi)
    turns = np.isfinite(screw.pitch)
    point = "any" if not turns else ", ".join(f"{x + 0.0:.3f}" for x in np.round(screw.point, 3))
    axis = ", ".join(f"{x + 0.0:.2f}" for x in np.round(screw.axis, 2))
    rows.append(
        [f"`{name}`", "turns" if turns else "slides", axis.replace("-", "−"), point.replace("-", "−")]
    )
guide.table(
    ["joint", "it", "along", "through [m]"],
    rows,
    f"The axes of `{arm.name}`, all joints at zero, seen from its base.",
)
guide.say(rf"The tool on the same photograph: $$g_{{st}}(0) = {guide.tex(arm.home)}$$")

# %%
fig, ax = guide.axes3(width=5.0, height=4.2)
guide.plot_arm(ax, arm, np.zeros(arm.n))
at_home = guide.arm_points(arm, np.zeros(arm.n))
along_the_arm = np.linspace(at_home[:-1], at_home[1:], 20).reshape(-1, 3)
for k, (xi, near) in enumerate(zip(arm.screws.T, at_home[1:-1], strict=True), start=1):
    screw = screws.to_screw(xi)
    slides = np.isinf(screw.pitch)
    colour = guide.ORANGE if slides else guide.PINK
    guide.plot_screw(ax, xi, 0.4 * arm.reach, "", colour, near=near)
    centre = near if slides else screw.point + screw.axis * ((near - screw.point) @ screw.axis)
    end = centre - 0.26 * arm.reach * screw.axis
    if np.linalg.norm(along_the_arm - end, axis=1).min() < 0.05 * arm.reach:
        end[2] += 0.14 * arm.reach  # its letter is not drawn on the arm
    ax.text(*end, rf"$\xi_{{{k}}}$", color=colour, ha="center", va="center")
guide.figure(
    fig,
    f"{arm.name} with all joints at zero and the axis of each of its joints",
    "The second photograph: the axes, with all joints at zero. Arrows are slides, lines are axes of turns.",
)

# %% [markdown]
# ## The formula at work
#
# The program is a short loop with a function for $e^{\hat\xi\theta}$. A joint that follows another one (a mimic joint)
# has an axis but no coordinate. The matrix `coupling.A` turns the coordinates $\theta$ into one value $x$ for each
# axis. Without mimic joints $x = \theta$.

# %% tags=["shown"]
values = arm.coupling.A @ theta
g = arm.home
for xi, value in reversed(list(zip(arm.screws.T, values, strict=True))):
    g = screws.exp(xi, value) @ g  # the last joint first: each one moves what is there already

# %%
guide.say(
    rf"$$g_{{st}}(\theta) = {guide.tex(g)}$$ The tool is at $x = {g[0, 3]:.3f}$, $y = "
    f"{g[1, 3]:.3f}$, $z = {g[2, 3]:.3f}$ m from the base."
)

# %% [markdown]
# Is it right? Compare it with a program that works the other way. The library Pinocchio reads your file itself and goes
# link by link.

# %%
by_pinocchio = (
    arm.by_pinocchio(theta)[0] if arm.description is not None else poe.fk(arm.screws, arm.home, values)
)
off = np.abs(g - by_pinocchio).max()
guide.say(
    f"The largest of the sixteen differences between the two is ${guide.rough(off)}$, which is rounding. "
    f"twistarm makes this comparison whenever it loads an arm, and refuses the arm if they differ."
)

# %% [markdown]
# ## Predict
#
# Only one joint moves at a time in the next question; the others stay as on the photograph.

# %%
turning = np.flatnonzero(
    (np.linalg.norm(arm.screws[3:], axis=0) > 0.5) & (np.abs(arm.coupling.A).sum(axis=1) > 0)
)
first = int(turning[0]) if len(turning) else 0
screw = screws.to_screw(arm.screws[:, first])
tool = arm.home[:3, 3]
lever = np.linalg.norm(np.cross(screw.axis, tool - screw.point)) if np.isfinite(screw.pitch) else np.inf
small = np.radians(1.0)
moved = np.linalg.norm((screws.exp(arm.screws[:, first], small) @ arm.home)[:3, 3] - tool)
guide.predict(
    f"From zero, `{arm.moving_names[first]}` alone turns by 1°. How far does the tool move?",
    f"By {1000 * moved:.1f} mm. "
    + (
        f"The tool is {lever:.3f} m from that axis, and 1° is {small:.4f} rad: lever times angle, "
        f"{1000 * lever * small:.1f} mm. Keep that number in mind when you choose encoders."
        if np.isfinite(lever) and lever > 1e-6
        else "The tool lies on the axis, or the joint slides: there is no lever."
    ),
)

# %%
guide.scene(
    arm,
    np.zeros(arm.n),
    caption="Every joint at zero. Move the last joint alone, then the first alone.",
    quantity="screws",
)
guide.predict(
    "In this view, which axes move when the last joint moves, and which when the first one does?",
    "With the last joint, none: only the tool is beyond it. With the first joint, which is nearest to the "
    "base, all axes except its own.",
)

# %% [markdown]
# ## The same from the tool's side
#
# You can also write the axes as seen from the tool. Their twists are then $\xi^b_i =
# \mathrm{Ad}_{g_{st}(0)}^{-1}\,\xi_i$ (Lynch & Park write $B_i$), and the home pose comes first:
#
# $$g_{st}(\theta) = g_{st}(0)\, e^{\hat\xi^b_1\theta_1} \cdots e^{\hat\xi^b_n\theta_n}$$
#
# It is the same formula. You know $g\,\hat\xi\,g^{-1} = (\mathrm{Ad}_g\,\xi)^{\wedge}$ from the lesson on velocities.
# The same holds for each power of $\hat\xi$ and so for the series: $e^{\hat\xi_i\theta_i} g_{st}(0) =
# g_{st}(0)\,e^{\hat\xi^b_i\theta_i}$. So the home pose can pass from the right end of the product to the left. Some
# texts say that the product of exponentials needs the Adjoint. Only this form does.

# %%
body = screws.adjoint(screws.inverse(arm.home)) @ arm.screws
from_the_tool = arm.home
for xi, value in zip(body.T, values, strict=True):
    from_the_tool = from_the_tool @ screws.exp(xi, value)
guide.say(f"On `{arm.name}` the two forms differ by ${guide.rough(np.abs(from_the_tool - g).max())}$.")

# %% [markdown]
# ## By hand
#
# For two links in a plane, a triangle is enough. Let the first link have the length $l_1$ and the second, with the
# tool, $l_2$:
#
# $$x = l_1\cos\theta_1 + l_2\cos(\theta_1 + \theta_2), \qquad y = l_1\sin\theta_1 + l_2\sin(\theta_1 + \theta_2)$$

# %%
planar = guide.bundled("rr_planar")
q1, q2 = (screws.to_screw(xi).point for xi in planar.screws.T)
l1, l2 = np.linalg.norm(q2 - q1), np.linalg.norm(planar.home[:3, 3] - q2)
pair = np.array([0.4, 0.9])
x = l1 * np.cos(pair[0]) + l2 * np.cos(pair.sum())
again = 2 * np.degrees(np.arctan2(l2 * np.sin(np.radians(50)), l1 + l2 * np.cos(np.radians(50)))) + 25
guide.slider(
    "two_link",
    r"Note $x$ and $y$. Then set $\theta_2$ to −50° and find the $\theta_1$ with which the tool is at the "
    "same place again.",
    rf"At $\theta_1 = {again:.0f}°$. The elbow is now on the other side. Forward kinematics has one answer, "
    rf"but its inverse may have several. The lessons on inverse kinematics find them.",
    inverse=False,
    l1=round(float(l1), 3),
    l2=round(float(l2), 3),
    theta1=25,
    theta2=50,
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **No home pose.** Without $g_{st}(0)$ at its end the product says how the tool has *moved*, not where it is.
# - **Axes in the wrong order.** The product goes from base to tip, from left to right. In the other order, each axis is
#   used after another joint has moved it.
# - **Zero is somewhere else.** The formula counts from the zero of the *file*. If the motor's zero is another one,
#   subtract it first. An error of the angle moves the tool by lever times angle, as in the question above.
# - **Degrees.** An angle of 30 rad is almost five full turns.

# %%
wrong_order = arm.home
for xi, value in zip(arm.screws.T, values, strict=True):
    wrong_order = screws.exp(xi, value) @ wrong_order
without_home = g @ screws.inverse(arm.home)
in_degrees = poe.fk(
    arm.screws,
    arm.home,
    arm.coupling.A @ np.where(np.array(arm.units) == "rad", np.degrees(theta), theta),
)
rows = [
    [words, 1000 * float(np.linalg.norm((wrong - g)[:3, 3]))]
    for words, wrong in (
        ("no home pose", without_home),
        ("axes in the wrong order", wrong_order),
        ("degrees for radians", in_degrees),
    )
]
guide.table(
    ["mistake", "the tool is computed wrong by [mm]"],
    [[words, f"{far:.0f}"] for words, far in rows],
    f"On `{arm.name}`, in its ready configuration.",
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_1_forward_kinematics")
