# %% [markdown]
# # Twists and screws
#
# The driver moves all joints at once, and the gripper goes from one pose to another. Is there a description of what it
# did that is shorter than a dozen numbers? There is: it turned about **one line** and slid along it, as a nut does on
# its bolt. And one joint of your arm, whichever type it is: what does it do to everything beyond it? The same.
#
# ## What a joint does to a point
#
# Let $\omega$ be the unit vector along a joint's axis, $q$ any point on that axis, and $p$ a point of the link beyond
# it. A joint that turns, at one radian per second, gives
#
# $$\dot p = \omega \times (p - q)$$
#
# That is a pure rotation. You may find it given for a joint that is "translating and rotating": then the slide along
# the axis is missing. A screw joint slides by $h$ metres for each radian, and $h$ is called its *pitch*. A prismatic
# joint only slides, along a unit vector $v$:
#
# $$\dot p = \omega \times (p - q) + h\,\omega, \qquad\qquad \dot p = v$$
#
# All three can be written with one pair of vectors. Put $v = -\omega \times q + h\,\omega$, and
#
# $$\begin{bmatrix} \dot p \\ 0 \end{bmatrix}
# = \begin{bmatrix} \hat\omega & v \\ 0 & 0 \end{bmatrix} \begin{bmatrix} p \\ 1 \end{bmatrix} = \hat\xi\,\bar p,
# \qquad \xi = \begin{bmatrix} v \\ \omega \end{bmatrix}$$
#
# $\xi$ is the **twist** of the joint. It is six numbers, the linear part first. Source: MLS, section 2.3.2.

# %%
import numpy as np
import pinocchio as pin
from scipy.linalg import expm

from twistarm import guide, joints, screws

axis, q, pitch = np.array([0.0, 0.0, 1.0]), np.array([0.4, 0.0, 0.0]), 0.08
kinds = {
    "revolute": joints.revolute(axis, q)[:, 0],
    "prismatic": joints.prismatic(axis)[:, 0],
    "screw": joints.helical(axis, q, pitch)[:, 0],
}
p = np.array([0.75, 0.0, 0.0])
assert np.allclose(screws.hat(kinds["screw"]) @ [*p, 1], [*(np.cross(axis, p - q) + pitch * axis), 0])
# any point on the axis will do
assert np.allclose(kinds["revolute"], joints.revolute(axis, q + 3 * axis)[:, 0])
guide.table(
    ["joint", "$v_x$", "$v_y$", "$v_z$", r"$\omega_x$", r"$\omega_y$", r"$\omega_z$"],
    [[name, *xi] for name, xi in kinds.items()],
    f"Three joints along $z$; the axes of the first and the last pass through $x = {q[0]}$ m.",
)

# %% tags=["hidden"]
fig, columns = guide.axes3(3, width=6.6, height=3.0, box=False)
amounts = np.linspace(0, 5, 80)
for ax, (name, xi) in zip(columns, kinds.items(), strict=True):
    scale = 0.08 if name == "prismatic" else 1.0
    path = screws.exp(xi, scale * amounts) @ [*p, 1]
    ax.plot(*path[:, :3].T, color=guide.INK, linestyle="-", linewidth=2.0)
    guide.plot_screw(ax, xi if name != "prismatic" else joints.prismatic(axis)[:, 0], length=0.9)
    guide.plot_point(ax, p, "")
    rate = screws.hat(xi) @ [*p, 1]
    guide.plot_vector(ax, p, (0.3 if name == "prismatic" else 1.0) * rate[:3], "", guide.ORANGE)
    guide.fit(ax, [[-0.05, -0.45, -0.45], [0.85, 0.45, 0.45]])
    ax.set_title(name)
guide.figure(
    fig,
    "Three drawings side by side. Revolute: a point goes round an axis on a circle. Prismatic: a point moves along a "
    "straight line. Screw: a point goes round an axis and rises, on a helix. An arrow on each is the velocity.",
    "Revolute, prismatic and screw joint: the path of one point, and its velocity at the start.",
)

# %%
origin_rate = (screws.hat(kinds["revolute"]) @ [0, 0, 0, 1])[:3]
assert np.allclose(origin_rate, kinds["revolute"][:3])
guide.predict(
    "The revolute joint of the table turns on the spot, and yet its $v$ is not zero. Which point moves with the "
    "velocity $v$?",
    "The point of the moving body (think of it as large enough) that is just at the origin of the frame: "
    f"$\\hat\\xi\\,(0, 0, 0, 1)$ is $({', '.join(f'{x:.1f}' for x in origin_rate + 0.0)})$. It is neither the velocity "
    "of the joint nor that of the tool.",
)

# %% [markdown]
# ## The twists of your arm
#
# For each moving joint: its twist seen from the base where all joints stand at zero, and the screw that the twist
# describes. To read the screw off a twist with $\omega \neq 0$:
#
# $$h = \frac{\omega^\top v}{\|\omega\|^2}, \qquad q = \frac{\omega \times v}{\|\omega\|^2}, \qquad M = \|\omega\|$$
#
# $M$ is the *magnitude*. A twist with $\omega = 0$ has $h = \infty$ and $M = \|v\|$. Source: MLS, section 2.3.3.

# %%
arm = guide.arm()
rows = []
for name, xi in zip(arm.moving_names, arm.screws.T, strict=True):
    v, w = xi[:3], xi[3:]
    screw = screws.to_screw(xi)
    if np.linalg.norm(w) > 0.5:
        assert np.isclose(screw.pitch, w @ v / (w @ w))
        assert np.allclose(screw.point, np.cross(w, v) / (w @ w))
    shown = [f"${guide.tex(each)}$" for each in (v, w, screw.point)]
    rows.append([f"`{name}`", *shown, "∞" if np.isinf(screw.pitch) else screw.pitch])
guide.table(
    ["joint", "$v$", r"$\omega$", "point $q$ [m]", "$h$ [m/rad]"], rows, f"The screws of `{arm.name}`."
)

# %%
h = 1e-6
zero = np.zeros(arm.n)
derivative = [
    (arm.fk(h * e) - arm.fk(-h * e)) / (2 * h) @ screws.inverse(arm.fk(zero)) for e in np.eye(arm.n)
]
twists = arm.spatial_jacobian(zero)
assert np.allclose(derivative, [screws.hat(xi) for xi in twists.T], atol=1e-7)
body = screws.adjoint(screws.inverse(arm.home)) @ twists
apart = np.abs(body - twists).max()
guide.say(
    rf"By differences, $\dot g\,g^{{-1}} = \hat\xi$ for each coordinate of `{arm.name}`. You may find $\xi$ called a "
    "*body* velocity. It is the **spatial** one, seen from the base; seen from the tool its numbers differ by up to "
    f"{apart:.2f}. The lesson after this one is about the difference."
)

# %% [markdown]
# ## The exponential
#
# $\dot{\bar p} = \hat\xi\,\bar p$ is again a linear differential equation, and so
# $\bar p(\theta) = e^{\hat\xi\theta}\,\bar p(0)$. The series has a closed form. For a slide, $\omega = 0$:
#
# $$e^{\hat\xi\theta} = \begin{bmatrix} I & v\theta \\ 0 & 1 \end{bmatrix}$$
#
# and for $\|\omega\| = 1$:
#
# $$e^{\hat\xi\theta} = \begin{bmatrix} e^{\hat\omega\theta} &
# (I - e^{\hat\omega\theta})(\omega \times v) + \omega\omega^\top v\,\theta \\ 0 & 1 \end{bmatrix}$$
#
# Source: MLS, section 2.3.2, equations (2.32) and (2.36).


# %%
def exponential(xi, theta):
    """The motion along the twist xi = (v, w), with w = 0 or a unit vector."""
    v, w = xi[:3], xi[3:]
    g = np.eye(4)
    if np.linalg.norm(w) < 1e-9:
        g[:3, 3] = v * theta
        return g
    W = screws.hat(w)
    g[:3, :3] = np.eye(3) + W * np.sin(theta) + W @ W * (1 - np.cos(theta))
    g[:3, 3] = (np.eye(3) - g[:3, :3]) @ np.cross(w, v) + w * (w @ v) * theta
    return g


for xi in [*kinds.values(), *arm.screws.T]:
    assert np.allclose(exponential(xi, 0.7), expm(screws.hat(xi) * 0.7))
    assert np.allclose(exponential(xi, 0.7), pin.exp6(xi * 0.7).homogeneous)
    assert np.allclose(exponential(xi, 0.7), screws.exp(xi, 0.7))

step = 0.4
first = twists[:, 0]
moved = screws.exp(first, step) @ arm.home
if np.count_nonzero(arm.coupling.A[:, 0]) == 1:  # the first coordinate moves one joint, and no mimic
    assert np.allclose(moved, arm.fk(step * np.eye(arm.n)[0]))
forgotten = np.linalg.norm((moved - screws.exp(first, step))[:3, 3])
guide.say(
    r"The exponential moves points *within one frame*, the base's. What was at $g(0)$ is then at "
    r"$g(\theta) = e^{\hat\xi\theta}\,g(0)$. "
    f"Whoever forgets $g(0)$ looks for the tool of `{arm.name}` in a place that is {forgotten:.2f} m from it."
)

# %%
guide.slider(
    "twist",
    "Set the pitch to zero and move the point of the axis. Which part of $\\xi$ changes? Then raise the pitch: which "
    "part changes now, and in which direction?",
    "Moving the axis changes $v = -\\omega \\times q$ alone, at right angles to the axis. The pitch adds $h\\,\\omega$ "
    "to $v$, along the axis. $\\omega$ is the same throughout.",
)

# %% [markdown]
# ## Chasles: every motion is a screw motion
#
# Take any two poses of a body. There is a line about which it can turn and along which it can slide to get from the one
# to the other. That is **Chasles' theorem** (you may find the name misspelt). In formulas: every $g \in SE(3)$ is
# $e^{\hat\xi\theta}$ for some twist. The twist is the *logarithm* of $g$. Sources: MLS, sections 2.3.2 and 2.3.3.
#
# Your arm goes from ready to another pose. All joints move. Here is the one screw that takes the tool there.

# %%
start = arm.fk(arm.ready)
end = arm.fk(0.6 * arm.ready + 0.4 * arm.random_theta(7))
xi = screws.log(end @ screws.inverse(start))  # seen from the base: e^ξ · start = end
screw = screws.to_screw(xi)
path = screws.exp(xi, np.linspace(0, 1, 60)) @ start
assert np.allclose(path[-1], end)
assert np.allclose(screws.exp(pin.log6(pin.SE3(end @ screws.inverse(start))).vector) @ start, end)
assert np.allclose(screw.twist, xi)

places = path[:, :3, 3]
straight = np.linalg.norm(places[-1] - places[0])
length = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
assert length > straight - 1e-9
if np.isinf(screw.pitch):
    words = f"it slides by **{screw.magnitude:.3f} m** and turns nothing"
else:
    words = (
        f"it turns by **{np.degrees(screw.magnitude):.1f}°** about the line and slides by "
        f"**{1000 * screw.pitch * screw.magnitude + 0.0:.1f} mm** along it"
    )
    along = (places - screw.point) @ screw.axis
    radius = np.linalg.norm(places - screw.point - along[:, None] * screw.axis, axis=1)
    assert np.ptp(radius) < 1e-7  # the tool keeps its distance from the line
guide.say(
    f"The tool of `{arm.name}`: {words}. The helix on which it moves is {length:.3f} m long, the straight line "
    f"{straight:.3f} m. An arm that moves in a plane always has the slide zero, and the line is then a point of the "
    "plane, the pole."
)

# %% tags=["hidden"]
fig, ax = guide.axes3(width=5.2, height=4.6)
guide.plot_frame(ax, start, "1", 0.22 * arm.reach, alpha=0.5)
guide.plot_frame(ax, end, "2", 0.22 * arm.reach)
ax.plot(*places.T, color=guide.INK, linestyle="-", linewidth=2.4)
ax.plot(*places[[0, -1]].T, color=guide.GREY, linestyle=":")
# The part of the line that lies beside the tool is drawn.
middle = 0.0 if np.isinf(screw.pitch) else float((places.mean(axis=0) - screw.point) @ screw.axis)
beside = screw.point + middle * screw.axis
if np.linalg.norm(beside - places.mean(axis=0)) < 4 * arm.reach:
    half = 0.4 * arm.reach * screw.axis
    ax.plot(
        *np.array([beside - half, beside + half]).T, color=guide.PINK, linestyle=(0, (7, 2, 1.5, 2))
    )
    ax.text(*(beside + 1.15 * half), r"$\xi$", color=guide.PINK, ha="center", va="center")
guide.fit(ax)
guide.figure(
    fig,
    "The tool's frame at two poses, joined by an arc of a helix and by a dotted straight line. A dash-dotted line "
    "beside them is the screw's axis.",
    "From pose 1 to pose 2 along the screw (solid) and straight (dotted).",
)

# %% [markdown]
# You may find a twist called the time derivative of a screw motion. It is that only at the beginning: a twist is the
# *infinitesimal* screw motion, the velocity, and the screw motion is what becomes of it when it lasts.
#
# The logarithm is not unique. Another full turn about the same line brings the tool to the same orientation, at a
# different slide for each turn; and at a half turn the line may be taken in either direction. `screws.log` takes the
# turn of at most half a circle.
#
# ## What goes wrong in practice
#
# **The order of the six.** MLS and Pinocchio write $(v, \omega)$; Lynch & Park, *Modern Robotics*, write $(\omega, v)$.
# Nothing fails when you mix them: a turn becomes a slide.
#
# **The sign of $v$.** It is $-\omega \times q$, which is $q \times \omega$. With the other sign each joint turns
# about a mirror image of its axis. A joint through the origin does not show it.

# %%
wrong = np.array([*np.cross(axis, q), *axis])
guide.say(
    f"With the sign wrong, the axis at $x = {q[0]}$ m is taken to be at $x = {screws.to_screw(wrong).point[0]:.1f}$ m."
)

# %% [markdown]
# **$v$ taken for the speed of the joint or of the tool.** It belongs to the point at the origin. A joint far from the
# base has a large $v$, and nothing about it is fast.
#
# **A pitch per turn.** Lead screws are sold by millimetres per turn. The pitch $h$ here is per radian: divide by
# $2\pi$, and the carriage moves as the data sheet says.
#
# **The home pose forgotten.** $e^{\hat\xi\theta}$ is a motion, not a pose. A tool that sits at the origin while all
# joints are at zero is a sign.
#
# ## Exercises

# %%
guide.practice("2_2_2_twists_and_screws")
