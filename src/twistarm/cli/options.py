"""Options that commands share: which arm, and how it is loaded."""

from __future__ import annotations

import functools
import inspect
import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ..arm.arm import Arm
from ..arm.loading.load import load_arm
from ..description.catalog import model_arms, own_arms
from ..limits.joint_limits import slides
from ..support.errors import InputError
from .quantities import ANGLE, LENGTH, SUCH_AS, typed_number
from .typed import VALUES

ENDINGS = (".urdf", ".xacro", ".xml", ".toml", ".json", ".csv")
"""Of files that may be an ARM."""


def arms_like(typed: str) -> list[str]:
    """Completions of ARM: names of the catalogue and descriptions here; none lets the shell complete."""
    names = [name for name in (*own_arms(), *model_arms()) if name.startswith(typed)]
    files = [path.name for path in Path().glob("*") if _fits(path.name, typed)]
    return names + files if names else []


def _fits(name: str, typed: str) -> bool:
    return name.startswith(typed) and name.endswith(ENDINGS) and name.isprintable()


ARM = typer.Argument(
    metavar="ARM",
    help="URDF, xacro, MJCF, arm.toml, arm.json, DH table (CSV), or catalogue name.",
    autocompletion=arms_like,
)
Source = Annotated[str, ARM]
ArmOption = Annotated[
    str | None,
    typer.Option("--arm", metavar="ARM", help="Your arm; the bundled rover arm without it.", autocompletion=arms_like),
]
Base = Annotated[str | None, typer.Option(metavar="LINK", help="Base link, instead of the root.")]
Tip = Annotated[str | None, typer.Option(metavar="LINK", help="Tip link, instead of the one found by its name.")]
PackageDir = Annotated[
    list[Path] | None, typer.Option(metavar="DIR", help="A folder that holds packages; may be repeated.")
]
Xacro = Annotated[
    list[str] | None, typer.Option("--xacro", metavar="NAME:=VALUE", help="A xacro argument; may be repeated.")
]
Without = Annotated[
    list[str] | None,
    typer.Option(
        "--ignore-package", metavar="PACKAGE", help="Leave out what a missing package would bring; may be repeated."
    ),
]
Env = Annotated[
    list[str] | None,
    typer.Option(
        "--env", metavar="NAME", help="An environment variable that the xacro file may know; may be repeated."
    ),
]
Srdf = Annotated[
    Path | None, typer.Option(metavar="FILE", help="SRDF: groups, named states; else the one beside the description.")
]
Limits = Annotated[
    Path | None, typer.Option(metavar="FILE", help="joint_limits.yaml of MoveIt or ros2_control: wins over the URDF.")
]
Locked = Annotated[
    list[str] | None,
    typer.Option(
        "--locked-joint",
        metavar="JOINT=VALUE",
        help="A joint that stands still (degrees, metres for a slide); may be repeated.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print the answer as JSON, in SI units.")]
Radians = Annotated[bool, typer.Option("--rad", help="Angles are typed and shown in radians, not degrees.")]
CONFIGURATION = typer.Option(
    metavar=VALUES,
    help="Joint values base to tip (0.1 30 -45; degrees, metres for slides), joint=value for some of them, the others "
    "as in ready, or a pose's name (ready, zero).",
)
Theta = Annotated[str, CONFIGURATION]
SceneFile = Annotated[
    Path | None, typer.Option("--scene", "--avoid", metavar="FILE", help="Obstacles: a scene.toml, or MoveIt's scene.")
]


def replaced(
    command: Callable[..., Any],
    names: Sequence[str],
    options: Mapping[str, inspect.Parameter],
    make: Callable[[dict[str, Any], bool], tuple[Any, ...]],
) -> Callable[..., Any]:
    """`command` with `options` instead of the parameters `names`, which `make(typed, radians)` returns."""

    @functools.wraps(command)
    def run(**arguments: Any) -> Any:
        typed = {name: arguments.pop(name) for name in options}
        made = make(typed, bool(arguments.get("rad")))
        return command(**dict(zip(names, made, strict=True)), **arguments)

    parameters: list[inspect.Parameter] = []
    for own in inspect.signature(command, eval_str=True).parameters.values():
        parameters += options.values() if own.name == names[0] else [] if own.name in names else [own]
    parameters = [each.replace(kind=inspect.Parameter.KEYWORD_ONLY) for each in parameters]
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {each.name: each.annotation for each in parameters}
    return run


def takes_arm(command: Callable[..., Any]) -> Callable[..., Any]:
    """Replace a command's parameter `arm` by ARM and the options of `load_arm`."""
    return _takes(command, ("arm",))


def takes_arm_or_none(command: Callable[..., Any]) -> Callable[..., Any]:
    """The same where ARM may be left out: the command gets None then."""
    return _takes(command, ("arm",), Annotated[str | None, ARM])


def takes_source(command: Callable[..., Any]) -> Callable[..., Any]:
    """The same for a command that loads the arm by `source` and `load` (keywords of `load_arm`)."""
    return _takes(command, ("source", "load"))


def takes_arm_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """As `takes_source`, with `--arm ARM` instead of ARM; `source` is None without it."""
    return _takes(command, ("source", "load"), ArmOption)


def _takes(command: Callable[..., Any], names: Sequence[str], optional: Any = None) -> Callable[..., Any]:
    """A command with the options of `load_arm`. `optional`: the annotation of an ARM that may be left out."""
    options = {n: p for n, p in inspect.signature(load_keywords, eval_str=True).parameters.items() if n != "radians"}
    if optional:
        options["source"] = options["source"].replace(annotation=optional, default=None)

    def make(typed: dict[str, Any], radians: bool) -> tuple[Any, ...]:
        if typed["source"] is None and any(typed.values()):
            raise InputError("give an ARM: the other options are about one")
        source, load = load_keywords(**typed, radians=radians)
        return (source, load) if names[0] == "source" else (source and load_arm(source, **load),)

    return replaced(command, names, options, make)


def load_keywords(
    source: Source,
    base: Base = None,
    tip: Tip = None,
    package_dir: PackageDir = None,
    xacro: Xacro = None,
    ignore_packages: Without = None,
    env_vars: Env = None,
    srdf: Srdf = None,
    limits: Limits = None,
    locked_joints: Locked = None,
    *,
    radians: bool = False,
) -> tuple[str, dict[str, Any]]:
    """What was typed, as the source and the keywords of `load_arm`."""
    keywords: dict[str, Any] = {
        "base": base,
        "tip": tip,
        "package_dirs": package_dir or (),
        "xacro_args": xacro_arguments(xacro or []),
        "srdf": srdf,
        "ignore_packages": ignore_packages or (),
        "env_vars": env_vars or (),
    }
    if limits is not None:
        keywords["limits"] = limits
    if locked_joints:
        # Degrees or metres: only the description knows, so that it is read before.
        keywords["locked_joints"] = _locked(load_arm(source, **keywords), locked_joints, radians)
    return source, keywords


def _locked(arm: Arm, pairs: list[str], radians: bool) -> dict[str, float]:
    """Typed JOINT=VALUE pairs in rad and m."""
    joints = arm.description.joints if arm.description else {}
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


def xacro_arguments(pairs: list[str]) -> dict[str, str]:
    """Typed NAME:=VALUE pairs as a mapping."""
    arguments: dict[str, str] = {}
    for pair in pairs:
        name, separator, value = pair.partition(":=")
        if not separator:
            name, equals, value = pair.partition("=")
            meant = f"; did you mean --xacro {shlex.quote(f'{name}:={value}')}?" if equals else ""
            raise InputError(f"--xacro takes NAME:=VALUE; got {pair!r}{meant}")
        arguments[name] = value
    return arguments
