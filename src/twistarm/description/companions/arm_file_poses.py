"""Poses written into the text of an arm.toml. The rest of the file stays as it is."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from ...support.errors import InputError
from ...support.files import read_bounded, write_whole
from .toml_entries import MAX_BYTES, toml_content, toml_key, toml_text


def write_pose(path: Path, name: str, values: Mapping[str, float], *, replace: bool) -> None:
    """Write the table `[poses.NAME]` of joint = value [rad, m] into the file, whole or not at all.

    Raises InputError if the name is taken and `replace` is not set, or if the file cannot take such a table.
    """
    try:
        text = read_bounded(path, MAX_BYTES).decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot read {path}: {error}") from error
    before = toml_content(text.lstrip("\ufeff"), path)
    if name in before.get("poses", {}) and not replace:
        raise InputError(f"{path} has a pose {name!r} already: choose another name, or replace it")
    written = _with_table(text, name, values)
    wanted = {**before, "poses": {**before.get("poses", {}), name: dict(values)}}
    try:
        fits = toml_content(written.lstrip("\ufeff"), path) == wanted
    except ValueError:
        fits = False
    if not fits:
        raise InputError(f"{path} has no place for a table [poses.{toml_key(name)}]; write the lines in by hand")
    write_whole(path, written, over_description=True)


def _with_table(text: str, name: str, values: Mapping[str, float]) -> str:
    end = "\r\n" if "\r\n" in text else "\n"
    lines = "".join(f"{toml_key(joint)} = {value!r}{end}" for joint, value in values.items())
    keys = "|".join(map(re.escape, (toml_key(name), toml_text(name), f"'{name}'")))
    header = re.search(rf"^[ \t]*\[[ \t]*poses[ \t]*\.[ \t]*(?:{keys})[ \t]*\][^\n]*(?:\n|\Z)", text, re.MULTILINE)
    if header is None:
        apart = end if text.endswith("\n") or not text else 2 * end
        return f"{text}{apart}[poses.{toml_key(name)}]{end}{lines}"
    after = text[header.end() :].splitlines(keepends=True)
    count = next((i for i, line in enumerate(after) if line.lstrip().startswith("[")), len(after))
    notes = [line for line in after[:count] if not line.strip() or line.lstrip().startswith("#")]
    return "".join([text[: header.end()], lines, *notes, *after[count:]])
