"""`init`: a first arm.toml from what is found."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import Annotated

import typer

from ...arm.loading.arm_file_draft import draft_arm_file
from ...arm.loading.load import load_arm
from ...planning.motion_file_draft import draft_motion_file
from ...support.errors import InputError
from ...support.messages import Argument
from ..options import Source
from ..output import say
from ..outputs import NAMED, STDOUT, Force, outputs_of
from ..wording import written

Motion = Annotated[
    bool,
    typer.Option(
        "--motion", help="Write a first motion.toml for the arm, as `twistarm plan ARM motion.toml` takes it."
    ),
]
File = Annotated[
    Source, typer.Argument(metavar="FILE", parser=Source, help="URDF or xacro file; with --motion any ARM.")
]


def init(
    source: File, output: Annotated[str, NAMED] = "arm.toml", force: Force = False, motion: Motion = False
) -> None:
    """Write a commented arm.toml for FILE (base, tip, limits to fill in, the ready pose), or a first motion.toml."""
    if motion and output == "arm.toml":
        output = "motion.toml"
    outputs = outputs_of(output, {"toml": (".toml",)}, force=force, over_description=True)
    if output != STDOUT and not output.endswith(".toml"):
        raise InputError(f"{'a motion' if motion else 'an arm'} file is named *.toml; got {output}")
    if motion:
        text = draft_motion_file(source.load())
        options = [written(Argument(name, value)) for name, value in source.keywords.items() if value]
        plan = " ".join(["twistarm plan", shlex.quote(source.name), shlex.quote(output), *options])
        told = f"{output}: a motion with every kind of segment; next: {plan}"
    else:
        for name, option in (("limits", "--limits"), ("locked_joints", "--locked-joint")):
            if name in source.keywords:
                raise InputError(f"{option} goes into the arm.toml by hand")
        text = draft_arm_file(source.name, Path(os.path.realpath(output)).parent, **source.keywords)
    outputs.write({"toml": lambda: text})
    if output != STDOUT and not motion:
        arm = load_arm(output, env_vars=source.keywords["env_vars"])
        told = f"{output}: {arm.n} joints from {arm.base} to {arm.tip}; next: twistarm info {output}"
    if output != STDOUT:
        say(told)
