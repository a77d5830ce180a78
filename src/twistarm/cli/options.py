"""Options that commands share: the arm and how it is loaded, its scene, and how the command answers."""

from __future__ import annotations

import shlex
import sys
from copy import copy
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from ..arm.arm import Arm
from ..arm.loading.load import load_arm, read, specify
from ..description.catalog import model_arms, own_arms
from ..description.planar import free_name
from ..limits.joint_limits import slides
from ..support.checks import Array, pose_of
from ..support.errors import InputError
from .command import Command, Group, Shared, params_of
from .numbers import (
    ANGLE,
    LENGTH,
    SUCH_AS,
    XYZ,
    JointValues,
    argument,
    joint_values,
    numbers,
    option,
    switch,
    typed_number,
)
from .output import Kinds, Outputs, progress_bar, say
from .wording import OPTIONS, words

if TYPE_CHECKING:
    from ..collision import Scene

Theta = Annotated[
    JointValues | None,
    joint_values(
        "Joint values base to tip (0.1 30 -45; degrees, metres for slides), joint=value for some of them, the others "
        "as in ready, or a configuration's name (ready, zero)."
    ),
]
SceneFile = Annotated[Path | None, option("FILE", "Obstacles: a scene.toml, or MoveIt's scene.", "--scene", "--avoid")]
Offset = Annotated[Any, numbers("m m m", XYZ, "Where the payload's mass is, in tool axes [m].")]
SELF = "self"
Avoid = Annotated[
    str | None,
    option(
        "SCENE",
        f"Collide with nothing: a scene.toml or MoveIt's scene, or {SELF} for the robot alone.",
        "--avoid",
        "--scene",
    ),
]


def avoided(arm: Arm, typed: str | Path | None) -> Scene | None:
    """The scene of `--avoid`, None if it was not typed."""
    if typed is None:
        return None
    from ..collision import Scene

    with progress_bar("allowed pairs") as progress:
        scene = Scene(arm, progress=progress) if typed == SELF else Scene.load(arm, typed, progress=progress)
        scene.find_allowed_pairs()  # now, with its bar: the first question would do it in silence
    for found in scene.findings:  # what is not checked as the user expects
        if found.severity == "warning":
            say(words(found.text), file=sys.stderr)
    return scene


def _answer(
    output: Annotated[
        list[str] | None, option("FILE", "Where to write it; - is standard output.", "--output", "-o")
    ] = None,
    form: Annotated[
        str | None, option("KIND", "The kind of what -o - writes, or a name without ending.", "--format")
    ] = None,
    force: Annotated[bool, switch("Replace files that are there.", "--force")] = False,
    rad: Annotated[bool, switch("Angles are typed and shown in radians, not degrees.", "--rad")] = False,
    json: Annotated[bool, switch("Print the answer as JSON, in SI units.", "--json")] = False,
) -> None:
    """The options of `answers`."""


ALL_OF_ANSWERS = params_of(_answer)


def answers(names: str, kinds: Kinds | None = None, over_description: bool = False, **helps: str) -> Shared:
    """One argument `Outputs` from the options output, form, force, rad and json that a command has.

    `kinds` are those of its files, and `helps` other texts in its help. The files are checked before it begins.
    """
    params = [copy(param) for param in ALL_OF_ANSWERS if param.name in names.split()]
    for param in params:
        param.help = helps.get(param.name, param.help)

    def made(
        output: list[str] | None = None, form: str | None = "", force: bool = False, rad: bool = False,
        json: bool = False,
    ) -> Outputs:  # fmt: skip
        return Outputs((), json, rad, kinds or {}, form, force, over_description).named(*(output or ()))

    return Shared(made, params)


CSV = {"csv": (".csv",)}
Json = Annotated[Outputs, answers("json")]
Answer = Annotated[Outputs, answers("rad json")]
CsvAnswer = Annotated[Outputs, answers("output force rad json", CSV)]


@dataclass
class Source:
    """A typed ARM. `ArmCommand` fills in the typed options for loading it."""

    name: str
    keywords: dict[str, Any] = field(default_factory=dict)
    tool: Array | None = None

    def load(self) -> Arm:
        """The arm, with the typed tool beyond its tip."""
        arm = load_arm(self.name, **self.keywords)
        if self.tool is None:
            return arm
        return arm.with_tool(pose_of(np.eye(3), self.tool), free_name("tool", {*arm.frame_names}))

    def without_tool(self, where: str) -> dict[str, Any]:
        """The keywords of `load_arm`. InputError for a typed tool, which goes to `where`."""
        if self.tool is not None:
            raise InputError(f"--tool is no part of this: write [tool] into {where}")
        return self.keywords


def arms_like(typed: str) -> list[str]:
    """Completions of ARM: names of the catalogue and descriptions here. None lets the shell complete."""
    endings = (".urdf", ".xacro", ".xml", ".toml", ".json", ".csv")
    names = [name for name in (*own_arms(), *model_arms()) if name.startswith(typed)]
    here = [path.name for path in Path().glob("*")]
    files = [name for name in here if name.startswith(typed) and name.endswith(endings) and name.isprintable()]
    return names + files if names else []


ARM = argument(
    "ARM",
    "URDF, xacro, MJCF, arm.toml, arm.json, DH table (CSV), or catalogue name.",
    parser=Source,
    autocompletion=arms_like,
)
ArmArgument = Annotated[Source, ARM]
ArmOption = Annotated[
    Source | None,
    option("ARM", "Your arm; the bundled rover arm without it.", "--arm", parser=Source, autocompletion=arms_like),
]


def _loading(name: str, help_text: str) -> Any:
    typed, metavar = OPTIONS[name]
    return option(metavar, help_text, typed)


def _keywords(
    base: Annotated[str | None, _loading("base", "Base link, instead of the root.")] = None,
    tip: Annotated[str | None, _loading("tip", "Tip link, instead of the one found by its name.")] = None,
    tool: Annotated[Any, numbers("m m m", XYZ, "Where the tool is, seen from the tip [m].", "--tool")] = None,
    package_dirs: Annotated[
        list[Path] | None, _loading("package_dirs", "A folder that holds packages; may be repeated.")
    ] = None,
    xacro_args: Annotated[list[str] | None, _loading("xacro_args", "A xacro argument; may be repeated.")] = None,
    ignore_packages: Annotated[
        list[str] | None, _loading("ignore_packages", "Leave out the parts of a missing package; may be repeated.")
    ] = None,
    env_vars: Annotated[
        list[str] | None, _loading("env_vars", "An environment variable that xacro may read; may be repeated.")
    ] = None,
    srdf: Annotated[
        Path | None, _loading("srdf", "SRDF with groups and configurations, instead of the one beside the file.")
    ] = None,
    limits: Annotated[
        Path | None, _loading("limits", "joint_limits.yaml of MoveIt or ros2_control; wins over the URDF.")
    ] = None,
    locked_joints: Annotated[
        list[str] | None,
        _loading("locked_joints", "A joint to hold, in degrees, or metres for a slide; may be repeated."),
    ] = None,
) -> dict[str, Any]:
    """What was typed, as keywords of `load_arm`, but the tool."""
    arguments: dict[str, str] = {}
    for pair in xacro_args or ():
        name, separator, value = pair.partition(":=")
        if not separator:
            name, equals, value = pair.partition("=")
            meant = f"; did you mean --xacro {shlex.quote(f'{name}:={value}')}?" if equals else ""
            raise InputError(f"--xacro takes NAME:=VALUE; got {pair!r}{meant}")
        arguments[name] = value
    always: dict[str, Any] = {"base": base, "tip": tip, "srdf": srdf, "xacro_args": arguments}
    always |= {"package_dirs": package_dirs or (), "ignore_packages": ignore_packages or (), "env_vars": env_vars or ()}
    return always | {name: value for name, value in {"limits": limits, "locked_joints": locked_joints}.items() if value}


def _locked(source: Source, pairs: list[str], radians: bool) -> dict[str, float]:
    """Typed JOINT=VALUE pairs in rad and m. Only the description knows which of the two, so that it is read."""
    # Limits are for joints that locking may remove, so they are left out here.
    wishes = {name: value for name, value in source.keywords.items() if name != "limits"}
    joints = read(specify(source.name, **wishes)).joints
    locked_joints: dict[str, float] = {}
    for pair in pairs:
        name, _, text = pair.rpartition("=")
        joint = joints.get(name.strip())
        unit = LENGTH if joint is not None and slides(joint.type) else ANGLE
        value = typed_number(text, unit, radians=radians)
        if not name.strip() or not np.isfinite(value):
            raise InputError(f"--locked-joint takes JOINT=VALUE with a value such as {SUCH_AS[unit]}; got {pair!r}")
        locked_joints[name.strip()] = value
    return locked_joints


LOADING = params_of(_keywords)
for parameter in LOADING:
    parameter.rich_help_panel = "Loading the arm"


class _Loading:
    """A command with the options for loading, last in its help. They are for every ARM that is typed."""

    params: list[Any]

    def __init__(self, *args: Any, **keywords: Any) -> None:
        super().__init__(*args, **keywords)
        self.params.extend(LOADING)

    def invoke(self, ctx: Any) -> Any:
        """Hand the typed options to each `Source`."""
        typed = {option.name: ctx.params.pop(option.name) for option in LOADING}
        sources = [
            entry
            for value in ctx.params.values()
            for entry in (value if isinstance(value, (list, tuple)) else [value])
            if isinstance(entry, Source)
        ]
        if any(typed.values()) and not sources:
            raise InputError("give an ARM: the options for loading need one")
        tool = typed["tool"]
        for source in sources:
            source.tool = None if tool is None else tool.read(tool.text, "--tool", bool(ctx.params.get("rad")))
            source.keywords = _keywords(**typed)
            if pairs := source.keywords.pop("locked_joints", None):
                source.keywords["locked_joints"] = _locked(source, pairs, bool(ctx.params.get("rad")))
        return super().invoke(ctx)  # type: ignore[misc]


class ArmCommand(_Loading, Command):
    """A command with one or more ARM."""


class ArmGroup(_Loading, Group):
    """A command with an ARM and further commands."""
