# %% [markdown]
# # Twists and screws
#
# The driver moves all joints at once, and the gripper goes from one pose to another. One sentence describes what it
# did: it turned about **one line** and slid along it, as a nut does on its bolt. Each single joint of your arm does the
# same to everything beyond it.
#
# ## What a joint does to a point
#
# Let $\omega$ be the unit vector along a joint's axis and $q$ any point on that axis. Let $p$ be a point of the link
# beyond the joint. A revolute joint turns. At one radian per second it gives this point the velocity
#
# $$\dot p = \omega \times (p - q)$$
#
# This is rotation alone. A helical joint, a nut on a threaded rod, also slides by $h$ metres for each radian. The
# number $h$ is its *pitch*. A prismatic joint only slides, along a unit vector $v$. The
# equation on the left is that of the helical joint, the one on the right that of the prismatic joint:
#
# $$\dot p = \omega \times (p - q) + h\,\omega, \qquad\qquad \dot p = v$$
#
# One pair of vectors describes all three. For a joint that turns, let $v = -\omega \times q + h\,\omega$, with $h = 0$
# for the revolute one. A slide has its own $v$, and $\omega = 0$. Then
#
# $$\begin{bmatrix} \dot p \\ 0 \end{bmatrix}
# = \begin{bmatrix} \hat\omega & v \\ 0 & 0 \end{bmatrix} \begin{bmatrix} p \\ 1 \end{bmatrix} = \hat\xi\,\bar p,
# \qquad \xi = \begin{bmatrix} v \\ \omega \end{bmatrix}$$
#
# The bar puts a 1 below the point, as in the lesson on rigid motions. $\xi$ is the **twist** of the joint: six numbers,
# the linear part first. Source: Murray, Li and Sastry, *A Mathematical Introduction to Robotic Manipulation* (MLS),
# section 2.3.2.

# %%
import numpy as np

from twistarm import guide, joints, rotations, screws

axis, q, pitch = np.array([0.0, 0.0, 1.0]), np.array([0.4, 0.0, 0.0]), 0.08
kinds = {
    "revolute": joints.revolute(axis, q)[:, 0],
    "prismatic": joints.prismatic(axis)[:, 0],
    "helical": joints.helical(axis, q, pitch)[:, 0],
}
p = np.array([0.75, 0.0, 0.0])
guide.table(
    ["joint", "$v_x$", "$v_y$", "$v_z$", r"$\omega_x$", r"$\omega_y$", r"$\omega_z$"],
    [[name, *xi] for name, xi in kinds.items()],
    f"Three joints along $z$; the axes of the first and the last pass through $x = {q[0]}$ m.",
)

# %%
fig, columns = guide.axes3(3, width=6.6, height=3.0, box=False)
amounts = np.linspace(0, 5, 80)
for ax, (name, xi) in zip(columns, kinds.items(), strict=True):
    slides = name == "prismatic"
    path = screws.exp(xi, (0.08 if slides else 1.0) * amounts) @ [*p, 1]
    ax.plot(*path[:, :3].T, color=guide.INK, linestyle="-", linewidth=2.0)
    guide.plot_screw(
        ax, xi, 0.9, "$v$" if slides else r"$\omega$", guide.ORANGE if slides else guide.PINK, near=q
    )
    if not slides:
        guide.plot_point(ax, q, "$q$")
    guide.plot_point(ax, p, "")
    guide.plot_motion(guide.plot_point, ax, path[:, :3], "", guide.BLUE)
    ax.text(*(p + [0, 0, -0.1]), "$p$", ha="center", va="center")
    rate = (screws.hat(xi) @ [*p, 1])[:3]
    arrow = (0.3 if slides else 0.8) * rate
    guide.plot_vector(ax, p, arrow, "", guide.AMBER)
    ax.text(*(p + arrow + [0.08, 0, 0.03]), r"$\dot p$", color=guide.AMBER, ha="center", va="center")
    ax.set_title(name)
guide.figure(
    fig,
    "Three drawings side by side. Revolute: a point p goes round an axis through q on a circle. "
    "Prismatic: a point moves along a straight line. Helical: a point goes round an axis and rises, "
    "on a helix. An arrow on each is its velocity.",
    "Revolute, prismatic and helical joint: the path of one point $p$, and its velocity at the start.",
)

# %%
origin_rate = (screws.hat(kinds["revolute"]) @ [0, 0, 0, 1])[:3]
guide.predict(
    "The revolute joint of the table does not slide, but its $v$ is not zero. Which point moves with the velocity $v$?",
    "The point of the moving body that is now at the origin of the frame, if you imagine the body "
    "large enough to have one there: "
    f"its velocity, the upper part of $\\hat\\xi\\,(0, 0, 0, 1)$, is ${guide.tex(origin_rate, 1)}$. It is "
    "neither the velocity of the joint nor that of the tool.",
)

# %% [markdown]
# ## The twists of your arm
#
# The table shows the twist of each moving joint and the screw that the twist describes. Both are seen from the base,
# with all joints at zero. The $\omega$ of a twist may have any length, that of a joint has the length 1. A twist with
# $\omega \neq 0$ gives the pitch and a point of the axis by
#
# $$h = \frac{\omega^T v}{\|\omega\|^2}, \qquad q = \frac{\omega \times v}{\|\omega\|^2}, \qquad m = \|\omega\|$$
#
# where $q$ is the point of the axis nearest to the origin, and $m$ is the *magnitude* ($M$ in MLS). A twist with
# $\omega = 0$ has $h = \infty$ and $m = \|v\|$. Source: MLS, section 2.3.3.

# %%
arm = guide.arm()
rows = []
for name, xi in zip(arm.moving_names, arm.screws.T, strict=True):
    v, w = xi[:3], xi[3:]
    screw = screws.to_screw(xi)
    cells = [
        ", ".join(f"{x:g}" for x in np.round(vector, 3) + 0.0).replace("-", "−")
        for vector in (v, w, screw.point)
    ]
    rows.append([f"`{name}`", *cells, "∞" if np.isinf(screw.pitch) else screw.pitch])
guide.table(
    ["joint", "$v$", r"$\omega$", "point $q$ [m]", "$h$ [m/rad]"], rows, f"The screws of `{arm.name}`."
)
guide.scene(
    arm,
    caption="The axes of these screws, labelled with their pitches. The table is for joints at zero. Move a joint: the "
    "axes after it move too.",
    quantity="screws",
)

# %% [markdown]
# ## The exponential
#
# Now let the joint move by $\theta$ radians. $d\bar p/d\theta = \hat\xi\,\bar p$ is again a linear differential
# equation, so $\bar p(\theta) = e^{\hat\xi\theta}\,\bar p(0)$. Geometry says what this matrix must do. With $\omega =
# 0$ every point is shifted by $v\theta$. With $\|\omega\| = 1$ a point turns about the axis, which passes through $q$,
# and slides along it:
#
# $$p(\theta) = q + e^{\hat\omega\theta}\,(p(0) - q) + h\,\theta\,\omega$$
#
# To check it, differentiate by $\theta$: you get $dp/d\theta = \omega \times (p - q) + h\,\omega$. Now insert $q =
# \omega \times v$ and $h = \omega^T v$. The factor of $p(0)$ is the rotation of $e^{\hat\xi\theta}$, the sum of the
# other terms its shift:
#
# $$e^{\hat\xi\theta} = \begin{bmatrix} e^{\hat\omega\theta} &
# (I - e^{\hat\omega\theta})(\omega \times v) + \omega\omega^T v\,\theta \\ 0 & 1 \end{bmatrix}$$
#
# and for $\omega = 0$
#
# $$e^{\hat\xi\theta} = \begin{bmatrix} I & v\theta \\ 0 & 1 \end{bmatrix}$$
#
# Source: MLS, section 2.3.2, equations (2.32) and (2.36). Only the product $\xi\theta$ matters. So for any other
# $\omega$, divide $\xi$ by $\|\omega\|$ and multiply $\theta$ by it.


# %% tags=["shown"]
def exponential(xi, theta):
    """The motion along the twist xi = (v, w), with w = 0 or a unit vector."""
    v, w = xi[:3], xi[3:]
    g = np.eye(4)
    if np.linalg.norm(w) < 1e-9:
        g[:3, 3] = v * theta
        return g
    W = rotations.skew(w)
    g[:3, :3] = np.eye(3) + W * np.sin(theta) + W @ W * (1 - np.cos(theta))
    g[:3, 3] = (np.eye(3) - g[:3, :3]) @ np.cross(w, v) + w * (w @ v) * theta
    return g


# %%
step = 0.4
first = arm.screws[:, 0]  # of the joint nearest to the base
moved = exponential(first, step) @ arm.home
forgotten = np.linalg.norm((moved - exponential(first, step))[:3, 3])
guide.say(
    "The exponential is a motion. It moves points *within one frame*, that of the base. A body at $g(0)$ is "
    "afterwards at"
    r" $g(\theta) = e^{\hat\xi\theta}\,g(0)$. "
    f"Without $g(0)$ the computed tool of `{arm.name}` is {forgotten:.2f} m off."
)

# %%
guide.slider(
    "twist",
    "Set the pitch to zero and move the point of the axis. Which part of $\\xi$ changes? Then raise "
    "the pitch: which part changes now, and in which direction?",
    "Moving the axis changes $v = -\\omega \\times q$ alone, at right angles to the axis. The pitch "
    "adds $h\\,\\omega$ to $v$, along the axis. $\\omega$ is the same throughout.",
)

# %% [markdown]
# ## Back again: the logarithm, and Chasles' theorem
#
# Take any two poses of a body. There is a line such that a turn about it and a slide along it lead from the one to the
# other. This is **Chasles' theorem**. As a formula: every $g = (p, R) \in SE(3)$ is $e^{\hat\xi\theta}$ for some twist,
# and $\xi\theta$ is its *logarithm*. The proof computes it in three cases:
#
# - $R = I$: the body is only shifted; $\omega = 0$ and $v\theta = p$.
# - $0 < \theta < \pi$: $\omega\theta$ is the logarithm of $R$, from the lesson on exponentials of rotations. The upper
#   right corner of $e^{\hat\xi\theta}$ must be $p$. It is linear in $v$, a matrix $G$ times $v$, because $\omega \times
#   v = \hat\omega v$. Solve for $v$:
#
# $$G\,v = p, \qquad G = (I - e^{\hat\omega\theta})\,\hat\omega + \omega\omega^T\theta$$
#
# - $\theta = \pi$: the same $G$, but $\omega$ comes from $R + I = 2\,\omega\omega^T$, and $-\omega$ is as good as
#   $\omega$.
#
# $G$ can be inverted for $0 < \theta < 2\pi$. Sources: MLS, section 2.3.2 (proposition 2.9) and 2.3.3.


# %% tags=["shown"]
def logarithm(g):
    """The twist (v, w) with the exponential g; w has the length of the angle."""
    R, p = g[:3, :3], g[:3, 3]
    turned = rotations.log(R)
    theta = np.linalg.norm(turned)
    if theta < 1e-9:
        return np.concatenate([p, np.zeros(3)])
    w = turned / theta
    G = (np.eye(3) - R) @ rotations.skew(w) + np.outer(w, w) * theta
    return np.concatenate([np.linalg.solve(G, p) * theta, turned])


# %% [markdown]
# Your arm goes from ready to another configuration, and all joints move. One screw motion takes the tool there:

# %%
start = arm.fk(arm.ready)
end = arm.fk(0.6 * arm.ready + 0.4 * arm.random_theta(7))
xi = logarithm(end @ screws.inverse(start))  # seen from the base: e^ξ · start = end
screw = screws.to_screw(xi)
path = screws.exp(xi, np.linspace(0, 1, 60)) @ start

places = path[:, :3, 3]
straight = np.linalg.norm(places[-1] - places[0])
length = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
if np.isinf(screw.pitch):
    words = f"it slides by **{screw.magnitude:.3f} m** and does not turn"
else:
    slide = 1000 * float(screw.pitch * screw.magnitude)
    way = "in the direction of its axis" if slide > 0 else "against the direction of its axis"
    words = f"it turns by **{np.degrees(screw.magnitude):.1f}°** about the line and " + (
        f"slides by **{abs(slide):.1f} mm** along it, {way}"
        if abs(slide) > 0.05
        else "does not slide along it"
    )
guide.say(
    f"The tool of `{arm.name}`: {words}. Its path is {length:.3f} m long, the straight line "
    f"{straight:.3f} m."
)

# %%
planar = guide.bundled("rr_planar")
a, b, c = np.array([[0.3, 0.9], [0.6, 0.9], [0.9, 0.3]])
bent, shifted = (
    screws.to_screw(logarithm(planar.fk(to) @ screws.inverse(planar.fk(a)))) for to in (b, c)
)
guide.predict(
    "The two-link arm moves in a plane. What do the screws of its motions look like? Is there a "
    "motion whose screw is of another kind?",
    "The axis is perpendicular to the plane and the slide is zero: every motion is a turn about one "
    "point of the plane, its *pole*. The exception is a motion that does not turn the hand. From "
    f"${guide.tex(a, 1)}$ to ${guide.tex(c, 1)}$ rad the two angles have the same sum: the hand is "
    f"only shifted, by {shifted.magnitude:.3f} m, $h = \\infty$, and there is no pole.",
)

# %%
fig, ax = guide.axes3(width=5.2, height=4.6)
guide.plot_frame(ax, start, "1", 0.22 * arm.reach, alpha=0.5)
guide.plot_motion(guide.plot_frame, ax, path[1::2], "2", 0.22 * arm.reach)
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
guide.figure(
    fig,
    "The tool's frame at two poses, joined by an arc of a helix and by a dotted straight line. A "
    "dash-dotted line beside them is the screw's axis.",
    "From pose 1 to pose 2 along the screw (solid) and straight (dotted).",
)

# %% [markdown]
# A twist is a velocity: the screw motion at one instant. If it stays constant for a while, the result is a screw
# motion. (Some texts call the twist the derivative of the screw motion. The derivative is $\hat\xi e^{\hat\xi\theta}$,
# which is $\hat\xi$ at $\theta = 0$ only.)
#
# The logarithm is not unique. One more full turn about the same line, with the same total slide, leads to the same
# pose. The turn is then $\theta + 2\pi$. If $\theta$ is 90°, it is 450°, and the pitch is a fifth. At a half
# turn the line may have either direction. `screws.log` takes the turn of at most half a circle.
#
# ## What goes wrong in practice
#
# **The order of the six.** MLS and Pinocchio write $(v, \omega)$; Lynch & Park, *Modern Robotics*, write $(\omega, v)$.
# If you mix them, no program complains, and a turn becomes a slide.
#
# **The sign of $v$.** It is $-\omega \times q$, which is $q \times \omega$. With the other sign each joint turns about
# the parallel line on the other side of the origin, through $-q$. A joint through the origin does not show the mistake.

# %%
wrong = np.array([*np.cross(axis, q), *axis])
guide.say(
    f"With the sign wrong, the axis at $x = {q[0]}$ m is taken to be at $x = "
    f"{screws.to_screw(wrong).point[0]:.1f}$ m."
)

# %% [markdown]
# **$v$ taken for the speed of the joint or of the tool.** It is the velocity of the point at the origin. A joint far
# from the origin has a large $v$, even if it turns slowly.
#
# **A pitch per turn.** Data sheets of lead screws give millimetres per turn. The pitch $h$ here is per radian: divide
# by $2\pi$.
#
# **The start forgotten.** $e^{\hat\xi\theta}$ is a motion, not a pose. If the computed tool sits at the origin while
# all joints are at zero, the factor $g(0)$ is missing.
#
# ## Exercises

# %%
guide.practice("2_2_2_twists_and_screws")
