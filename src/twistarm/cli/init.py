"""`init`: a first arm.toml from what is found."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..arm_file_draft import draft_arm_file
from ..errors import InputError
from ..files import writable, write_whole
from ..loading import load_arm
from .options import Base, PackageDir, Srdf, Tip, Xacro, xacro_arguments
from .wording import as_typed

File = Annotated[str, typer.Argument(metavar="FILE", help="URDF or xacro file.")]
Output = Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="Where to write it.")]
Force = Annotated[bool, typer.Option("--force", help="Replace a file that is there.")]


def init(
    file: File,
    output: Output = Path("arm.toml"),
    base: Base = None,
    tip: Tip = None,
    package_dir: PackageDir = None,
    xacro: Xacro = None,
    srdf: Srdf = None,
    force: Force = False,
) -> int:
    """Write a commented arm.toml for FILE: base, tip, xacro arguments, limits to fill in, the ready pose."""
    target = writable(output, over_description=True)
    if target.suffix != ".toml":
        raise InputError(f"an arm file is named *.toml; got {output}")
    if target.exists() and not force:
        raise InputError(f"{output} exists; --force replaces it, --output writes elsewhere")
    draft = draft_arm_file(
        file,
        target.parent,
        base=base,
        tip=tip,
        package_dirs=package_dir or (),
        xacro_args=xacro_arguments(xacro or []),
        srdf=srdf,
    )
    write_whole(target, draft.text, over_description=True)
    if draft.unclear:
        print(f"{output}: written, but take the # away from one tip = in it before it loads: {as_typed(draft.unclear)}")
        return 1
    arm = load_arm(target)
    print(f"{output}: {arm.n} joints from {arm.base} to {arm.tip}; next: twistarm info {output}")
    return 0
