"""Findings about a description: a stable code, a severity, the place, the meaning and the remedy."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
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
    "file-not-found": Code("error", "there is no such file"),
    "file-unreadable": Code("error", "the file cannot be opened"),
    "arm-file-unusable": Code("error", "an arm.toml or a DH table has an entry that cannot be understood"),
    "xml-malformed": Code("error", "the text is not well-formed XML"),
    "document-type-refused": Code("error", "a document type opens the door to entities and external files"),
    "no-robot": Code("error", "the file describes no robot: another root element, or no links"),
    # MJCF
    "mjcf-unusable": Code("error", "an element of an MJCF, or a file that it includes, cannot be understood"),
    "mjcf-scenery-left-out": Code("info", "an MJCF has things that no URDF has; the kinematics do not need them"),
    "mjcf-part-not-read": Code("warning", "an MJCF has parts that twistarm does not read; the arm may need them"),
    "mjcf-loop-open": Code("warning", "a constraint of an MJCF is not kept, because no mimic joint can stand for it"),
    # the tree
    "robot-unnamed": Code("warning", "the robot has no name, which other readers refuse"),
    "version-unknown": Code("warning", "the robot has a version of URDF that is not known; read as the newest"),
    "name-missing": Code("error", "a link or joint has no name"),
    "name-duplicate": Code("error", "two links or two joints share a name"),
    "end-missing": Code("error", "a joint does not say which links it joins"),
    "link-undefined": Code("error", "a joint refers to a link that is not there"),
    "two-parents": Code("error", "two joints move the same link"),
    "several-roots": Code("error", "the links fall into several trees"),
    "cycle": Code("error", "links and joints form a circle"),
    "too-deep": Code("error", "the chain is longer than any robot's"),
    "too-many-joints": Code("error", "more moving joints than Pinocchio's data has room for"),
    "too-many-parts": Code("error", "more links, joints or shapes than any robot has"),
    "name-too-long": Code("error", "a name is longer than anybody writes or reads"),
    # joints
    "joint-type-unknown": Code("error", "URDF has no such joint type"),
    "origin-malformed": Code("error", "a joint's place is not given in numbers"),
    "origin-looks-like-degrees": Code("warning", "an rpy goes beyond a whole turn, as degrees would"),
    "axis-malformed": Code("error", "a joint's axis is not given in numbers"),
    "axis-zero": Code("error", "a moving joint's axis has no direction"),
    "word-unread": Code("warning", "a misspelt or doubled word in a joint, which no reader takes up"),
    "axis-not-unit": Code("warning", "a joint's axis is no unit vector; its direction is used"),
    "limit-malformed": Code("error", "a joint limit is no number"),
    "limits-swapped": Code("error", "a joint's lower limit lies above its upper one"),
    "limit-incomplete": Code("warning", "a joint lacks a bound, which is read as 0, or both, which is unbounded"),
    "soft-limits": Code("info", "the soft limits of a safety_controller are kept, inside the joint's own"),
    "soft-limits-unusable": Code("warning", "the soft limits of a safety_controller leave the joint no room"),
    "limit-zero-range": Code("warning", "a joint's bounds are equal; it cannot move"),
    "velocity-not-given": Code("warning", "a velocity limit is absent, zero or negative; planning assumes one"),
    "effort-not-given": Code("warning", "an effort limit is absent, zero or negative"),
    "mimic-malformed": Code("error", "a mimic's multiplier or offset is no number"),
    "mimic-master-missing": Code("error", "a joint mimics one that is not there"),
    "mimic-master-unusable": Code("error", "a joint mimics one with more than one coordinate"),
    "planar-mimics": Code("error", "a planar joint follows another; its motion is not one number"),
    "planar-limits-ignored": Code("info", "URDF has no way to bound a planar joint; its limits are not used"),
    "mimic-circle": Code("error", "joints mimic each other in a circle"),
    "mimic-narrows-limits": Code("info", "a follower's own limits leave its master less room"),
    "mimic-outside-limits": Code("warning", "a mimic drives its follower outside the follower's own limits"),
    "locked-outside-limits": Code("warning", "a joint is locked outside its own limits"),
    # the chain
    "no-tip": Code("error", "it is not clear which link is the tool"),
    "several-tips": Code("info", "no tip was given; the most likely link was chosen"),
    "base-not-above-tip": Code("error", "the tip is not beyond the base"),
    "nothing-moves": Code("error", "no joint moves between base and tip"),
    "floating-in-chain": Code("error", "a floating joint between base and tip: its motion is not a joint angle"),
    "tool-name-taken": Code("error", "the tool has the name of a link"),
    "pose-unusable": Code("error", "a named pose does not fit the arm"),
    "not-compared": Code("warning", "without Pinocchio nothing confirms the arm's kinematics"),
    "limits-unusable": Code("error", "limits given beside the description do not fit the arm"),
    "pose-left-out": Code("warning", "a named pose puts a locked joint elsewhere, or is not on the requested chain"),
    "actuator-left-out": Code("info", "a motor drives joints outside the chain that was asked for"),
    # what stands beside the description
    "srdf-found": Code("info", "an SRDF says more about the robot than its description"),
    "srdf-ambiguous": Code("info", "several SRDFs beside the description are for a robot of its name; none is used"),
    "srdf-ignored": Code("warning", "an SRDF beside the description cannot be read"),
    "srdf-unusable": Code("error", "an element of the SRDF cannot be understood"),
    "srdf-other-robot": Code("warning", "the SRDF is for a robot of another name"),
    "srdf-unknown-name": Code("warning", "the SRDF speaks of links or joints that the description does not have"),
    "state-incomplete": Code("info", "an SRDF's named state does not give every joint of the arm"),
    "state-unusable": Code("warning", "an SRDF's named state has a value that is no number"),
    "state-outside-limits": Code("warning", "an SRDF's named state lies outside the limits"),
    "limits-unknown-joint": Code("warning", "limits are given for a joint that does not exist"),
    "limits-of-others": Code("info", "limits are given for joints that are no coordinates of the arm"),
    "limits-empty": Code("info", "a file of limits gives none"),
    "limits-not-scaled": Code("info", "MoveIt's default scaling of limits is not applied"),
    "limits-entry-unknown": Code("warning", "a file of limits has an entry of an unknown name"),
    "ready-named": Code("info", "the pose to start from is one that the description names"),
    # what hangs on the links
    "collision-shapes": Code("info", "the shapes that stand for the links in collision checks"),
    "collision-mesh-unreadable": Code(
        "warning", "a mesh cannot be read; collision checks use the other shapes of its link"
    ),
    "links-collide": Code("warning", "links collide at the ready pose or nearly always; no SRDF exempts them"),
    "mesh-missing": Code("warning", "mesh files were not found; simple shapes are drawn instead"),
    "bad-geometry": Code("warning", "a shape has no usable size or place; it is not drawn"),
    "material-twice": Code("warning", "a material's name has several colours; the first counts, as in urdfdom"),
    "bad-colour": Code("warning", "a colour is not four numbers from 0 to 1"),
    "inertial-unusable": Code("warning", "a mass or inertia cannot be read; the link counts as massless"),
    # packages and xacro
    "package-not-found": Code("warning", "a package was not found, but nothing the kinematics needs uses it"),
    "package-without-manifest": Code("info", "a folder is taken for a package by its name; it has no package.xml"),
    "package-left-out": Code(
        "info", "a part of the description is left out with the package that the caller does without"
    ),
    "package-not-used": Code("warning", "nothing had to be left out for a package that the caller does without"),
    "environment-kept": Code("info", "an environment variable that was asked for counts as not set"),
    "package-needed-not-found": Code("error", "a package with needed files was not found"),
    "xacro-argument-missing": Code("error", "a xacro argument has no value"),
    "xacro-argument-unknown": Code("error", "xacro arguments were given that the file does not take"),
    "xacro-failed": Code("error", "xacro cannot expand the file"),
    "xacro-recursion": Code("error", "a macro, a property or an included file refers to itself without end"),
    "xacro-expression-refused": Code("error", "an expression does more than compute"),
    "xacro-too-large": Code("error", "expanding the file takes more work than any robot's description needs"),
    "include-pattern-refused": Code("error", "an include has wildcards in a folder's name"),
    "file-outside-packages": Code("error", "an include or a YAML load reaches outside the packages"),
    "file-too-large": Code("error", "a file is larger than any description"),
    # what the doctor sees beyond the reading: limits
    "limits-look-like-degrees": Code("warning", "a joint turns many times round; its limits may be in degrees"),
    "limits-look-like-millimetres": Code("warning", "a slide is longer than any arm's; its limits may be in mm"),
    "limit-range-tiny": Code("warning", "a joint's bounds leave it next to no room"),
    "velocity-implausible": Code("warning", "a velocity limit is beyond any arm's; it may be in degrees, mm or inches"),
    "reach-implausible": Code("warning", "the arm is longer than any; its lengths may be in millimetres or inches"),
    # configurations
    "zero-outside-limits": Code("info", "the arm cannot stand at zero, where many programs start"),
    "home-singular": Code("info", "at zero, or at home, the tool cannot move in every direction that the arm has"),
    "ready-singular": Code("warning", "at the ready pose, where searches start, the tool hardly moves some way"),
    # what the arm is able to do
    "cannot-move": Code("info", "directions in which no joint ever moves the tool"),
    "cannot-turn": Code("info", "axes about which no joint ever turns the tool"),
    "cannot-turn-in-place": Code("info", "rotations that are missing while the tool's position is held"),
    "joints-redundant": Code("info", "the arm has more joints than directions of motion, fewer than six"),
    "joint-without-effect": Code("warning", "a coordinate of the arm never moves the tool"),
    "joint-off-the-chain": Code("info", "joints that are not between base and tip"),
    # axes
    "axes-almost-exact": Code("info", "axes are almost parallel, square or intersecting"),
    "closed-form-missed": Code("info", "axes just miss a closed form of inverse kinematics"),
    # the tool
    "tool-frame-missing": Code("warning", "the tool is the last joint's own frame; nothing says where the arm grips"),
    # bodies
    "mass-missing": Code("info", "links that move have shapes and no mass"),
    "mass-tiny": Code("info", "links have almost no mass"),
    "mass-implausible": Code("warning", "a link is heavier than any arm's; its mass may be in grams"),
    "inertia-impossible": Code("warning", "no distribution of mass has such an inertia"),
    "inertia-implausible": Code("warning", "an inertia is too large for its mass; its unit may be kg mm² or g mm²"),
    "inertia-placeholder": Code("info", "every link has the same mass and inertia; gravity torques mean nothing"),
    "centre-of-mass-far": Code("warning", "a centre of mass lies far outside its link; it may be in millimetres"),
    # meshes
    "mesh-too-large": Code("warning", "a mesh is far larger than the arm; its unit is probably not the metre"),
    "mesh-too-small": Code("warning", "meshes are far smaller than the arm, or scaled to nothing"),
    "mesh-lfs-pointer": Code("warning", "a mesh file holds a Git LFS pointer, not the mesh"),
    "mesh-unreadable": Code("warning", "a mesh file cannot be read; it is not drawn"),
    "mesh-not-looked-at": Code("info", "meshes of a size that the doctor did not check"),
    # engines
    "engine-refuses": Code("error", "Pinocchio refuses the description"),
    "engines-disagree": Code("error", "product of exponentials and Pinocchio disagree about the arm"),
}
"""Every code a finding may carry. `docs/findings.md` is made from this table."""


MOST_OF_A_KIND = 100
"""Most findings of one code. A generated file may have one in every element."""

LONGEST_PLACE, LONGEST_WHAT = 300, 1000
"""Characters: names in a description may have thousands."""


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
    the fact and its meaning, `remedy` the advice to the owner. `repaired` tells that twistarm works on a repaired copy.
    """

    code: str
    severity: Severity
    place: Place
    what: str
    remedy: str
    repaired: bool = False

    def __str__(self) -> str:
        return str(self.text)

    @property
    def text(self) -> str:
        """Severity, place, what and remedy in one message."""
        parts = {"severity": self.severity, "place": self.place, "what": self.what, "remedy": self.remedy}
        return Text("{severity}: {place}: {what} ({remedy})", **parts)


@dataclass
class Findings:
    """The findings of a reading. It counts all, and keeps the first of each code."""

    kept: list[Finding] = field(default_factory=list)
    _counts: Counter[str] = field(default_factory=Counter)

    def take(self, findings: Iterable[Finding]) -> None:
        """Add some."""
        for one in findings:
            self._counts[one.code] += 1
            if self._counts[one.code] <= MOST_OF_A_KIND:
                self.kept.append(one)

    def told(self, place: Place) -> tuple[Finding, ...]:
        """The kept findings, and for each code with more their number, at `place`."""
        more = {code: count - MOST_OF_A_KIND for code, count in self._counts.items() if count > MOST_OF_A_KIND}
        remedy = "correct the listed ones: this may cure the others too"
        rest = (finding(code, place, f"the same is so {many} times more", remedy) for code, many in more.items())
        return (*self.kept, *rest)


def finding(code: str, place: Place, what: str, remedy: str, *, repaired: bool = False) -> Finding:
    """A finding with the severity that belongs to its code."""
    return Finding(code, CODES[code].severity, place, one_line(what, LONGEST_WHAT), remedy, repaired)


def refusal(code: str, place: Place, what: str, remedy: str = "") -> DescriptionError:
    """The error for an unusable description, with its finding."""
    return refused([finding(code, place, what, remedy)])


def refused(findings: Iterable[Finding]) -> DescriptionError:
    """One error for all findings: the first in full, the others counted. `.findings` holds all."""
    every = tuple(findings)
    first, *others = [one for one in every if one.severity == "error"]
    text = joined("; ", filter(None, (Text("{place}: {what}", place=first.place, what=first.what), first.remedy)))
    more = f" (and {len(others)} more: twistarm doctor lists them)" if others else ""
    return DescriptionError(Text("{text}{more}", text=text, more=more), every)
