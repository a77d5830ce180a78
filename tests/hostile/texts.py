"""Texts of descriptions that ask for much work, and how a case is written."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from .sandbox import XMLNS

LOADS = ""
"""Expected of a case that must load."""

ARM = (
    '<link name="base"/><link name="upper"/><link name="tool"/>'
    '<joint name="j1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>'
    '<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
    '<joint name="j2" type="revolute"><parent link="upper"/><child link="tool"/><origin xyz="0.3 0 0"/>'
    '<axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
)
"""Two joints, so that everything after the reading runs as well."""

LIMIT = '<limit lower="-2" upper="2" velocity="1" effort="1"/>'
COLLISION = '<collision><geometry><box size="1 1 {0}"/></geometry></collision>'
MESH = '<visual><geometry><mesh filename="{}"/></geometry></visual>'

Text = Callable[[], str | bytes]


@dataclass(frozen=True)
class Case:
    """Files by their path, the first of which is loaded; `refusal`: words of the message, empty for what loads."""

    files: Mapping[str, Text]
    refusal: str = LOADS
    options: tuple[str, ...] = ()
    folders: Callable[[Path], None] | None = field(default=None, repr=False)

    def write(self, folder: Path) -> tuple[str, ...]:
        """Write the files; the arguments for `twistarm info`."""
        for name, text in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            content = text()
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
        if self.folders:
            self.folders(folder)
        return (next(iter(self.files)), *self.options)


def times(count: int, pattern: str) -> str:
    """`pattern` once for each number below `count`, which takes the place of {0}."""
    return "".join(pattern.replace("{0}", str(i)) for i in range(count))


def urdf(inside: Callable[[], str], refusal: str = LOADS, **files: Text) -> Case:
    """An arm with `inside` in its URDF."""
    return Case({"arm.urdf": lambda: f'<robot name="r">{ARM}{inside()}</robot>', **named(files)}, refusal)


def xacro(inside: Callable[[], str], refusal: str = LOADS, **files: Text) -> Case:
    """An arm with `inside` in its xacro file."""
    return Case({"arm.xacro": lambda: f'<robot name="r" {XMLNS}>{inside()}{ARM}</robot>', **named(files)}, refusal)


def named(files: Mapping[str, Text]) -> dict[str, Text]:
    """Keywords as names of files: `a_yaml` is a.yaml."""
    return {".".join(name.rsplit("_", 1)): text for name, text in files.items()}


def included(text: Text) -> Text:
    """A file to include that holds `text`."""
    return lambda: f"<robot {XMLNS}>{_str(text())}</robot>"


def _str(text: str | bytes) -> str:
    return text if isinstance(text, str) else text.decode()


def links(count: int, parent: Callable[[int], str], kind: str = "fixed", more: str = "") -> str:
    """`count` links, each on a joint of its own."""
    return "".join(
        f'<link name="l{i}"/><joint name="k{i}" type="{kind}"><parent link="{parent(i)}"/><child link="l{i}"/>{more}'
        "</joint>"
        for i in range(count)
    )


def part(inside: str = "", more: str = "") -> str:
    """A link x that holds `inside`, on a fixed joint that holds `more`."""
    joint = f'<joint name="x" type="fixed"><parent link="tool"/><child link="x"/>{more}</joint>'
    return f'<link name="x">{inside}</link>{joint}'


def chain(i: int) -> str:
    """The link before."""
    return f"l{i - 1}" if i else "tool"


def hanging(depth: int) -> Callable[[int], str]:
    """Chains of `depth` links on the tool."""
    return lambda i: f"l{i - 1}" if i % depth else "tool"


def mimics(count: int, master: Callable[[int], str]) -> str:
    """`count` followers one after the other, behind the tool."""
    return "".join(
        f'<link name="l{i}"/><joint name="k{i}" type="revolute"><parent link="{chain(i)}"/><child link="l{i}"/>'
        f'<origin xyz="0.1 0 0"/><axis xyz="0 1 0"/>{LIMIT}<mimic joint="{master(i)}" multiplier="1"/></joint>'
        for i in range(count)
    )


def nested_macros(depth: int, inside: str) -> str:
    """`depth` macros that call each other, `inside` in the innermost."""
    return (
        f'<xacro:macro name="m0">{inside}</xacro:macro>'
        + "".join(f'<xacro:macro name="m{i + 1}"><xacro:m{i}/></xacro:macro>' for i in range(depth))
        + f"<xacro:m{depth}/>"
    )


PROPERTY = '<xacro:property name="p" value="1"/>'
TOO_LARGE = "more work than any robot"
INCLUDE = '<xacro:include filename="a.xacro"/>'
