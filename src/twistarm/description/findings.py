"""Findings about a description: a stable code, a severity, the place, the meaning and the remedy."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, NamedTuple

from ..support.errors import DescriptionError, one_line
from ..support.messages import Text, joined

Severity = Literal["info", "warning", "error"]


class Code(NamedTuple):
    """The severity of a kind of finding, and its meaning for the arm's owner."""

    severity: Severity
    meaning: str


CODES: dict[str, Code] = {
    # the file
    "file-unreadable": Code("error", "a file does not exist, cannot be opened, or is too large for a description"),
    "xml-malformed": Code("error", "the text is not well-formed XML, or declares a document type"),
    "no-robot": Code("error", "the file describes no robot: another root element, or no links"),
    # MJCF
    "mjcf-unusable": Code("error", "an element of an MJCF, or a file that it includes, cannot be understood"),
    "mjcf-scenery-left-out": Code("info", "an MJCF has things that no URDF has; the kinematics do not need them"),
    "mjcf-part-not-read": Code("warning", "an MJCF has parts that twistarm does not read; the arm may need them"),
    "mjcf-loop-open": Code("warning", "a constraint of an MJCF is dropped: no mimic joint can express it"),
    "mjcf-gravity": Code("info", "the gravity of an MJCF is not straight down, which a URDF cannot express"),
    # the tree
    "name-unusable": Code("error", "a name of a link or joint is missing, used twice, or too long"),
    "not-a-tree": Code("error", "a joint lacks a link, or the links form several trees or a circle"),
    "too-large": Code("error", "more links, joints or shapes, or a longer chain, than any robot has"),
    "word-unread": Code("warning", "a missing, misspelt or unknown word that other readers refuse or pass over"),
    # joints
    "joint-type-unknown": Code("error", "URDF has no such joint type"),
    "number-malformed": Code("error", "an origin, axis, limit or mimic is not given in numbers, or an axis is 0"),
    "axis-not-unit": Code("warning", "a joint's axis is no unit vector; its direction is used"),
    "limits-swapped": Code("error", "a joint's lower limit lies above its upper one"),
    "limit-incomplete": Code("warning", "a joint lacks a bound, which is read as 0, or both, or it can hardly move"),
    "limits-adjusted": Code("info", "a joint's limits are soft ones, a follower's, or none because it is planar"),
    "rate-not-given": Code("warning", "a limit of velocity or effort is absent, zero or negative"),
    "mimic-unusable": Code("error", "a joint mimics one that is missing, mimics it back, or is not one number"),
    "outside-limits": Code(
        "warning", "a follower, a locked joint, a named state or soft limits outside a joint's limits"
    ),
    # the chain
    "no-tip": Code("error", "it is not clear which link is the tool"),
    "several-tips": Code("info", "no tip was given; the most likely link was chosen"),
    "no-chain": Code("error", "no joint moves between base and tip, or a floating one does"),
    "off-the-chain": Code("info", "joints, or their motors, that are not between base and tip"),
    "ready-named": Code("info", "the configuration to start from is one that the description names"),
    # companion files
    "companion-unusable": Code("error", "an entry of an arm.toml, DH table, SRDF or file of limits cannot be used"),
    "srdf-found": Code("info", "an SRDF says more about the robot than its description"),
    "companion-doubtful": Code("warning", "an SRDF, limits or a configuration fit the arm only in part, or not at all"),
    "companion-not-used": Code("info", "an SRDF or a file of limits is not used: several fit, or it gives too little"),
    # packages and xacro
    "package-not-found": Code("warning", "a package was not found, but nothing the kinematics needs uses it"),
    "package-without-manifest": Code("info", "a folder counts as a package by its name; it has no package.xml"),
    "package-left-out": Code("info", "a part of the description is left out with an ignored package"),
    "environment-kept": Code("info", "an environment variable that the file reads counts as not set"),
    "package-needed-not-found": Code("error", "a package with needed files was not found"),
    "xacro-arguments": Code("error", "a xacro argument has no value, or the file does not take it"),
    "xacro-failed": Code("error", "xacro cannot expand the file"),
    "xacro-expression-refused": Code("error", "an expression does more than compute"),
    "file-outside-packages": Code("error", "an include or a YAML load may reach outside the packages"),
    # shapes and masses
    "collision-shapes": Code("info", "the shapes of the links in collision checks"),
    "no-collision-shapes": Code("warning", "links have no collision shapes; other shapes replace them"),
    "links-collide": Code("warning", "links collide at the ready configuration or nearly always; no SRDF exempts them"),
    "mesh-missing": Code("warning", "mesh files were not found; simple shapes are drawn instead"),
    "mesh-unreadable": Code("warning", "a mesh file is damaged or a Git LFS pointer; other shapes replace it"),
    "mesh-open": Code("warning", "the triangles of a mesh are not closed; a body inside it counts as free"),
    "points-far": Code("warning", "a point cloud lies far beyond the arm's reach"),
    "scene-names": Code("warning", "a planning scene has names that are not there, or entries that are not used"),
    "bad-geometry": Code("warning", "a shape has no usable size, place or colour"),
    "inertial-unusable": Code("warning", "a mass or inertia, or an entry of it, cannot be read and counts as 0"),
    "mass-missing": Code("info", "links have shapes and no mass, almost no mass, or all the same"),
    "inertia-implausible": Code("warning", "no link has such a mass, centre or inertia; its unit may be another"),
    # what the doctor sees beyond the reading
    "unit-doubtful": Code("warning", "angles look like degrees, or lengths, meshes or velocities like other units"),
    "zero-outside-limits": Code("info", "zero, where many programs start, is outside the limits"),
    "home-singular": Code("info", "at zero, or at home, the tool cannot move in every direction that the arm has"),
    "ready-singular": Code("warning", "at ready, where searches start, the tool hardly moves some way"),
    "cannot-move": Code("info", "directions in which no joint ever moves the tool"),
    "cannot-turn": Code("info", "axes about which no joint ever turns the tool"),
    "cannot-turn-in-place": Code("info", "rotations that are missing while the tool's position is held"),
    "joint-without-effect": Code("warning", "a coordinate of the arm never moves the tool"),
    "axes-almost-exact": Code("info", "axes are almost parallel, square or intersecting, or just miss a closed form"),
    "tool-frame-missing": Code("warning", "the tool is the last joint's own frame; where the arm grips is unknown"),
    # engines
    "not-compared": Code("warning", "without Pinocchio nothing confirms the arm's kinematics"),
    "engines-disagree": Code("error", "Pinocchio refuses the description, or finds other kinematics"),
}
"""Every code a finding may carry. `docs/findings.md` is made from this table."""


LONGEST_PLACE, LONGEST_WHAT = 300, 1000  # Characters: names in a description may have thousands.


@dataclass(frozen=True)
class Place:
    """A place in a description: the file, the line if known, and the element with its name."""

    file: str = ""
    line: int | None = None
    element: str = ""
    name: str = ""

    def __str__(self) -> str:
        line = f":{self.line}" if self.line is not None else ""
        element = f"{self.element} {self.name!r}" if self.name else self.element
        text = ": ".join(part for part in (f"{self.file}{line}" if self.file else "", element) if part)
        return one_line(text, LONGEST_PLACE)


@dataclass(frozen=True)
class Finding:
    """One observation about a description.

    `code` is stable and machine-readable (see `CODES`). `place` names the file, its line and the element. `what` gives
    the fact and its meaning, `remedy` the advice to the owner.
    """

    code: str
    severity: Severity
    place: Place
    what: str
    remedy: str

    def __str__(self) -> str:
        return str(self.text)

    @property
    def text(self) -> str:
        """Severity, place, what and remedy in one message."""
        parts = {"severity": self.severity, "place": self.place, "what": self.what, "remedy": self.remedy}
        return Text("{severity}: {place}: {what} ({remedy})", **parts)


def finding(code: str, place: Place, what: str, remedy: str) -> Finding:
    """A finding with the severity that belongs to its code."""
    return Finding(code, CODES[code].severity, place, one_line(what, LONGEST_WHAT), remedy)


def refusal(code: str, place: Place, what: str, remedy: str = "") -> DescriptionError:
    """The error for an unusable description, with its finding."""
    return refused([finding(code, place, what, remedy)])


def refused(findings: Iterable[Finding]) -> DescriptionError:
    """One error for all findings: the first in full, the others counted. `.findings` holds all."""
    every = tuple(findings)
    first, *others = [finding for finding in every if finding.severity == "error"]
    text = joined("; ", filter(None, (Text("{place}: {what}", place=first.place, what=first.what), first.remedy)))
    more = f" (and {len(others)} more: twistarm doctor lists them)" if others else ""
    return DescriptionError(Text("{text}{more}", text=text, more=more), every)


_MEANS: dict[Severity, str] = {
    "error": "The arm cannot be loaded; nothing is guessed.",
    "warning": "The arm loads, but something is missing, repaired or doubtful.",
    "info": "Good to know; nothing needs to change.",
}


def codes_page() -> str:
    """The codes by severity in Markdown, each with what it means."""
    parts = ["# Findings", "", "Made by `twistarm doctor --codes`. The codes are stable: programs may rely on them."]
    for severity, meaning in _MEANS.items():
        rows = {f"`{code}`": known.meaning for code, known in CODES.items() if known.severity == severity}
        wide, long = max(map(len, rows)), max(map(len, rows.values()))
        parts += ["", f"## {severity}", "", meaning, ""]
        parts += [f"| {'code':{wide}} | {'what it means':{long}} |", f"|{'-' * (wide + 2)}|{'-' * (long + 2)}|"]
        parts += [f"| {code:{wide}} | {means:{long}} |" for code, means in rows.items()]
    return "\n".join(parts) + "\n"
