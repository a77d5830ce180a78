# %% [markdown]
# # Elbow up or elbow down?
#
# You tape a cross onto the bench and want the tip of the arm on it. You know where the cross is, but the motors need
# angles. Forward kinematics goes from the angles to the position. **Inverse kinematics** goes back. For two links in a
# plane you can do it with a triangle. Most arms contain two such links. Most mistakes in inverse kinematics already
# occur here.

# %%
import numpy as np

from twistarm import guide, poe, screws

planar = guide.bundled("rr_planar")
q1, q2 = (screws.to_screw(xi).point for xi in planar.screws.T)
l1, l2 = np.linalg.norm(q2 - q1), np.linalg.norm(planar.home[:3, 3] - q2)
cross = np.array([0.30, 0.35])  # where the cross is [m], seen from the shoulder

# %% [markdown]
# ## The law
#
# Shoulder, elbow and tip are the corners of a triangle. Two of its sides are the links, $l_1$ and $l_2$. The third,
# $r$, is the distance of the cross from the shoulder. The three sides determine the angles. Let $\alpha$ be the angle
# at the elbow, $\beta$ that at the shoulder, and $\varphi$ the direction of the cross. The law of cosines says
#
# $$\cos\alpha = \frac{l_1^2 + l_2^2 - r^2}{2\, l_1 l_2}, \qquad
#   \cos\beta = \frac{r^2 + l_1^2 - l_2^2}{2\, l_1 r}$$
#
# $$r = \sqrt{x^2 + y^2}, \qquad \varphi = \mathrm{atan2}(y, x)$$
#
# The joints count their angles in another way. $\theta_1$ is the direction of the first link. $\theta_2$ is the turn of
# the second link from *that* direction. For the stretched arm $\theta_2 = 0$ and $\alpha = \pi$. On one side $\theta_2$
# is $\pi - \alpha$. On the other side it is $\alpha - \pi$, which is the same direction as $\pi + \alpha$.
#
# The triangle can lie on either side of the line from the shoulder to the cross. So there are two answers. Each is
# called the **flip** of the other:
#
# $$\theta_1 = \varphi + \beta, \quad \theta_2 = \pi + \alpha$$
#
# $$\theta_1 = \varphi - \beta, \quad \theta_2 = \pi - \alpha$$
#
# Source: Murray, Li and Sastry, *A Mathematical Introduction to Robotic Manipulation* (MLS), section 3.3.1.


# %% tags=["shown"]
def triangle(l1, l2, x, y):
    """The angles at elbow and shoulder, and the direction of the target [rad]."""
    r = np.hypot(x, y)
    alpha = np.arccos((l1**2 + l2**2 - r**2) / (2 * l1 * l2))
    beta = np.arccos((r**2 + l1**2 - l2**2) / (2 * l1 * r))
    return alpha, beta, np.arctan2(y, x)


def tip(theta1, theta2):
    """Forward kinematics of the two-link arm."""
    elbow = l1 * np.array([np.cos(theta1), np.sin(theta1)])
    both = theta1 + theta2
    return elbow + l2 * np.array([np.cos(both), np.sin(both)])


def wrap(angle):
    """The same direction, in (−π, π]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


# %%
alpha, beta, phi = triangle(l1, l2, *cross)
up = wrap(np.array([phi + beta, np.pi + alpha]))
down = wrap(np.array([phi - beta, np.pi - alpha]))

# %%


def degrees(angle):
    """An angle for a table."""
    return f"{np.degrees(angle) + 0.0:.1f}°".replace("-", "−")


def arc(ax, centre, start, end, radius, name, colour):
    """An angle, drawn as an arc with its name."""
    at = np.linspace(start, end, 40)
    ax.plot(
        centre[0] + radius * np.cos(at),
        centre[1] + radius * np.sin(at),
        color=colour,
        linestyle="-",
        linewidth=1.2,
    )
    middle = at[20]
    ax.text(
        centre[0] + 1.35 * radius * np.cos(middle),
        centre[1] + 1.35 * radius * np.sin(middle),
        name,
        color=colour,
        ha="center",
        va="center",
    )


def links(ax, theta, colour, style, alpha=1.0):
    """The two links."""
    elbow = l1 * np.array([np.cos(theta[0]), np.sin(theta[0])])
    ax.plot(
        *np.array([[0, 0], elbow, tip(*theta)]).T,
        color=colour,
        linestyle=style,
        linewidth=3,
        marker="o",
        alpha=alpha,
    )
    return elbow


fig, ax = guide.axes2(width=4.6, height=4.0, xlabel="x [m]", ylabel="y [m]", equal=True)
ax.plot(*np.array([[0, 0], cross]).T, color=guide.GREY, linestyle="--", linewidth=1.2)
ax.text(*(0.45 * cross + [0.018, -0.018]), "$r$", color=guide.GREY, ha="center")
links(ax, down, guide.ORANGE, (0, (5, 1.5)))
elbow = links(ax, up, guide.BLUE, "-")
ax.text(*(0.62 * elbow + [0.02, 0.0]), "$l_1$", color=guide.BLUE, ha="center")
ax.text(*(0.5 * (elbow + cross) + [0.0, 0.022]), "$l_2$", color=guide.BLUE, ha="center")
arc(ax, (0, 0), phi, up[0], 0.12, r"$\beta$", guide.BLUE)
arc(ax, (0, 0), 0, phi, 0.07, r"$\varphi$", guide.INK)
arc(ax, (0, 0), 0, down[0], 0.25, r"$\theta_1$", guide.ORANGE)
joint = l1 * np.array([np.cos(down[0]), np.sin(down[0])])
onward = 1.24 * joint
ax.plot(*np.array([joint, onward]).T, color=guide.GREY, linestyle=":", linewidth=1.2)
arc(ax, joint, down[0], down.sum(), 0.06, r"$\theta_2$", guide.ORANGE)
to_base, to_tip = np.arctan2(*-elbow[::-1]), np.arctan2(*(cross - elbow)[::-1])
arc(ax, elbow, to_base, to_base + wrap(to_tip - to_base), 0.05, r"$\alpha$", guide.BLUE)
ax.plot(*cross, "x", color=guide.INK, markersize=10, markeredgewidth=2)
ax.plot([0, 0.36], [0, 0], color=guide.GREY, linewidth=0.8, linestyle="-")
guide.figure(
    fig,
    "Two triangles on the line from the shoulder to a cross: the same two links on either side of it, one solid, one "
    "dashed; the angles alpha, beta and phi of the triangle, and at the dashed links theta 1 from the x axis and theta "
    "2 from the direction of the first link",
    r"Solid: $(+,+)$, the elbow on the left, with the angles of its triangle. Dashed: $(-,-)$, its flip, with the "
    r"angles of its joints.",
)
rows = [
    [words, *map(degrees, theta), degrees(theta.sum())]
    for words, theta in (("$(+,+)$", up), ("$(-,-)$", down))
]
guide.table(
    ["signs", r"$\theta_1$", r"$\theta_2$", r"the tip points along $\theta_1 + \theta_2$"],
    rows,
    f"Both answers for the cross at ({cross[0]:.2f}, {cross[1]:.2f}) m, wrapped into (−180°, 180°].",
)

# %% [markdown]
# Are there more? No. The elbow lies on the circle of radius $l_1$ about the base and on that of radius $l_2$ about the
# cross, and two circles meet in at most two points. The solver of twistarm uses no triangles and starts from the axes
# alone. It finds the same two answers.
#
# ## The signs go together
#
# It is tempting to write both answers in one line, $\theta_2 = \pi \pm \alpha$ and $\theta_1 = \varphi \pm \beta$. But
# this line allows four pairs of signs.

# %%
mixed = np.array([phi - beta, np.pi + alpha])
miss = np.linalg.norm(tip(*mixed) - cross)
guide.predict(
    r"Take mixed signs: $\theta_1 = \varphi - \beta$ with $\theta_2 = \pi + \alpha$. Where is the tip?",
    rf"At the right distance, in the wrong direction. The elbow bends so that the tip is ${np.hypot(*cross):.3f}$ m "
    rf"away, as it should be, but the shoulder turns it to $\varphi - 2\beta$. It misses the cross by "
    rf"$2\, r \sin\beta = 2\, l_2 \sin\alpha$, here {1000 * miss:.0f} mm. With the elbow at a right angle it is twice "
    rf"the length of the second link. Near the stretched arm it is almost zero, so a test there does not find "
    rf"the mistake."
    rf"",
)

# %%
rows = []
for s1, s2 in ((1, 1), (-1, -1), (-1, 1), (1, -1)):
    theta = np.array([phi + s1 * beta, np.pi + s2 * alpha])
    signs = f"$({'+' if s1 > 0 else '-'},{'+' if s2 > 0 else '-'})$"
    off = np.linalg.norm(tip(*theta) - cross)
    rows.append([signs, *map(degrees, wrap(theta)), f"{1000 * off:.1f}"])
guide.table(
    [r"signs of $\beta$ and $\alpha$", r"$\theta_1$", r"$\theta_2$", "off by [mm]"],
    rows,
    "Four pairs of signs.",
)
guide.slider(
    "two_link",
    "Tick *draw the other solution* and the one with mixed signs. For which bend of the elbow are all three the same?",
    r"For $\theta_2 = 0$, the stretched arm, and $\theta_2 = \pm 180°$, the folded one. There $\alpha$ is a half "
    r"turn or "
    r"zero, $\sin\alpha = 0$, and the triangle is flat: the two answers are one.",
    l1=round(float(l1), 3),
    l2=round(float(l2), 3),
    theta1=round(float(np.degrees(down[0]))),
    theta2=round(float(np.degrees(down[1]))),
)

# %% [markdown]
# ## At the edges
#
# A triangle with the sides $l_1$, $l_2$ and $r$ exists only if
#
# $$\left|l_1 - l_2\right| \le r \le l_1 + l_2$$
#
# Inside this ring there are two answers. On its edges there is one. Outside there is none, and the cosine leaves $[-1,
# 1]$. If the links are equally long, the ring has no hole. Then $r = 0$ is reachable, with every $\theta_1$. The
# formula for $\beta$ divides by zero there, because the answer is not unique.
#
# There is trouble near the edges, too.

# %%
short = l1 + l2 - 0.001
bend = np.pi - triangle(l1, l2, short, 0.0)[0]
guide.predict(
    f"The links are {l1:.2f} and {l2:.2f} m long. The cross lies one millimetre closer than the arm can stretch. How "
    "far is the elbow bent?",
    rf"By {np.degrees(bend):.1f}°. Near the edge $r$ hardly changes as the elbow bends. So the elbow must bend "
    rf"a lot for a small change of $r$: the bend grows as the square root of the distance to the edge. For the "
    rf"last millimetre outward the elbow turns by all of these {np.degrees(bend):.1f}°. For a constant speed "
    rf"of the tip, the motor would have to be infinitely fast at the end."
    rf"",
)

# %%
r = (l1 + l2) - (2 * min(l1, l2)) * (1 - np.cos(np.linspace(0, np.pi, 201))) / 2
elbow_bend = np.pi - np.arccos(np.clip((l1**2 + l2**2 - r**2) / (2 * l1 * l2), -1, 1))
fig, ax = guide.axes2(xlabel="distance r of the target [m]", ylabel="θ₂ [°]", height=3.4)
ax.plot(r, -np.degrees(elbow_bend), label="(+,+)")
ax.plot(r, np.degrees(elbow_bend), label="(−,−)")
for edge, words, side in ((l1 + l2, "stretched", "right"), (abs(l1 - l2), "folded", "left")):
    ax.axvline(edge, color=guide.GREY, linewidth=0.8, linestyle=":")
    ax.text(edge, 205, words, color=guide.GREY, ha=side, va="bottom")
ax.set_yticks(range(-180, 181, 60))
ax.legend(loc="center")
guide.figure(
    fig,
    "The bend of the elbow against the distance of the target, for both answers: the two curves are each other's "
    "mirror "
    "image, and both are vertical at the two edges of the ring",
    "Both answers over the whole ring. At its edges they become one, and the curves are vertical.",
)

# %% [markdown]
# At the edge itself, rounding causes trouble. A point at exactly $l_1 + l_2$ is reachable, but the computed cosine may
# be below $-1$. Then `arccos` gives `nan`, and `nan` goes to the motors. So first decide by $r$, with a tolerance,
# whether the point is reachable. Then bring the cosine back into $[-1, 1]$.

# %%
many = np.random.default_rng(0).uniform(0.1, 0.9, (10_000, 2))
stretched = many.sum(axis=1)
cosine = ((many**2).sum(axis=1) - stretched**2) / (2 * many.prod(axis=1))
lost = int((np.abs(cosine) > 1).sum())
guide.say(
    f"Of {len(many):,} two-link arms with random lengths, {lost:,} have a cosine such as −{-cosine.min():.16f} at "
    f"their own full stretch, and `nan` for an angle. With `np.clip(cosine, -1, 1)` none has."
)

# %% [markdown]
# ## The two links inside your arm
#
# Two successive joints with parallel axes are a two-link arm, at any place and with any zero. The first link goes from
# one axis to the other. The second goes from there to what the two carry: the next joint, or the tool. You can flip it
# without a formula for $\theta$. Take the present configuration, and measure two signed angles. $\beta$ is the angle at
# the shoulder, from what is carried to the first link. $\theta_2$ goes from the direction of the first link to that of
# the second. Then turn the shoulder by $-2\beta$ and the elbow by $-2\theta_2$. This mirrors the triangle.


# %%
def two_links(arm):
    """The first of two parallel turning joints that carry something and have separate coordinates, or None."""
    A = arm.coupling.A
    points = guide.arm_points(arm, arm.ready)
    axes = poe.spatial_jacobian(arm.screws, A @ arm.ready)[3:]
    for i in range(len(A) - 1):
        w = axes[:, i]
        own = (A[i : i + 2] != 0).sum(axis=1).tolist() == [1, 1]
        if not own or np.linalg.norm(axes[:, i]) < 0.5 or np.linalg.norm(axes[:, i + 1]) < 0.5:
            continue
        k = [int(np.flatnonzero(row)[0]) for row in A[i : i + 2]]
        if k[0] == k[1] or A[:i, k].any() or np.linalg.norm(np.cross(w, axes[:, i + 1])) > 2e-3:
            continue
        lengths = [np.linalg.norm(np.cross(w, points[j + 1] - points[j])) for j in (i + 1, i + 2)]
        if min(lengths) > 0.05 * arm.reach:
            return i
    return None


arm = guide.arm_with(
    "two parallel turning joints, one after the other", lambda a: two_links(a) is not None
)
first = two_links(arm)


def flipped(arm, theta, i):
    """The configuration with the other elbow: moving joints i and i + 1 have parallel axes."""
    values = arm.coupling.A @ theta
    points = guide.arm_points(arm, theta)
    a, b, c = points[i + 1 : i + 4]  # shoulder, elbow, what they carry
    w, w_next = poe.spatial_jacobian(arm.screws, values)[3:, i : i + 2].T

    def angle(u, v):  # from u to v about w
        return np.arctan2(w @ np.cross(u, v), np.cross(w, u) @ np.cross(w, v))

    turn = np.zeros(len(values))
    turn[i] = -2 * angle(c - a, b - a)
    turn[i + 1] = -2 * angle(b - a, c - b) * np.sign(w @ w_next)
    k = [int(np.flatnonzero(row)[0]) for row in arm.coupling.A[i : i + 2]]
    other = theta.copy()
    other[k] += turn[i : i + 2] / arm.coupling.A[[i, i + 1], k]
    return other


# %%
starts = [arm.ready, *arm.random_theta(np.random.default_rng(0), 200)]
lower, upper = arm.limits.lower, arm.limits.upper
k_pair = [int(np.flatnonzero(row)[0]) for row in arm.coupling.A[first : first + 2]]


def wrapped_inside(theta):
    """Whole turns taken off the pair where that brings it inside the limits."""
    theta = theta.copy()
    for k in k_pair:
        for turn in (0.0, 2 * np.pi, -2 * np.pi):
            if lower[k] <= theta[k] + turn <= upper[k]:
                theta[k] += turn
                break
    return theta


pairs = [(theta, wrapped_inside(flipped(arm, theta, first))) for theta in starts]
pairs = [(t, o) for t, o in pairs if 0.6 < np.abs(wrap(o - t)).max() < 2.8] or pairs
inside = [(t, o) for t, o in pairs if arm.limits.contains(o)]
theta, other = (inside or pairs)[0]
here, there = guide.arm_points(arm, theta), guide.arm_points(arm, other)
carried_off = float(np.linalg.norm(here[first + 3] - there[first + 3]))
what = "tool" if first + 3 == len(here) - 1 else f"joint `{arm.moving_names[first + 2]}`"
w = poe.spatial_jacobian(arm.screws, arm.coupling.A @ theta)[3:, first]
own_l1, own_l2 = (np.linalg.norm(np.cross(w, here[first + j + 1] - here[first + j])) for j in (1, 2))
guide.say(
    f"On `{arm.name}` the two links are those of `{arm.moving_names[first]}` and `{arm.moving_names[first + 1]}`: "
    f"$l_1 = {own_l1:.3f}$ m, $l_2 = {own_l2:.3f}$ m, and they carry the {what}."
)
guide.table(
    ["joint", "configuration", "its flip"],
    [[f"`{arm.joint_names[k]}`", degrees(theta[k]), degrees(other[k])] for k in k_pair],
    f"By forward kinematics the {what} is at the same place in both, "
    + (f"to ${guide.rough(carried_off)}$ m." if carried_off > 1e-12 else "to the last digit."),
)
guide.say(
    "Both configurations are inside the limits of the joints."
    if inside
    else "The flip lies outside the limits: with these limits the arm has only one elbow."
)

# %%
upright = np.hypot(w[0], w[1]) > 0.5  # whether the two links move in an upright plane
azimuth = (np.degrees(np.arctan2(w[1], w[0])) % 180) - 160 if upright else -35.0
fig, ax = guide.axes3(width=5.0, height=4.2, elev=12 if upright else 45, azim=float(azimuth))
guide.plot_arm(ax, arm, theta, guide.BLUE, tool=False)
guide.plot_arm(ax, arm, other, guide.ORANGE, alpha=0.7, tool=False)
guide.plot_point(ax, here[first + 3], "", guide.INK, "D")
guide.figure(
    fig,
    f"{arm.name} twice, with the elbow on either side; the {what} is at the same place both times",
    f"`{arm.name}` and its flip; the diamond marks what stays in place. What lies beyond the {what} points "
    f"elsewhere. To keep the tool's direction too, the joints beyond must turn back. The next lesson does that.",
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **Mixed signs.** The distance is right, and the direction is wrong, by $2\beta$. Test with the elbow well bent: on
#   the stretched arm $\beta = 0$, and the mistake does not show.
# - **No clamp.** The program works everywhere, except that it sends `nan` for the stretched arm. Clip the cosine.
# - **No wrap.** $\pi + \alpha$ is between half a turn and a whole one. A joint with limits of ±150° refuses it,
#   although the same angle less a whole turn is allowed.
# - **`atan(y / x)`.** It cannot tell a cross in front of the arm from one behind it. It divides by zero where $x = 0$.
#   Use `atan2(y, x)`.
# - **Flipping on the way.** A program that takes either answer at each point of a line may change the elbow in the
#   middle. Choose once. Then keep to the answer nearest to the present configuration.

# %%
behind = -cross
alpha_b, beta_b, phi_b = triangle(l1, l2, *behind)
by_atan = np.array([np.arctan(behind[1] / behind[0]) - beta_b, np.pi - alpha_b])
jump = np.abs(wrap(up - down)).max()
guide.table(
    ["slip", "how it shows"],
    [
        ["mixed signs", f"{1000 * miss:.0f} mm beside the cross"],
        [
            "`atan(y / x)`, the cross behind the arm",
            f"{1000 * np.linalg.norm(tip(*by_atan) - behind):.0f} mm off",
        ],
        [
            "no wrap",
            rf"$\theta_2$ = {degrees(np.pi + alpha)} where {degrees(wrap(np.pi + alpha))} is meant",
        ],
        ["flipping on the way", f"a joint jumps by {degrees(jump)}"],
    ],
    f"On `{planar.name}`, for the cross above.",
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_2_two_link_arm")
