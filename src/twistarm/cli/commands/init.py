"""`init`: a first arm.toml from what is found."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import Annotated

from ...arm.loading.arm_file_draft import draft_arm_file
from ...arm.loading.load import load_arm
from ...planning.motion_file import draft_motion_file
from ...support.errors import InputError
from ...support.messages import Argument
from ..numbers import argument, switch
from ..options import Source, answers
from ..output import STDOUT, Outputs, say
from ..wording import written

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
    """Write a commented arm.toml for FILE (base, tip, limits to fill in, the ready pose), or a first motion.toml."""
    outputs = outputs if outputs.files else outputs.named("motion.toml" if motion else "arm.toml")
    output = outputs.files[0][1]
    if output != STDOUT and not output.endswith(".toml"):
        raise InputError(f"{'a motion' if motion else 'an arm'} file is named *.toml; got {output}")
    if motion:
        arm = source.load()
        outputs.write({"toml": lambda: draft_motion_file(arm)})
        if output != STDOUT:
            options = [written(Argument(name, value)) for name, value in source.keywords.items() if value]
            plan = " ".join(["twistarm plan", shlex.quote(source.name), shlex.quote(output), *options])
            say(f"{output}: a motion with every kind of segment; next: {plan}")
        return
    for name in ("limits", "locked_joints"):
        if name in source.keywords:
            raise InputError(f"{'--limits' if name == 'limits' else '--locked-joint'} goes into the arm.toml by hand")
    draft = draft_arm_file(source.name, Path(os.path.realpath(output)).parent, **source.keywords)
    outputs.write({"toml": lambda: draft})
    if output != STDOUT:
        arm = load_arm(output, env_vars=source.keywords["env_vars"])
        say(f"{output}: {arm.n} joints from {arm.base} to {arm.tip}; next: twistarm info {output}")
