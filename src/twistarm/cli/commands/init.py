"""`init`: a first arm.toml from what is found."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import Annotated, Any

import typer

from ...arm.loading.arm_file_draft import draft_arm_file
from ...arm.loading.load import load_arm
from ...planning.motion_file_draft import draft_motion_file
from ...support.errors import InputError
from ...support.messages import Argument
from ..options import Base, Env, PackageDir, Srdf, Tip, Without, Xacro, load_keywords
from ..output import say
from ..outputs import NAMED, STDOUT, Force, Outputs, outputs_of
from ..wording import words, written

Motion = Annotated[
    bool,
    typer.Option(
        "--motion", help="Write a first motion.toml for the arm, as `twistarm plan ARM motion.toml` takes it."
    ),
]
File = Annotated[str, typer.Argument(metavar="FILE", help="URDF or xacro file; with --motion any ARM.")]


def init(
    file: File,
    output: Annotated[str, NAMED] = "arm.toml",
    base: Base = None,
    tip: Tip = None,
    package_dir: PackageDir = None,
    xacro: Xacro = None,
    ignore_packages: Without = None,
    env_vars: Env = None,
    srdf: Srdf = None,
    force: Force = False,
    motion: Motion = False,
) -> int:
    """Write a commented arm.toml for FILE (base, tip, limits to fill in, the ready pose), or a first motion.toml."""
    if motion and output == "arm.toml":
        output = "motion.toml"
    outputs = outputs_of(output, {"toml": (".toml",)}, force=force, over_description=True)
    if output != STDOUT and not output.endswith(".toml"):
        raise InputError(f"{'a motion' if motion else 'an arm'} file is named *.toml; got {output}")
    _, keywords = load_keywords(file, base, tip, package_dir, xacro, ignore_packages, env_vars, srdf)
    if motion:
        return _motion(file, keywords, output, outputs)
    draft = draft_arm_file(file, Path(os.path.realpath(output)).parent, **keywords)
    outputs.write({"toml": lambda: draft.text})
    if draft.unclear:
        unclear = f"take the # away from one tip = in it before it loads: {words(draft.unclear)}"
        say(f"{output}: written, but {unclear}", file=outputs.words)
        return 1
    if output != STDOUT:
        arm = load_arm(output, env_vars=env_vars or ())
        say(f"{output}: {arm.n} joints from {arm.base} to {arm.tip}; next: twistarm info {output}")
    return 0


def _motion(source: str, keywords: dict[str, Any], output: str, outputs: Outputs) -> int:
    """A first motion.toml for an arm: a description, an arm.toml or a name."""
    arm = load_arm(source, **keywords)
    outputs.write({"toml": lambda: draft_motion_file(arm)})
    if output != STDOUT:
        options = [written(Argument(name, value)) for name, value in keywords.items() if value]
        plan = " ".join(["twistarm plan", shlex.quote(source), shlex.quote(output), *options])
        say(f"{output}: a motion with every kind of segment; next: {plan}")
    return 0
