# %% [markdown]
# # From a file to a motion: your own arm
#
# The mechanics are done, and a teammate has exported a URDF from the CAD program. In two weeks the arm must take a tool
# from a rack. From the file to the moving arm, a dozen things can go wrong, and each costs an evening. So you go in
# seven steps. Each step checks one thing.
#
# By default the lesson shows the bundled rover arm. `twistarm guide --arm my_arm.urdf.xacro` builds it for your own.
# Each step names the command that does the same without a program.

# %%
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from twistarm import (
    Approach,
    Dwell,
    JointMove,
    LineMove,
    Pose,
    Position,
    TwistarmError,
    crosscheck,
    diagnose,
    guide,
    plan,
    save_trajectory,
    solve_ik,
)

arm = guide.arm()

# %% [markdown]
# ## 1. What does the file say?
#
# `twistarm info my_arm.urdf.xacro`
#
# Read the table aloud beside the arm, with a teammate who built it. Look for a joint that turns where it should slide,
# a limit of 3.14 on a joint that can do 40°, or a base in the wrong place.


# %%
def shown(x, unit, digits=1):
    if not np.isfinite(x):
        return "none"
    value = np.degrees(x) if unit == "rad" else x
    mark = "°" if unit == "rad" else " m"
    return f"{round(float(value), digits) + 0.0:.{digits if unit == 'rad' else digits + 2}f}{mark}".replace(
        "-", "−"
    )


guide.table(
    ["joint", "type", "lowest", "highest", "speed", "waiting"],
    [
        [
            f"`{name}`",
            kind,
            shown(low, u),
            shown(high, u),
            speed if speed == "none" else f"{speed}/s",
            shown(x, u),
        ]
        for name, kind, u, low, high, speed, x in zip(
            arm.joint_names,
            arm.joint_types,
            arm.units,
            arm.limits.lower,
            arm.limits.upper,
            [shown(v, u) for v, u in zip(arm.limits.velocity, arm.units, strict=True)],
            arm.ready,
            strict=True,
        )
    ],
    f"`{arm.name}`, from `{arm.base}` to `{arm.tip}`.",
)

# %% [markdown]
# ## 2. Is the file healthy?
#
# `twistarm doctor my_arm.urdf.xacro`
#
# The doctor finds the usual mistakes of exported files. Examples are limits in degrees, a velocity limit of zero,
# meshes a thousand times too large, or no tool frame. Correct every error, and understand every warning. With `-o
# mended.urdf` it makes the safe repairs itself, in a copy.

# %%
findings = diagnose(arm)

# %%
if findings:
    guide.table(
        ["kind", "where", "what is there", "what to do"],
        [
            [
                finding.severity,
                f"{finding.place.element} `{finding.place.name}`"
                if finding.place.name
                else finding.place.element or "the arm",
                finding.what,
                finding.remedy,
            ]
            for finding in findings[:8]
        ],
        f"The doctor on `{arm.name}`: {len(findings)} finding{'s' if len(findings) > 1 else ''}"
        + (". These are the most serious." if len(findings) > 8 else "."),
    )
else:
    guide.say(f"`{arm.name}`: nothing found.")

# %% [markdown]
# ## 3. Do the engines agree?
#
# `twistarm check my_arm.urdf.xacro`
#
# One program may read your file wrongly. Three programs by different people hardly make the same mistake. twistarm
# compares its screws with Pinocchio and yourdfpy at random configurations. It also compares the Jacobians with
# difference quotients.

# %% tags=["shown"]
agreement = crosscheck(arm, samples=100)

# %%
compared = [row for row in agreement.comparisons if not row.not_compared]
worst = {row.quantity: row for row in sorted(compared, key=lambda row: row.worst / row.tolerance)}
guide.table(
    ["compared", "between", "worst difference", "allowed"],
    [
        [
            row.quantity.replace("J^s", "$J^s$")
            .replace("J^b", "$J^b$")
            .replace("Ad ", "$\\mathrm{Ad}$ "),
            " and ".join(row.engines),
            f"${guide.rough(row.worst)}$",
            f"${guide.rough(row.tolerance)}$",
        ]
        for row in worst.values()
    ],
    f"`{arm.name}` at random configurations, in metres and radians: the two engines that differ most, for "
    f"each quantity. "
    "*poe* is the product of exponentials, *core* the same in compiled code, *walk* goes link by link.",
)
guide.predict(
    "All agree. What do you know now about the arm on the table?",
    "About the arm on the table, nothing yet. You know that the programs agree on the *file*. No program can "
    "say whether the file describes your arm. For that you need a tape measure, in the next step.",
)

# %% [markdown]
# ## 4. Does the file describe the arm?
#
# Bring the arm into its ready configuration, by hand if necessary. Measure where the tool is. Then move one joint at a
# time by the amount in the table, always from the ready configuration. Look which way the tool goes. This shows a wrong
# sign, a swapped motor or a wrong zero, in five minutes and at low speed.

# %%
g = arm.fk(arm.ready)
steps = np.where(np.array(arm.units) == "m", 0.02, np.radians(10.0))
moved = arm.fk(arm.ready + np.diag(steps))[:, :3, 3] - g[:3, 3]

# %%
names = ("forward", "left", "up"), ("back", "right", "down")


def in_words(way):
    parts = [
        f"{1000 * abs(x):.0f} mm {names[0 if x > 0 else 1][k]}"
        for k, x in enumerate(way)
        if 1000 * abs(x) >= 0.5
    ]
    return ", ".join(parts) or "does not move (within half a millimetre)"


guide.say(
    f"In the ready configuration the tool of `{arm.name}` is {g[0, 3]:.3f} m along $x$, {g[1, 3]:.3f} m along "
    f"$y$ and {g[2, 3]:.3f} m "
    f"along $z$ from the origin of `{arm.base}`. Does your measurement agree?"
)
guide.table(
    ["joint", "moved by", "the tool goes"],
    [
        [f"`{name}`", shown(step, u, 0) if u == "rad" else "20 mm", in_words(way)]
        for name, step, u, way in zip(arm.joint_names, steps, arm.units, moved, strict=True)
    ],
    "Forward is $x$ of the base, left is $y$, up is $z$.",
)

# %% [markdown]
# When motors and encoders are connected, `twistarm wiring` finds swapped channels, signs, zeros and gear ratios from
# such a log. See *motors* in the documentation.
#
# ## 5. Can it get there?
#
# A camera reports the pose $g_{so}$ of the tool in the rack. A whole pose needs six joints. With five joints you leave
# the turn about the tool's axis free (`Approach`). With fewer you leave the whole orientation free (`Position`). On the
# rover arm the fifth joint only rolls the tool. Four joints remain for the five numbers of an approach, so it reaches
# an approach only at some places. Do not ask for more than the arm can do, or the solver must fail.


# %%
def freedoms_of(arm):
    return int(arm.manipulability(arm.random_theta(0, 200)).rank.max())


def target_of(arm, pose):
    """As much of a pose as the arm has freedoms for."""
    if freedoms_of(arm) == 6:
        return Pose(pose)
    if freedoms_of(arm) == 5:
        return Approach(pose[:3, 3], pose[:3, :3] @ arm.tool_axis)
    return Position(pose[:3, 3])


g_so = arm.fk(0.6 * arm.ready + 0.4 * arm.random_theta(7))  # in place of a camera
solution = solve_ik(arm, target_of(arm, g_so))
theta = solution.require()

reached = arm.fk(theta)

# %%
kind = type(target_of(arm, g_so)).__name__
words = {
    "Pose": "the whole pose",
    "Approach": "the place and the direction",
    "Position": "the place alone",
}[kind]
way_off = 1e6 * np.linalg.norm((reached - g_so)[:3, 3])
guide.table(
    ["joint", "from", "to"],
    [
        [f"`{name}`", shown(a, u), shown(b, u)]
        for name, u, a, b in zip(arm.joint_names, arm.units, arm.ready, theta, strict=True)
    ],
    f"`{arm.name}` can move its tool in {freedoms_of(arm)} directions, so the target is {words} (`{kind}`).",
)
x, y, z = reached[:3, 3]
guide.say(
    f"By forward kinematics the tool is then {way_off:.2f} µm from the target. As a command, for the position alone:"
    f" `twistarm ik my_arm.urdf.xacro --xyz {x:.3f} {y:.3f} {z:.3f}`."
)

# %%
far_away = g_so.copy()
far_away[:3, 3] *= 4 * arm.reach / np.linalg.norm(far_away[:3, 3])
beyond = solve_ik(arm, target_of(arm, far_away))
guide.predict(
    "By mistake the camera reports a place several times as far away as your arm is long. What should a solver answer?",
    "That it cannot reach the target, the reason, and the nearest configuration. twistarm says:"
    f"\n\n```text\n{beyond.explain()}\n```",
)

# %% [markdown]
# ## 6. How does it get there?
#
# The gripper must approach a tool from the right side. A **pre-grasp** is a pose some way back along this direction.
# From there, go straight in, close the gripper, and go straight out again. Only these two parts are lines. The rest is
# free, so move in joint space.


# %%
def limits_of(arm):
    """Of velocity and acceleration, supposed where the arm's files give none."""
    given = arm.limits
    velocity = np.where(np.isfinite(given.velocity), given.velocity, 1.0)
    return velocity, np.where(np.isfinite(given.acceleration), given.acceleration, 2.0 * velocity)


def fetch(arm, g_object, length):
    """The motion from waiting to an object and back; a TwistarmError where the arm cannot."""
    into = g_object[:3, :3] @ arm.tool_axis
    if freedoms_of(arm) < 5:  # the tool's direction cannot be chosen: go in from the base, level
        into = g_object[:3, 3] * [1, 1, 0]
    before = g_object.copy()
    before[:3, 3] -= length * into / np.linalg.norm(into)
    segments = [
        JointMove(target_of(arm, before)),
        LineMove(target_of(arm, g_object), linear_speed=0.1, label="close gripper"),
        Dwell(0.5),
        LineMove(target_of(arm, before), linear_speed=0.1),
        JointMove("ready"),
    ]
    velocity, acceleration = limits_of(arm)
    return plan(arm, segments, limits={"velocity": velocity, "acceleration": acceleration})


def first_served(arm):
    """In place of a camera: the first of forty places that the arm can serve, or None."""
    refusals = []
    for seed in range(40):
        g_object = arm.fk(0.6 * arm.ready + 0.4 * arm.random_theta(7 + seed))
        try:
            return g_object, fetch(arm, g_object, 0.08 * arm.reach), refusals
        except TwistarmError as error:
            refusals.append(str(error))
    return None


arm = guide.arm_with(
    "a place that it can reach in a straight line",
    lambda candidate: first_served(candidate) is not None,
)
g_so, motion, refusals = first_served(arm)

# %% [markdown]
# Check the plan by forward kinematics, which does not use the planner, at a thousand instants.

# %%
velocity, acceleration = limits_of(arm)
t = np.linspace(0, motion.duration, 1000)
tool = arm.fk(motion(t))[:, :3, 3]
closing = motion.labels[0][0]  # when the gripper closes
missed = np.linalg.norm(arm.fk(motion(closing))[:3, 3] - g_so[:3, 3])


# %%
begins = motion.times[1]
on_the_line = tool[(t >= begins) & (t <= closing)]
chord = g_so[:3, 3] - arm.fk(motion(begins))[:3, 3]
off = np.linalg.norm(
    np.cross(on_the_line - on_the_line[0], chord / np.linalg.norm(chord)), axis=1
).max()
guide.say(
    f"{motion.duration:.2f} s in all. When the gripper closes, at {closing:.2f} s, the tool is {1e6 * missed:.2f} µm "
    f"from its target. On the way in it leaves the straight line by at most {1e6 * off:.2f} µm. "
    + (
        f"Before this place, the planner refused {len(refusals)} other{'s' if len(refusals) > 1 else ''}. The "
        f"last error was:"
        f"\n\n> {refusals[-1]}"
        if refusals
        else "The planner accepted the first place."
    )
)
typed = " ".join(
    f"{np.round(x, 3) + 0.0:.3f}" if unit == "m" else f"{np.round(np.degrees(x), 1) + 0.0:.1f}"
    for x, unit in zip(motion(closing), arm.units, strict=True)
)
guide.say(
    f'As a command, without the straight line: `twistarm plan my_arm.urdf.xacro --to "{typed}" -o motion.csv`. Lines '
    "and grippers are written into a file, which `twistarm init --motion` begins for you."
)
fig, (left, right) = guide.axes2(2, width=6.6, height=2.9, xlabel="t [s]")
share = motion(t, 1) / velocity
dashes = ("-", "--", ":", "-.", (0, (8, 2)), (0, (1, 4)), (0, (6, 2, 1, 2, 1, 2)))
colours = (guide.BLUE, guide.ORANGE, guide.GREEN, guide.PINK, guide.AMBER, guide.SKY, guide.INK)
for k, name in enumerate(arm.joint_names):
    left.plot(t, share[:, k], label=name, linestyle=dashes[k % 7], color=colours[k % 7])
speed = np.linalg.norm(np.gradient(tool, t, axis=0), axis=1)
right.plot(t, speed, color=guide.BLUE, linestyle="-")
for ax in (left, right):
    ax.axvline(closing, color=guide.GREY, linewidth=1, linestyle=":")
left.set_ylabel("rate, share of its limit")
left.set_ylim(-1.1, 1.1)
right.set_ylabel("speed of the tool [m/s]")
fig.legend(fontsize=7, ncols=min(arm.n, 5), handlelength=3.5, loc="outside lower center")
guide.figure(
    fig,
    "Left, the rate of each joint as a share of its limit over time: none exceeds one. Right, the speed of the tool: "
    "fast on the free moves, slow and even on the two lines",
    "Fast on the free moves, slow on the lines. Dotted: the gripper closes.",
)

# %% [markdown]
# ## 7. See it, then send it
#
# `twistarm view my_arm.urdf.xacro --play motion.csv`
#
# Look at the motion from all sides before you send it. Does the elbow go through the rack? Does a cable wind up? The
# planner has kept every limit, but it does not know the table.

# %%
guide.scene(
    arm,
    arm.ready,
    motion,
    caption=f"Play it. The gripper closes at {closing:.2f} s: move the time slider there. Where is the tool?",
    quantity="joints",
)
guide.predict(
    "What do you see there, at the end of the line?",
    f"The tool stops for half a second at the end of the drawn path, {1e6 * missed:.2f} µm from the object. "
    f"It leaves on the same line."
    f"",
)

with TemporaryDirectory() as folder:
    file = save_trajectory(motion, Path(folder) / "motion.csv", dt=0.01)
    lines = file.read_text(encoding="utf-8").splitlines()

# %%
guide.say(
    f"The file for the robot has {len(lines) - 1} rows, one every hundredth of a second, with position, velocity and "
    f"acceleration of {arm.n} joint{'s' if arm.n > 1 else ''}. It begins with `{lines[0].split(',')[0]}, "
    f"{lines[0].split(',')[1]}`, …: every column has its unit. `twistarm follow` sends it to simulated joints "
    f"or to a robot. `twistarm bake` writes the whole arm as a C++ header for a microcontroller. `twistarm "
    f"freeze` writes a golden file, and `check --against` later shows whether an axis has changed."
)

# %% [markdown]
# ## What goes wrong in practice
#
# - **The file is corrected by hand and exported again.** The next export brings the mistake back. Keep corrections in
#   `arm.toml`, beside the file, and run `twistarm freeze`.
# - **The tool is the flange.** The tip link ends at the last motor, and the gripper is 15 cm longer. So every grasp is
#   15 cm off. Add a frame for the tool.
# - **A pose for five joints.** The solver fails at almost every pose. Use `Approach` or `Position`.
# - **The first run at full speed.** First send the motion with a tenth of the limits, with a hand on the emergency
#   stop.
# - **Zero has moved.** A belt skips a tooth, and the joint is off by a constant angle. Repeat step 4 each morning: it
#   takes five minutes.

# %%
slip = np.where(np.array(arm.units) == "m", 0.005, np.radians(5.0))
moves = np.linalg.norm(arm.fk(arm.ready + np.diag(slip))[:, :3, 3] - arm.fk(arm.ready)[:3, 3], axis=1)
move = JointMove(0.6 * arm.ready + 0.4 * arm.random_theta(7))
quick, slow = (
    plan(arm, move, limits={"velocity": share * velocity, "acceleration": share * acceleration})
    for share in (1.0, 0.1)
)
guide.table(
    ["a wrong zero", "the tool is off by"],
    [
        [f"`{name}`, by {'5 mm' if u == 'm' else '5°'}", f"{1000 * far:.0f} mm"]
        for name, u, far in zip(arm.joint_names, arm.units, moves, strict=True)
    ],
    f"`{arm.name}`, waiting.",
)
guide.say(
    f"One move takes {quick.duration:.2f} s with the full limits, and {slow.duration:.2f} s with a tenth of them."
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("4_capstone")
