# %% [markdown]
# # What do you send every ten milliseconds?
#
# The arm is folded, and you have recorded the configuration in which it should be. You send the new angles to the
# motors, all at once. The arm bangs, the battery's fuse blows, and the rover has moved by a hand's width. The angles
# were right. But you did not say how to get there.
#
# You need a **path**, which says where, and a **time law**, which says when.

# %%
import numpy as np
from scipy.interpolate import CubicSpline

from twistarm import (
    LimitError,
    LineMove,
    PathError,
    TwistarmError,
    guide,
    plan,
    plan_joint,
    rotations,
    screws,
)

arm = guide.arm()
start = arm.ready
goal = start + 0.4 * (arm.random_theta(7) - start)  # some configuration inside the limits

# %% [markdown]
# ## The straight path and its time law
#
# The simplest path is straight in joint space: every joint goes from its first value to its last, all in proportion.
# The number $s$ from 0 to 1 is the share of the way:
#
# $$\theta(t) = \theta_0 + s(t)\,(\theta_1 - \theta_0)$$
#
# It remains to choose $s(t)$. It begins at 0 and ends at 1, at the time $T$. The arm is at rest at both ends. These are
# four conditions, and a polynomial with four coefficients meets them: the **cubic**. With $u = t/T$, the share of the
# time,
#
# $$s = 3u^2 - 2u^3$$
#
# Source: Lynch & Park, *Modern Robotics*, section 9.2.2. Four linear equations give it:

# %% tags=["shown"]
#            u³    u²   u   1
conditions = [
    [0.0, 0.0, 0.0, 1.0],  # s(0)
    [1.0, 1.0, 1.0, 1.0],  # s(1)
    [0.0, 0.0, 1.0, 0.0],  # s'(0)
    [3.0, 2.0, 1.0, 0.0],  # s'(1)
]
cubic = np.poly1d(np.linalg.solve(conditions, [0.0, 1.0, 0.0, 0.0]))

# %%
u = np.linspace(0, 1, 1001)
fastest, hardest = np.abs(cubic.deriv()(u)).max(), np.abs(cubic.deriv(2)(u)).max()
guide.predict(
    "You halve the time $T$ of a move. By which factors do the greatest velocity and the greatest acceleration "
    "grow?",
    "The velocity doubles, and the acceleration becomes four times as large. The acceleration needs torque, "
    "so the torque grows with the square of the speed.",
)
guide.say(
    rf"In numbers: let a joint go by $d = \theta_1 - \theta_0$. The steepest slope of $s(u)$ is {fastest:.1f}, so the "
    rf"joint's greatest velocity is ${fastest:.1f}\, \lvert d \rvert / T$. The greatest curvature is {hardest:.0f}, so "
    rf"its greatest acceleration is ${hardest:.0f}\, \lvert d \rvert / T^2$."
)

# %% [markdown]
# ## Two more conditions: the quintic
#
# The cubic begins with its greatest acceleration. Before the start the acceleration is zero, so the torque *jumps*, and
# a long thin arm shakes. Ask for zero acceleration at both ends as well. These are six conditions for six coefficients:
#
# $$s = 10u^3 - 15u^4 + 6u^5$$

# %% tags=["shown"]
quintic = np.poly1d([6.0, -15.0, 10.0, 0.0, 0.0, 0.0])
peaks = {}
for name, law in (("cubic", cubic), ("quintic", quintic)):
    peaks[name] = [float(np.abs(law.deriv(k)(u)).max()) for k in (1, 2, 3)]

# %%
guide.table(
    [
        "law",
        r"greatest velocity, times $\lvert d \rvert/T$",
        r"acceleration, times $\lvert d \rvert/T^2$",
        r"jerk, times $\lvert d \rvert/T^3$",
    ],
    [[name, *(f"{peak:.2f}" for peak in row_of_peaks)] for name, row_of_peaks in peaks.items()],
    "What the same move in the same time needs. **Jerk** is the rate at which the acceleration changes. For "
    "the cubic, the jerk is that between the ends: at the ends the acceleration jumps.",
)
fig, panels = guide.axes2(3, width=6.6, height=2.5, xlabel="t / T")
for ax, k, words in zip(panels, range(3), ("s", "velocity", "acceleration"), strict=True):
    for name, law, style in (("cubic", cubic, "-"), ("quintic", quintic, "--")):
        colour = guide.BLUE if name == "cubic" else guide.ORANGE
        t = np.array([-0.15, 0, *u, 1, 1.15])
        values = np.array([0, 0, *law.deriv(k)(u), 0, 0]) if k else np.array([0, 0, *law(u), 1, 1])
        ax.plot(t, values, color=colour, linestyle=style, label=name)
    ax.set_title(words)
panels[0].legend(fontsize=8, loc="upper left")
guide.figure(
    fig,
    "Position, velocity and acceleration of the cubic and the quintic over time: the acceleration of the cubic jumps "
    "at both ends, that of the quintic begins and ends at zero",
    "From rest to rest. The cubic is gentler in the middle, the quintic at the ends.",
)


def with_end_velocity(velocity):
    """The greatest velocity of the cubic by 90° in 2 s, from rest to that velocity [°/s]."""
    slopes = CubicSpline([0, 2], [0, 90], bc_type=((1, 0.0), (1, velocity)))
    return float(np.abs(slopes(np.linspace(0, 2, 1001), 1)).max())


at_rest, going_on, coming_back = map(with_end_velocity, (0.0, 45.0, -60.0))
guide.slider(
    "spline",
    "Give the cubic a positive velocity at its end, and then a negative one. How does its greatest velocity "
    "change? And which two velocities, at the start and at the end, make the acceleration zero?",
    f"From rest to rest it is {at_rest:.1f} °/s. If the joint ends with +45 °/s, it is less: {going_on:.1f} "
    f"°/s. If it ends with −60 °/s, it overshoots and comes back, and the greatest velocity grows to "
    f"{coming_back:.1f} °/s. The acceleration is zero if both ends have the mean velocity $d/T$: the cubic is "
    f"then a straight line.",
    kind="cubic",
    start=0,
    end=90,
    duration=2,
    velocity_start=0,
    velocity_end=0,
)

# %% [markdown]
# ## Limits: how long must it take?
#
# Solve the peaks for $T$. A joint with the distance $d$, the velocity limit $\dot\theta_{\max}$ and the acceleration
# limit $\ddot\theta_{\max}$ needs at least
#
# $$T = \max\left(\frac{3}{2} \frac{\lvert d \rvert}{\dot\theta_{\max}},\;
#   \sqrt{\frac{6\,\lvert d \rvert}{\ddot\theta_{\max}}}\right)$$
#
# All joints share one $s(t)$. So the slowest joint sets the time, and all joints arrive together.
#
# A URDF may have velocity limits, but it has no acceleration limits. If your arm's files give none, this lesson takes
# an acceleration that reaches full speed in half a second. If they give no velocity limit either, it takes one radian
# or one metre per second.

# %%
given = arm.limits
velocity = np.where(np.isfinite(given.velocity), given.velocity, 1.0)
acceleration = np.where(np.isfinite(given.acceleration), given.acceleration, 2.0 * velocity)
limits = {
    "velocity": dict(zip(arm.joint_names, velocity.tolist(), strict=True)),
    "acceleration": dict(zip(arm.joint_names, acceleration.tolist(), strict=True)),
}
d = np.abs(goal - start)
by_velocity, by_acceleration = 1.5 * d / velocity, np.sqrt(6 * d / acceleration)
shortest = max(by_velocity.max(), by_acceleration.max())

T = shortest * (1 + 1e-9)
while True:  # an arm with limits of its motors or of jerk besides needs longer
    try:
        motion = plan_joint(arm, [start, goal], times=[0, T], kind="cubic", limits=limits)
        break
    except LimitError:
        T *= 1.05

# %%
turns = np.array([unit == "rad" for unit in arm.units])
units = [("°", 180 / np.pi) if turn else (" m", 1.0) for turn in turns]
guide.table(
    ["joint", "way", "limits", r"$T$ by velocity", r"$T$ by acceleration"],
    [
        [
            f"`{name}`",
            f"{way * k:.{1 if k > 1 else 3}f}{unit}",
            f"{v * k:.{0 if k > 1 else 2}f}{unit}/s, {a * k:.{0 if k > 1 else 2}f}{unit}/s²",
            f"{first:.2f} s",
            f"{second:.2f} s",
        ]
        for name, way, (unit, k), v, a, first, second in zip(
            arm.joint_names, d, units, velocity, acceleration, by_velocity, by_acceleration, strict=True
        )
    ],
    f"One move of `{arm.name}`.",
)
slowest = int(np.argmax(np.maximum(by_velocity, by_acceleration)))
guide.say(
    f"`{arm.joint_names[slowest]}` is the slowest, with {shortest:.2f} s. `plan_joint` allows {motion.duration:.2f} s"
    + (
        "."
        if np.isclose(motion.duration, shortest)
        else ": this arm has limits of its motors or of jerk besides."
    )
    + " It computes the peaks of the polynomials, not of samples, so it misses no peak."
)
quick = max((15 / 8 * d / velocity).max(), np.sqrt(10 / np.sqrt(3) * d / acceleration).max())
curve = plan_joint(arm, [start, goal], kind="s_curve", limits=limits).duration
guide.predict(
    "Will the quintic need more time than the cubic, or less?",
    f"It depends on the limit that is reached. At the velocity limit, the quintic is slower (15/8 against "
    f"3/2). At the acceleration limit, it is slightly faster"
    rf" ($10/\sqrt 3 = {10 / np.sqrt(3):.2f}$ against 6). Here: {quick:.2f} s against "
    f"{shortest:.2f} s. A law that runs at the limits and rounds only the corners (`s_curve`) takes "
    f"{curve:.2f} s.",
)

# %% [markdown]
# ## Via points
#
# A rock is in the way. You add a configuration beside it, a *via point*. You may stop there, or pass through. To pass
# through, take one cubic for each part. Where two parts meet, they have the same position, velocity and acceleration.
# With both ends at rest there are as many equations as coefficients. This is the **cubic spline** (Lynch & Park,
# section 9.3). As a function of time it needs the time of each configuration. `plan_joint` uses the spline as a path. A
# time law then follows this path as fast as the limits allow.

# %%
via = 0.35 * start + 0.45 * goal + 0.2 * arm.random_theta(12)  # half way, and to one side
through = plan_joint(arm, [start, via, goal], limits=limits)
stopping = plan_joint(arm, [start, via, goal], limits=limits, stop_at_waypoints=True)

at = np.linspace(0, through.duration, 200)

# %%
first, second = via - start, goal - via
going_on = np.where(first * second > 0, np.minimum(np.abs(first), np.abs(second)), 0) / velocity
k = int(np.argmax(going_on))  # a joint that goes on in the same direction after the via point
unit, factor = units[k]
fig, (left, right) = guide.axes2(2, width=6.6, height=2.7, xlabel="t [s]")
for way, words, style, colour in (
    (through, "through", "-", guide.BLUE),
    (stopping, "stopping", "--", guide.ORANGE),
):
    t = np.linspace(0, way.duration, 300)
    left.plot(t, factor * way(t)[:, k], linestyle=style, color=colour, label=words)
    right.plot(t, factor * way(t, 1)[:, k], linestyle=style, color=colour)
    left.plot(
        way.times, factor * way.waypoints[:, k], "o", color=colour, markersize=5, linestyle="none"
    )
for sign in (1, -1):
    right.axhline(sign * factor * velocity[k], color=guide.GREY, linewidth=1, linestyle=":")
left.set_ylabel(f"{arm.joint_names[k]} [{unit.strip()}]")
right.set_ylabel(f"velocity [{unit.strip()}/s]")
left.legend(fontsize=8)
guide.figure(
    fig,
    f"The joint {arm.joint_names[k]} over time, through a via point and stopping there, and its velocity, with its "
    f"limits",
    "The same three configurations, with and without a stop. Dots: the configurations. Dotted: the velocity limit.",
)
low, high = through.waypoints.min(axis=0), through.waypoints.max(axis=0)
inner = through(at)
beyond = np.maximum(inner - high, low - inner).max(axis=0)
worst = int(np.argmax(beyond * np.array([f for _, f in units])))
guide.predict(
    "Is it faster to pass through than to stop? And does the spline stay between your configurations?",
    f"Here it takes {through.duration:.2f} s, and with a stop {stopping.duration:.2f} s. If a path turns back "
    f"on itself, a stop may be faster, and `plan_joint` then stops. A spline may swing beyond its configurations: "
    + (
        f"here `{arm.joint_names[worst]}` swings {beyond[worst] * units[worst][1]:.2f}{units[worst][0]} beyond the "
        f"range of the three."
        if beyond[worst] > 1e-6
        else "here it stays between them, by chance."
    )
    + " twistarm keeps the swing inside the joint limits. Check yourself that it misses the rock.",
)

# %% [markdown]
# ## Straight in what?
#
# A path that is straight in joint space is not straight in Cartesian space. For a push, a plug or a drawer the *tool*
# should go straight. There are two ways. Let $g_0$ and $g_1$ be the poses at both ends.
#
# - **Line**: the tool's origin goes straight, and the tool turns about one fixed axis, both in proportion. Position and
#   rotation are separate. If you take another point of the tool as its origin, you get another motion.
# - **Screw**: by Chasles' theorem one screw motion leads from $g_0$ to $g_1$. Go along it:
#
# $$g(s) = e^{\hat\xi s}\, g_0, \qquad \hat\xi = \log(g_1 g_0^{-1})$$
#
# This motion does not depend on the choice of the tool's origin. Source: Murray, Li and Sastry, *A Mathematical
# Introduction to Robotic Manipulation* (MLS), section 2.3.3.

# %%
g0, g1 = arm.fk(start), arm.fk(goal)
share = np.linspace(0, 1, 101)

by_joints = arm.fk(start + share[:, None] * (goal - start))

xi = screws.log(g1 @ screws.inverse(g0))
by_screw = screws.exp(xi, share) @ g0

turn = rotations.log(g0[:3, :3].T @ g1[:3, :3])
by_line = np.tile(np.eye(4), (len(share), 1, 1))
by_line[:, :3, :3] = g0[:3, :3] @ rotations.exp(share[:, None] * turn)
by_line[:, :3, 3] = g0[:3, 3] + share[:, None] * (g1 - g0)[:3, 3]


# %%
def length_of(points):
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def off_the_chord(points):
    chord = points[-1] - points[0]
    if (span := np.linalg.norm(chord)) < 1e-9:
        return float(np.linalg.norm(points - points[0], axis=1).max())
    across = np.cross(points - points[0], chord / span)
    return float(np.linalg.norm(across, axis=1).max())


ways = {"joints": by_joints, "line": by_line, "screw": by_screw}
ahead = np.array([0.0, 0.0, 0.1, 1.0])  # a point ten centimetres in front of the tool
rows = [
    [
        name,
        f"{length_of(way[:, :3, 3]):.3f} m",
        f"{1000 * off_the_chord(way[:, :3, 3]):.1f} mm",
        f"{1000 * off_the_chord((way @ ahead)[:, :3]):.1f} mm",
    ]
    for name, way in ways.items()
]
guide.table(
    [
        "straight in",
        "way of the tool's origin",
        "it leaves the straight line by",
        "a point 10 cm ahead leaves its own line by",
    ],
    rows,
    "Three ways between the same two poses.",
)
fig, ax = guide.axes3(width=5.2, height=4.4)
guide.plot_arm(ax, arm, start, colour=guide.GREY, alpha=0.45, tool=False)
guide.plot_arm(ax, arm, goal, colour=guide.GREY, alpha=0.45, tool=False)
for (name, way), colour, style in zip(
    ways.items(), (guide.BLUE, guide.INK, guide.ORANGE), ("-", ":", "--"), strict=True
):
    ax.plot(*way[:, :3, 3].T, color=colour, linestyle=style, linewidth=2.2, label=name)
    guide.plot_motion(guide.plot_point, ax, way[::2, :3, 3], "", colour)
size = 0.12 * arm.reach
guide.plot_frame(ax, g0, None, size)
guide.plot_motion(guide.plot_frame, ax, by_screw[::4], None, size)
ax.legend(loc="upper left")
guide.figure(
    fig,
    f"{arm.name} at both ends of a move, and three ways of its tool between them: straight in the joints, on a line, "
    "along a screw",
    "Three ways between the same two poses. The task decides which one is right.",
)

# %%
guide.predict(
    "On the *line*, does a point ten centimetres ahead of the tool's origin go straight as well?",
    (
        f"No: it leaves its straight line by {1000 * off_the_chord((by_line @ ahead)[:, :3]):.1f} mm, because the tool "
        "turns on the way. A line is a statement about *one* point, so put the tool frame where the work is. "
        "On the screw no point is special: each moves on a helix about the same axis, with the same pitch."
        if np.linalg.norm(turn) > 1e-6
        else "Here it does, because the tool does not turn between the two poses. If it turns, only the origin goes straight."
        " On the screw no point is special."
    ),
)

# %% [markdown]
# Take the line for a push or a cut. Take the screw if the task has an axis: a cap, a door, a latch. Take the path that
# is straight in the joints for everything else. It always stays inside the joint limits, and no singularity stops it.
#
# ## Let the planner do it
#
# The arm cannot follow every line: joints have limits, and there are singularities. `plan` solves inverse kinematics
# along the way. It keeps to one answer, so the elbow never flips on the way. Then it finds the time law within all
# limits.


# %%
def push(arm, share):
    """A straight motion by this share of the reach along the first feasible of six base axes, or None."""
    v = np.where(np.isfinite(arm.limits.velocity), arm.limits.velocity, 1.0)
    a = np.where(np.isfinite(arm.limits.acceleration), arm.limits.acceleration, 2.0 * v)
    for direction in np.vstack([np.eye(3), -np.eye(3)]):
        line = LineMove.by(share * arm.reach * direction, frame="base", constrain="position")
        try:
            limits = {"velocity": v, "acceleration": a}
            return direction, plan(arm, line, limits=limits, linear_speed=0.2)
        except TwistarmError:
            continue  # not that way
    return None


pusher = guide.arm_with(
    "a straight line that it can follow", lambda candidate: push(candidate, 0.25) is not None
)
direction, straight = push(pusher, 0.25)
length = 0.25 * pusher.reach
t = np.linspace(0, straight.duration, 500)
tool = pusher.fk(straight(t))[:, :3, 3]
far = LineMove.by(12 * length * direction, frame="base", constrain="position")
try:
    plan(pusher, far, limits={"velocity": 1.0, "acceleration": 2.0})
    refused = ""  # slides without limits go anywhere
except PathError as error:
    refused = str(error)

# %%
axis = ("+" if direction.sum() > 0 else "−") + "xyz"[int(np.argmax(np.abs(direction)))]
guide.say(
    f"{length:.3f} m along ${axis}$ of the base take {straight.duration:.2f} s. Forward kinematics at {len(t)} "
    f"instants: the tool leaves the line by at most {1e6 * off_the_chord(tool):.1f} µm. "
    + (f"Ask for twelve times as far, and `plan` answers:\n\n> {refused}" if refused else "")
)
guide.scene(
    pusher,
    pusher.ready,
    straight,
    caption="The push. Play it, and watch which joint comes nearest to its velocity limit.",
    quantity="joints",
)
share_of_limit = straight.peak(1) / np.where(
    np.isfinite(pusher.limits.velocity), pusher.limits.velocity, 1.0
)
busiest = int(np.argmax(share_of_limit))
per_metre = straight(t, 1)[:, busiest] / np.linalg.norm(np.gradient(tool, t, axis=0), axis=1)
per_metre = np.abs(per_metre[50:-50])  # without both ends, where the tool hardly moves
unit = pusher.units[busiest]
guide.predict(
    "Which joint comes nearest to its velocity limit? And does it move equally far for each metre of the line?",
    f"`{pusher.joint_names[busiest]}`: it reaches {100 * share_of_limit[busiest]:.0f} % of its velocity limit. "
    + (
        f"It moves equally far for each metre of the line, {per_metre.mean():.2f} {unit}."
        if np.ptp(per_metre) < 0.01 * per_metre.max()
        else f"A metre of the line takes {per_metre.min():.2f} to {per_metre.max():.2f} {unit} of this joint, depending on the configuration. At a constant speed of the tool, the joint's speed changes."
    ),
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **Straight in the wrong space.** Two recorded configurations are close to the table, and between them the tool goes
#   through it. Add via points, or use a line.
# - **A full turn.** From 350° to 10° is 20°, but a program that subtracts turns back by 340°. Wrap the difference if
#   the joint has no limits. Never wrap it if the joint has a cable.
# - **Too few setpoints.** Between two setpoints a simple drive interpolates linearly. With the acceleration $a$, it is
#   off in the middle by up to $a\,\Delta t^2/8$, which is half of $a\,(\Delta t/2)^2$.
# - **Only samples are checked.** The velocity at every hundredth of a second was inside the limit, but the peak was
#   between two samples.
# - **The limit of the joint is not that of the motor.** In a differential, two motors move two joints together, and one
#   joint may need both. Describe this in the section `[actuators]` of `arm.toml`.

# %%
rows = []
for dt in (0.01, 0.05, 0.2):
    grid = np.append(np.arange(0, motion.duration, dt), motion.duration)
    fine = np.linspace(0, motion.duration, 4001)
    chords = np.stack([np.interp(fine, grid, column) for column in motion(grid).T], axis=-1)
    far = np.linalg.norm((arm.fk(chords) - arm.fk(motion(fine)))[:, :3, 3], axis=1).max()
    rows.append([f"{1000 * dt:.0f} ms", f"{1000 * far:.3f} mm"])
guide.table(
    ["a setpoint every", "the tool is off by up to"],
    rows,
    f"The first move of this lesson on `{arm.name}`.",
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("3_3_1_trajectories")
