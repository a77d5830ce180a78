"""MJCF to a URDF text: bodies and sites become links, and joints keep their names."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from itertools import islice, pairwise
from typing import NamedTuple

import numpy as np

from ...support.checks import Array
from ...theory.rotations import from_quaternion_wxyz, to_rpy
from ...theory.screws import exp
from ..document import Reading, floats
from ..inertial import Body
from ..planar import free_name
from ..semantics import GroupState, Semantics
from ..writing import add_joint, add_mimic, add_origin
from .document import ACTUATORS, EQUALITY, MAIN, Attributes, Mjcf, read_mjcf
from .schema import unknown_words
from .shapes import Shapes, explicit_body, inertial_of, kind_of, several

ROOT = "world"
"""MuJoCo's name of the body that carries all others."""

TURNS = ("_rz", "_ry", "_rx")
"""Endings of the coordinates of a ball, in the order of `ArmBuilder.spherical`."""

TOLD = {
    "mjcf-scenery-left-out": ("left out", "describe obstacles in a scene.toml, and tighter limits in an arm.toml"),
    "mjcf-part-not-read": ("not read", "correct it, or write it out as bodies, joints and masses"),
    "mjcf-loop-open": ("not kept", "lock or couple the joints in a URDF copy"),
}
"""The codes of findings about parts of an MJCF, what becomes of the parts, and the remedy."""

SHOWN, MOST_UNKNOWN = 8, 30
"""Most parts in one finding, and most unknown words that are looked for."""

NOT_READ = ("composite", "flexcomp", "attach", "replicate", "plugin")
SECTIONS = ("tendon", "deformable")
WEIGHTLESS = ("plane", "hfield")
"""Types of geoms without a mass."""

JOINED = ("joint1", "joint2", "body1", "body2", "site1", "site2", "tendon1", "tendon2")
"""The attributes of constraints that name what they join."""

SCALED = "settotalmass"
"""A setting of `<compiler>` that scales all masses, also those of free bodies and meshes."""

DRIVEN = ("position", "pid")
"""Actuators whose command is a position."""

ROUNDED = 1e-3
"""rad or m; a file rounds pi differently in a range and in a command."""


class Translated(NamedTuple):
    """The URDF text, the MJCF as one text, and its poses and pairs.

    In the MJCF every body and joint has a name, and `equality` holds what the URDF keeps of it.
    """

    urdf: str
    mjcf: str
    semantics: Semantics | None


class Moving(NamedTuple):
    """A hinge or slide that was written: its element, its frame (4, 4), its twist (6,), its value at rest."""

    element: ET.Element
    origin: Array
    twist: Array
    rest: float


def translated(root: ET.Element, reading: Reading) -> Translated:
    """Translate an MJCF. What URDF has no word for is left out, with findings in `reading`.

    A joint that does not turn about its body's origin, or is not 0 at rest, gets a link between. A ball becomes three
    turns, the Euler angles ZYX. Free bodies without joints are left out, and other free bodies stand still. Raises
    DescriptionError for an unusable element.
    """
    writer = _Writer(read_mjcf(root, reading))
    writer.inside(root.findall("worldbody"), ROOT, MAIN)
    writer.couple()
    semantics = writer.semantics(reading)
    for code, parts in writer.noted.items():
        what, remedy = TOLD[code]
        more = f" and {len(parts) - SHOWN} more" if len(parts) > SHOWN else ""
        reading.note(code, None, f"{', '.join([*parts][:SHOWN])}{more}: {what}", remedy)
    for link in writer.robot.findall("link"):
        link.extend(writer.contents.get(link.get("name", ""), ()))
    return Translated(ET.tostring(writer.robot, "unicode"), ET.tostring(root, "unicode"), semantics)


def titled(element: ET.Element) -> str:
    """The tag of an element, and its name or the names that it joins."""
    name = element.get("name") or element.get("prefix")
    return " ".join([f"<{element.tag}>", *([name] if name else filter(None, map(element.get, JOINED)))])


class _Writer:
    """The URDF as far as it is written. `layout` has the joints of each part of a keyframe's qpos, and its length."""

    def __init__(self, mjcf: Mjcf) -> None:
        self.mjcf = mjcf
        self.robot = ET.Element("robot", name=mjcf.root.get("model") or mjcf.readings[0].path.stem)
        ET.SubElement(self.robot, "link", name=ROOT)
        self.contents: dict[str, list[ET.Element]] = {}
        self.noted: dict[str, dict[str, None]] = {}
        self._shapes = Shapes(mjcf)
        self._links = {ROOT, *(body.get("name", "") for body in mjcf.root.iter("body"))}
        self._joints = {joint.get("name", "") for joint in mjcf.root.iter("joint")}
        self._moving: dict[str, Moving] = {}
        self._masters: dict[str, str] = {}
        self._layout: list[tuple[tuple[str, ...], int]] = []
        self._carried: set[str] = set()
        self._pairs: set[tuple[str, str]] = set()
        self._efforts: dict[str, float] = {}
        self._commands: dict[str, tuple[float, float]] = {}
        for actuator in mjcf.each("actuator", *ACTUATORS):
            with mjcf.blaming(actuator):
                self._keep_ranges(mjcf.attributes(actuator), actuator.tag)
        for part in (part for section in SECTIONS for whole in mjcf.root.findall(section) for part in whole):
            self._note("mjcf-scenery-left-out", titled(part))
        if mjcf.compiler.get(SCALED, "-1") != "-1":
            self._note("mjcf-part-not-read", f"{SCALED} of <compiler>")
        for unknown in islice(unknown_words(mjcf.root), MOST_UNKNOWN):
            self._note("mjcf-part-not-read", unknown)

    def _note(self, code: str, part: str) -> None:
        self.noted.setdefault(code, {})[part] = None

    # -- bodies ------------------------------------------------------------------------------------------------------

    def inside(self, elements: list[ET.Element], link: str, childclass: str) -> None:
        """Write what the elements of one body hold."""
        parts = [part for element in elements for part in self._parts(element, np.eye(4), childclass)]
        rule = self.mjcf.compiler.get("inertiafromgeom", "auto")
        from_geoms = rule == "true" or (rule == "auto" and all(part.tag != "inertial" for part, *_ in parts))
        bodies: list[Body] = []
        given: list[Body] = []  # it counts also by the rule "true" if no geom weighs
        for part, frame, around in parts:
            with self.mjcf.blaming(part):
                if part.tag == "geom":
                    bodies += self._geom(self.mjcf.attributes(part, around), link, frame, from_geoms)
                elif part.tag == "inertial":
                    given.append(explicit_body(dict(part.attrib), self.mjcf))
                elif part.tag == "site" and part.get("name"):
                    name, pose = part.get("name", ""), self.mjcf.pose(self.mjcf.attributes(part, around))
                    part.set("name", free_name(f"{name}_site" if name in self._links else name, self._links))
                    self._fixed(part.get("name", ""), link, frame @ pose)
                elif part.tag in NOT_READ:
                    self._note("mjcf-part-not-read", titled(part))
        for body in elements if link != ROOT else ():
            with self.mjcf.blaming(body):
                self.contents.setdefault(link, []).extend(inertial_of(bodies or given, self.mjcf.compiler))
        for part, frame, around in parts:
            if part.tag == "body":
                self._body(part, link, frame, around)

    def _parts(self, element: ET.Element, frame: Array, childclass: str) -> Iterator[tuple[ET.Element, Array, str]]:
        """The elements of a body, also those in frames, each with its frame (4, 4) and the class around it."""
        around = element.get("childclass", childclass)
        for part in element:
            if part.tag != "frame":
                yield part, frame, around
                continue
            with self.mjcf.blaming(part):
                inner = frame @ self.mjcf.pose(dict(part.attrib))
            yield from self._parts(part, inner, around)

    def _geom(self, given: Attributes, link: str, frame: Array, weighs: bool) -> list[Body]:
        """Write a geom of a link. Return its body if it `weighs`."""
        shapes, body = self._shapes.of(given, frame)
        self.contents.setdefault(link, []).extend(shapes or ())
        kind, (group,) = kind_of(given), floats(given.get("group", "0"), 1)
        low, high = floats(self.mjcf.compiler.get("inertiagrouprange", "0 5"), 2)
        weighs = weighs and low <= group <= high and kind not in WEIGHTLESS
        weightless = 0.0 in several(f"{given.get('mass', 1)} {given.get('density', 1)}")
        if weighs and not weightless and link in self._carried and (not body or given.get("shellinertia") == "true"):
            self._note("mjcf-part-not-read", f"the mass of a mesh or a hollow shape of {link!r}")
        if shapes is None:
            self._note("mjcf-scenery-left-out", f"a shape of type {kind}")
        return [body] if body and body.mass > 0 and weighs else []

    def _body(self, body: ET.Element, parent: str, frame: Array, childclass: str) -> None:
        name = body.get("name") or free_name(f"body{len(self._links)}", self._links)
        body.set("name", name)
        with self.mjcf.blaming(body):
            g = frame @ self.mjcf.pose(dict(body.attrib))
        found = [
            (part, self.mjcf.attributes(part, around), local)
            for part, local, around in self._parts(body, np.eye(4), childclass)
            if part.tag in ("joint", "freejoint")
        ]
        free = any(part.tag == "freejoint" or given.get("type") == "free" for part, given, _ in found)
        self._layout += [((), 7)] if free else []
        if free or body.get("mocap") == "true":
            loose = "free" if free else "mocap"
            if len([*body.iter("joint")]) == sum(part.tag == "joint" for part, *_ in found):
                return self._note("mjcf-scenery-left-out", f"the {loose} body {name!r}")
            self._note("mjcf-scenery-left-out", f"the motion of the {loose} base {name!r}")
            found = []
        self._carried |= {name} if found or parent in self._carried else set()
        link = parent
        for i, (joint, given, local) in enumerate(found):
            joint.set("name", joint.get("name") or free_name(f"{name}_joint", self._joints))
            with self.mjcf.blaming(joint):
                link, g = self._joint(joint, given, link, g, local, "" if i < len(found) - 1 else name)
        if link not in (parent, name):  # MuJoCo lets a body and its parent overlap
            self._pairs.add((min(parent, name), max(parent, name)))
        if link != name:
            self._fixed(name, link, g)
        return self.inside([body], name, childclass)

    def _fixed(self, name: str, parent: str, g: Array) -> None:
        add_joint(self.robot, free_name(f"{name}_fixed", self._joints), "fixed", (parent, name), g)

    def _joint(
        self, joint: ET.Element, given: Attributes, link: str, g: Array, local: Array, body: str
    ) -> tuple[str, Array]:
        """Write a joint on `link`, in the body's frame `g`. Return the link beyond, and the body's frame in it.

        `local` (4, 4) is the frame that the joint is given in. The link beyond is the `body`, if its frame fits.
        """
        name, kind, origin = joint.get("name", ""), given.get("type", "hinge"), np.eye(4)
        if kind not in ("hinge", "slide", "ball"):
            raise ValueError(f"joint type {kind[:60]!r} is none of hinge, slide, ball, free")
        if kind == "ball" and "range" in given and given.get("limited") != "false":
            self._note("mjcf-part-not-read", f"the range of the ball {name!r}")
        origin[:3, 3] = local[:3, :3] @ floats(given.get("pos", "0 0 0"), 3) + local[:3, 3]
        axis = local[:3, :3] @ floats(given.get("axis", "0 0 1"), 3)
        axis = axis / max(float(np.linalg.norm(axis)), 1e-300)
        twist = np.concatenate([np.zeros(3), axis] if kind == "hinge" else [axis, np.zeros(3)])
        (rest,) = floats(given.get("ref", "0"), 1) if kind != "ball" else (0.0,)
        rest = self.mjcf.angle(rest) if kind == "hinge" else rest
        back = exp(twist, -rest) @ np.linalg.inv(origin)
        limit = self._limit(name, kind, given) if kind != "ball" else {}
        turns = [(name, "prismatic" if kind == "slide" else "revolute" if "lower" in limit else "continuous", axis)]
        if kind == "ball":
            turns = [(name + end, "continuous", along) for end, along in zip(TURNS, np.eye(3)[::-1], strict=True)]
        self._layout.append((tuple(turn for turn, *_ in turns), 4 if kind == "ball" else 1))
        fits = bool(body) and np.array_equal(back, np.eye(4))
        ends = [link, *(free_name(f"{turn}_link", self._links) for turn, *_ in turns[: -1 if fits else None])]
        place = g @ origin
        for (turn, sort, along), pair in zip(turns, pairwise([*ends, body] if fits else ends), strict=True):
            element = add_joint(self.robot, turn, sort, pair, place, along, limit)
            if kind != "ball":
                self._moving[name] = Moving(element, place, twist, rest)
            place = np.eye(4)
        return body if fits else ends[-1], back

    def _limit(self, name: str, kind: str, given: Attributes) -> dict[str, float]:
        """The numbers of `<limit>`. MJCF has no limits of velocity; 0 is read as "not given"."""
        lower, upper = (self.mjcf.angle(x) if kind == "hinge" else x for x in floats(given.get("range", "0 0"), 2))
        automatic = self.mjcf.compiler.get("autolimits", "true") == "true" and (lower, upper) != (0.0, 0.0)
        bounds = {"lower": lower, "upper": upper}
        if not {"true": True, "false": False}.get(given.get("limited", ""), automatic):
            bounds = {"lower": -np.inf, "upper": np.inf} if kind == "slide" else {}
        least, most = self._commands.get(name, (-np.inf, np.inf))
        if least - ROUNDED > bounds.get("lower", -np.inf) or most + ROUNDED < bounds.get("upper", np.inf):
            told = f"the ctrlrange of {name!r} ({least:g} to {most:g}), narrower than the joint's range"
            self._note("mjcf-scenery-left-out", told)
        effort = self._efforts.get(name, 0.0)
        if "actuatorfrcrange" in given and given.get("actuatorfrclimited") != "false":
            effort = max(map(abs, floats(given["actuatorfrcrange"], 2)))
        return {**bounds, "velocity": 0.0, "effort": effort}

    def _keep_ranges(self, given: Attributes, tag: str) -> None:
        """Keep the largest effort that an actuator brings to its joint, and the positions that it commands."""
        joint, gear = given.get("joint", ""), [*several(given.get("gear", "1")), 1.0][0]
        if joint not in ("", *self._joints):
            self._note("mjcf-part-not-read", f"an actuator of {joint[:60]!r}, which is no joint")
        words = given.get("forcerange") if given.get("forcelimited") != "false" else None
        command = given.get("ctrlrange") if given.get("ctrllimited") != "false" else None
        if words := words or (command if tag == "motor" else None):
            effort = max(map(abs, floats(words, 2))) * abs(gear)
            self._efforts[joint] = max(self._efforts.get(joint, 0.0), effort)
        if command and tag in DRIVEN and gear:
            least, most = sorted(value / gear for value in floats(command, 2))
            before = self._commands.get(joint, (-np.inf, np.inf))
            self._commands[joint] = (max(least, before[0]), min(most, before[1]))

    # -- what stands beside the bodies -------------------------------------------------------------------------------

    def couple(self) -> None:
        """Make followers of joints by `equality`. Take constraints that are not kept out of the MJCF."""
        parts = [(part, section) for section in self.mjcf.root.findall("equality") for part in section]
        given = {part: self.mjcf.attributes(part, kind=EQUALITY) for part, _ in parts}
        parts.sort(key=lambda each: "joint2" in given[each[0]])  # first those that stand still
        for part, section in parts:
            if given[part].get("active") == "false":
                continue
            with self.mjcf.blaming(part):
                why = self._couple(given[part]) if part.tag == "joint" else "not between joints"
            if why:
                section.remove(part)
                self._note("mjcf-loop-open", f"{titled(part)} ({why})")

    def _couple(self, given: Attributes) -> str:
        """Let joint1 follow joint2, q₁ − rest₁ = a₀ + a₁ (q₂ − rest₂), or stand still. Return why it cannot."""
        first, second = given.get("joint1", ""), given.get("joint2", "")
        words = several(given.get("polycoef", ""))
        a0, a1, *higher = [*words, *(0.0, 1.0, 0.0, 0.0, 0.0)[len(words) :]]
        for name in (first, second) if second else (first,):
            if name not in self._moving:
                return f"{name[:60]!r} is no hinge or slide of the arm"
        if any(higher):
            return "its polycoef is not linear"
        if first in self._masters:
            return f"another constraint moves {first!r} already"
        before = second
        while before and before != first:
            before = self._masters.get(before, "")
        if before:
            return f"{second!r} follows {first!r}"
        self._masters[first], follower = second, self._moving[first]
        if second:
            add_mimic(follower.element, second, a1, follower.rest + a0 - a1 * self._moving[second].rest)
        else:
            follower.element.set("type", "fixed")
            follower.element[:] = [part for part in follower.element if part.tag in ("parent", "child")]
            add_origin(follower.element, follower.origin @ exp(follower.twist, follower.rest + a0))
            self._moving[first] = follower._replace(rest=-a0)  # its followers see a fixed joint, whose value is 0
        return ""

    def semantics(self, reading: Reading) -> Semantics | None:
        """The keyframes as named poses, and the pairs of `contact/exclude`; None if there are none."""
        for exclude in self.mjcf.each("contact", "exclude"):
            one, other = sorted((exclude.get("body1", ""), exclude.get("body2", "")))
            self._pairs.add((one, other))
        states, keys = [], [*self.mjcf.each("keyframe", "key")]
        taken = {key.get("name", "") for key in keys}
        for i, key in enumerate(keys):
            key.set("name", key.get("name") or free_name(f"key{i}", taken))
            with self.mjcf.blaming(key):
                values = self._values(key)
            states += [GroupState(key.get("name", ""), "", values)] if values else []
        if not states and not self._pairs:
            return None
        name = self.robot.get("name", "")
        return Semantics(reading.path, name, states=tuple(states), disabled=frozenset(self._pairs))

    def _values(self, key: ET.Element) -> dict[str, float]:
        """A keyframe's value of each joint. Empty unless its length is the model's, with or without free bodies."""
        if "qpos" not in key.attrib:
            every = {name: 0.0 for names, _ in self._layout for name in names}  # a ball rests at 0
            return every | {name: moving.rest for name, moving in self._moving.items()}
        qpos, length = several(key.get("qpos", "")), sum(length for _, length in self._layout)
        layout = self._layout if len(qpos) == length else [part for part in self._layout if part[0]]
        values: dict[str, float] = {}
        if len(qpos) != sum(length for _, length in layout):
            self._note(
                "mjcf-part-not-read",
                f"the keyframe {key.get('name')!r} ({len(qpos)} numbers; the joints have {length})",
            )
            return values
        for names, length in layout:
            numbers, qpos = qpos[:length], qpos[length:]
            if length == 4:
                numbers = to_rpy(from_quaternion_wxyz(numbers))[::-1].tolist()
            values |= dict(zip(names, numbers, strict=False))
        return values
