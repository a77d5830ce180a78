"""`arms`, `info` and `init`: the arms of the catalogue, the loaded arm, the installation, and a first arm.toml."""

from __future__ import annotations

import os
import platform
import re
import shlex
from contextlib import suppress
from importlib import metadata
from pathlib import Path
from typing import Annotated

import numpy as np

from ...arm import engine
from ...arm.arm import Arm
from ...arm.arm_data import ALIGNED
from ...arm.loading.arm_file_draft import draft_arm_file
from ...arm.loading.load import load_arm
from ...description import catalog
from ...description.companions.arm_file import MOTOR_LIMITS
from ...ik import closed_form_of
from ...limits.actuators import Actuators
from ...planning.motion_file import draft_motion_file
from ...support.directions import direction_in_words, length_in_words
from ...support.errors import InputError, without_places
from ...support.messages import Argument, plural
from ..numbers import argument, switch
from ..options import ARM, Answer, Json, Source, answers
from ..output import STDOUT, Outputs, entries, say
from ..tables import Column, Table, number
from ..wording import written


def arms(out: Json) -> None:
    """List the arms that can be loaded by name."""
    own, models = catalog.own_arms(), catalog.model_arms()
    installed = catalog.models_share() is not None
    missing = "" if installed else "   (not installed: pip install 'twistarm[models]')"
    out.show(
        {"own": own, "models": models, "models_installed": installed},
        f"twistarm's own:      {', '.join(own)}",
        f"example-robot-data:  {', '.join(models)}{missing}",
    )


def info(out: Answer, source: Annotated[Source | None, ARM] = None) -> None:
    """Show the loaded arm: joints, limits, base, tip, configurations, findings, proof; without ARM the installation."""
    if source is None:
        show_installation(out)
    else:
        show_arm(out, source.load())


def show_arm(out: Outputs, arm: Arm) -> None:
    """Everything about the arm."""
    why_not, report = arm.why_not_compiled, closed_form_of(arm)
    data = {
        **entries(arm, "name base tip tool_axis n joint_names reach screws home ready"),
        "source": without_places(arm.source, Path(arm.source)),
        "named_states": dict(arm.named_states),
        "disabled_collisions": arm.disabled_collisions,
        "actuators": arm.actuators
        and entries(arm.actuators, "names joint_names G offset units ticks_per_turn limits joint_limits undriven"),
        "frames": arm.frame_names,
        "proof": arm.proof,
        "engine": engine_of(arm),
        "core": engine.instruction_set() or None,
        "all_configurations": report,
        "findings": arm.findings,
    }
    head = f"{arm.name}: {plural(arm.n, 'degree')} of freedom from {arm.base} to {arm.tip} ({arm.source})"
    axis = direction_in_words(arm.tool_axis, "tool").replace("its", "the tool's")
    turning = [pair for pair in zip(arm.moving_names, arm.body_screws.T, strict=True) if pair[1][3:].any()]
    for name, xi in turning[-1:]:
        if np.linalg.norm(np.cross(xi[3:], arm.tool_axis)) < ALIGNED:
            beside = float(np.linalg.norm(np.cross(xi[3:], xi[:3])))
            line = "it" if beside < ALIGNED * arm.reach else f"a line {length_in_words(beside)} beside it"
            axis += f" ({name} turns the tool about {line})"
    proof = arm.proof and (
        f"proof at load: screws and Pinocchio agree within {arm.proof.pose_error:.1e} (pose) and "
        f"{arm.proof.jacobian_error:.1e} (Jacobian) at {arm.proof.samples} random configurations"
    )
    parts = [
        head, f"links of {arm.reach:.3f} m in all; --direction points {axis}, unless --axis names another", "",
        joints_table(arm), "", _configurations(arm), "", proof,
        f"engine: {engine_of(arm)}" + (f"; no compiled core: {why_not}" if why_not else ""),
        f"all configurations for the target {report.target} (ik --all): {report}",
        *([] if arm.actuators is None else _motors(arm, arm.actuators)),
        *(finding.text for finding in arm.findings),
    ]  # fmt: skip
    out.show(data, *(part for part in parts if part is not None))


def engine_of(arm: Arm) -> str:
    """The engine of this arm's kinematics."""
    return "NumPy" if arm.compiled is None else f"compiled core ({arm.compiled.instruction_set})"


def joints_table(arm: Arm) -> Table:
    """The joints with their limits."""
    limits = arm.limits
    jerk = bool(np.isfinite(limits.jerk).any())  # URDF before 1.2 has none, and most arms give none
    columns = [
        Column("joint", arm.joint_names, key="name"),
        Column("type", arm.joint_types),
        Column("lower", limits.lower, arm.units),
        Column("upper", limits.upper, arm.units),
        Column("velocity", limits.velocity, arm.units, "/s"),
        Column("acceleration", limits.acceleration, arm.units, "/s²"),
        Column("jerk", limits.jerk, arm.units, "/s³", people=jerk),
        Column("effort", limits.effort),
    ]
    return Table("joints, base to tip (− = not given)", columns, "joints")


def _configurations(arm: Arm) -> Table:
    """A column for each configuration, its name as it can be typed, and its condition number below."""
    configurations = {"ready": arm.ready, **arm.named_states}
    columns = [Column("joint", (*arm.joint_names, "condition"))]
    for name, theta in configurations.items():
        condition = float(arm.manipulability(theta).condition)
        below = "singular" if np.isinf(condition) else number(condition, 1)
        columns.append(Column(name, (*theta, below), (*arm.units, "")))
    ready = "; ready is computed" if arm.ready_name is None else ""
    return Table(f"configurations (typed by name: --theta ready{ready})", columns)


def _motors(arm: Arm, motors: Actuators) -> list[Table | str]:
    """The motors with their limits, and the joint limits that follow from them."""
    columns = [
        Column("motor", motors.names),
        *(Column(name, row, digits=6) for name, row in zip(motors.joint_names, motors.G.T, strict=True)),
        Column("offset", motors.offset, digits=6),
        Column("counts in", motors.units),
        Column("ticks per turn", motors.ticks_per_turn),
    ]
    parts: list[Table | str] = ["", Table("motors = G theta + o (SI; rows of G)", columns)]
    given = [name for name in MOTOR_LIMITS if np.isfinite(getattr(motors.limits, name)).any()]
    if given:
        own = [Column(name, getattr(motors.limits, name)) for name in given]
        parts += ["", Table("limits of the motors, on their side (SI)", [Column("motor", motors.names), *own])]
        alone = motors.joint_limits
        theirs = [Column(name, getattr(alone, name), "" if name == "effort" else arm.units) for name in given]
        title = "what they allow each joint, moving alone"
        parts += ["", Table(title, [Column("joint", motors.joint_names), *theirs])]
    return [*parts, ""]


def version() -> str:
    """twistarm's own."""
    return metadata.version("twistarm")


def show_installation(out: Outputs) -> None:
    """The versions of twistarm and of what it needs. In JSON null means that a library is not installed."""
    extras: dict[str, str] = {}  # of each library; "" for the base install
    for text in metadata.requires("twistarm") or ():
        found = re.match(r"([\w.-]+)[^;]*(?:;.*extra == ['\"](\w+)['\"])?", text)
        if found and found[1] != "twistarm" and found[2] not in ("dev", "all") and "python_version" not in text:
            extras.setdefault(found[1], found[2] or "")
    libraries: dict[str, str | None] = dict.fromkeys(extras)
    for name in libraries:
        with suppress(metadata.PackageNotFoundError):
            libraries[name] = metadata.version(name)
    data = {
        "twistarm": version(),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "engine": f"compiled core ({engine.instruction_set()})" if engine.core() else "NumPy",
        "core": engine.instruction_set() or None,
        "why_no_core": engine.why_not() or None,
        "libraries": libraries,
    }
    lines = [f"twistarm {data['twistarm']}, Python {data['python']}, {data['platform']}", f"engine: {data['engine']}"]
    if data["why_no_core"]:
        lines.append(f"no compiled core: {data['why_no_core']}")
    for name, extra in extras.items():
        missing = f"not installed: pip install 'twistarm[{extra}]'" if extra else "not installed"
        lines.append(f"  {name:<20} {libraries[name] or missing}")
    out.show(data, *lines, "about an arm: twistarm info ARM; names of arms: twistarm arms")


Motion = Annotated[
    bool, switch("Write a first motion.toml for the arm, as `twistarm plan ARM motion.toml` takes it.", "--motion")
]
File = Annotated[Source, argument("FILE", "URDF or xacro file; with --motion any ARM.", parser=Source)]
Written = Annotated[
    Outputs,
    answers(
        "output force",
        {"toml": (".toml",)},
        over_description=True,
        output="Where to write it; arm.toml, or motion.toml. - is standard output.",
    ),
]


def init(source: File, outputs: Written, motion: Motion = False) -> None:
    """Write a commented arm.toml for FILE (base, tip, limits to fill in, ready), or a first motion.toml."""
    outputs = outputs if outputs.files else outputs.named("motion.toml" if motion else "arm.toml")
    output = outputs.files[0][1]
    if output != STDOUT and not output.endswith(".toml"):
        raise InputError(f"{'a motion' if motion else 'an arm'} file is named *.toml; got {output}")
    if motion:
        arm = source.load()
        outputs.write({"toml": lambda: draft_motion_file(arm)})
        if output != STDOUT:
            options = [written(Argument(name, value)) for name, value in source.keywords.items() if value]
            options += [] if source.tool is None else [f"--tool {' '.join(map(repr, source.tool.tolist()))}"]
            plan = " ".join(["twistarm plan", shlex.quote(source.name), shlex.quote(output), *options])
            say(f"{output}: a motion with every kind of segment; next: {plan}")
        return
    for name, flag in (("limits", "--limits"), ("locked_joints", "--locked-joint")):
        if name in source.keywords:
            raise InputError(f"{flag} is not copied: write it into the arm.toml")
    draft = draft_arm_file(source.name, Path(os.path.realpath(output)).parent, source.tool, **source.keywords)
    outputs.write({"toml": lambda: draft})
    if output != STDOUT:
        arm = load_arm(output, env_vars=source.keywords["env_vars"])
        say(f"{output}: {arm.n} joints from {arm.base} to {arm.tip}; next: twistarm info {output}")
