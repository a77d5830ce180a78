"""A compiled MJCF to a URDF text: bodies and sites become links, and joints keep their names."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...support.checks import Array
from ...theory.rotations import from_quaternion_wxyz, to_rpy
from ...theory.screws import exp
from ..document import Reading, floats
from ..inertial import INERTIA
from ..planar import free_name
from ..semantics import GroupState, Semantics
from ..tree import GRAVITY
from ..writing import add_joint, add_mimic, add_origin, number_text
from .compilation import Compiled, compiled, pose
from .files import Mjcf

ROOT = "world"
"""MuJoCo's name of the body that carries all others."""

TURNS = ("_rz", "_ry", "_rx")
"""Endings of the coordinates of a ball, in the order of `ArmBuilder.spherical`."""

TOLD = {
    "mjcf-scenery-left-out": ("left out", "describe obstacles in a scene.toml, and tighter limits in an arm.toml"),
    "mjcf-part-not-read": ("not read", "correct it, or write it out as bodies, joints and masses"),
    "mjcf-loop-open": ("not kept", "lock or couple the joints in a URDF copy"),
    "mjcf-gravity": ("kept for torques", "turn the arm's first body instead, if a URDF has to say it"),
}
"""The codes of findings about parts of an MJCF, what becomes of the parts, and the remedy."""

SHOWN = 8
"""Most parts in one finding."""

HIDDEN = 3
"""The first group of geoms that MuJoCo's viewer does not show. Collision shapes usually have it."""

UNPAINTED = (0.5, 0.5, 0.5, 1.0)
"""The colour of a geom that gives none, or has that of its material."""

ROUNDED = 1e-3
"""rad or m; a file rounds pi differently in a range and in a command."""


class Translated(NamedTuple):
    """The URDF text, its poses and pairs, and the gravity (3,) [m/s²] in its root frame."""

    urdf: str
    semantics: Semantics | None
    gravity: tuple[float, float, float]


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
    DescriptionError for a file that MuJoCo refuses, and MissingExtraError without MuJoCo.
    """
    mjcf = Mjcf(root, [reading])
    writer = _Writer(mjcf, compiled(mjcf))
    writer.write_bodies()
    writer.couple()
    semantics = writer.semantics(reading)
    gravity = writer.gravity()
    for code, parts in mjcf.notes.items():
        what, remedy = TOLD[code]
        more = f" and {len(parts) - SHOWN} more" if len(parts) > SHOWN else ""
        reading.note(code, None, f"{', '.join([*parts][:SHOWN])}{more}: {what}", remedy)
    return Translated(ET.tostring(writer.robot, "unicode"), semantics, gravity)


class _Writer:
    """The URDF as far as it is written. `bodies` and `joints` are the names of MuJoCo's, made up for those without."""

    def __init__(self, mjcf: Mjcf, found: Compiled) -> None:
        self.mjcf, self.model, self.meshes, self.unweighed = mjcf, found.model, found.meshes, found.unweighed
        self.mujoco = found.mujoco
        self.robot = ET.Element("robot", name=mjcf.root.get("model") or mjcf.readings[0].path.stem)
        ET.SubElement(self.robot, "link", name=ROOT)
        self.contents: dict[str, list[ET.Element]] = {}
        bodies, joints = self._names("BODY", self.model.nbody), self._names("JOINT", self.model.njnt)
        self.links, self.taken = {*bodies}, {*joints}
        self.bodies = [name or free_name(f"body{i}", self.links) for i, name in enumerate(bodies)]
        owners = (self.bodies[i] for i in self.model.jnt_bodyid)
        self.joints = [
            name or free_name(f"{body}_joint", self.taken) for name, body in zip(joints, owners, strict=True)
        ]
        self.moving: dict[int, Moving] = {}
        self.balls: dict[int, str] = {}
        self.masters: dict[int, int] = {}
        self.pairs: set[tuple[str, str]] = set()
        self.efforts, self.commands = self._ranges()
        for i, name in enumerate(self._names("TENDON", self.model.ntendon)):
            mjcf.note("mjcf-scenery-left-out", f"the tendon {name or i}")

    def _names(self, kind: str, count: int) -> list[str]:
        """The names of all objects of a kind; empty for those without."""
        objects = getattr(self.mujoco.mjtObj, f"mjOBJ_{kind}")
        return [self.mujoco.mj_id2name(self.model, objects, i) or "" for i in range(count)]

    # -- bodies ------------------------------------------------------------------------------------------------------

    def write_bodies(self) -> None:
        """Write every body with its joints, sites, shapes and mass."""
        skipped: set[int] = set()
        sites: list[list[tuple[int, str]]] = [[] for _ in self.bodies]
        shapes: list[list[int]] = [[] for _ in self.bodies]
        for i, name in enumerate(self._names("SITE", self.model.nsite)):
            sites[self.model.site_bodyid[i]] += [(i, name)] if name else []
        for i, body in enumerate(self.model.geom_bodyid):
            shapes[body].append(i)
        for i, name in enumerate(self.bodies):
            if (i > 0 and self.model.body_parentid[i] in skipped) or not self._body(i):
                skipped.add(i)
                continue
            for k in shapes[i]:
                self.contents.setdefault(name, []).extend(self._shape(k))
            for k, site in sites[i]:
                link = free_name(f"{site}_site" if site in self.links else site, self.links)
                self._fixed(link, name, pose(self.model.site_pos[k], self.model.site_quat[k]))
        for element in self.robot.findall("link"):
            element.extend(self.contents.get(element.get("name", ""), ()))

    def _body(self, i: int) -> bool:
        """Write a body with its joints and mass. False for a loose one without joints inside, which is left out."""
        if i == 0:
            return True
        model, name, parent = self.model, self.bodies[i], self.bodies[self.model.body_parentid[i]]
        joints = [*range(model.body_jntadr[i], model.body_jntadr[i] + model.body_jntnum[i])]
        free = any(model.jnt_type[j] == self.mujoco.mjtJoint.mjJNT_FREE for j in joints)
        if free or model.body_mocapid[i] >= 0:
            loose = "free" if free else "mocap"
            if len(joints) == self._joints_from(i):
                self.mjcf.note("mjcf-scenery-left-out", f"the {loose} body {name!r}")
                return False
            self.mjcf.note("mjcf-scenery-left-out", f"the motion of the {loose} base {name!r}")
            joints = []
        link, g = parent, pose(model.body_pos[i], model.body_quat[i])
        for j in joints:
            link, g = self._joint(j, link, g, name if j == joints[-1] else "")
        if link not in (parent, name):  # MuJoCo lets a body and its parent overlap
            self.pairs.add((min(parent, name), max(parent, name)))
        if link != name:
            self._fixed(name, link, g)
        if i in self.unweighed:
            self.mjcf.note("mjcf-part-not-read", f"the mass of {name!r}, for want of a mesh")
        elif model.body_mass[i] > 0:
            self.contents[name] = [self._inertial(i)]
        return True

    def _joints_from(self, body: int) -> int:
        """The number of joints of a body and of those that it carries."""
        carried = {body}
        for i in range(body + 1, self.model.nbody):
            carried |= {i} if self.model.body_parentid[i] in carried else set()
        return int(self.model.body_jntnum[sorted(carried)].sum())

    def _inertial(self, i: int) -> ET.Element:
        element, moments = ET.Element("inertial"), self.model.body_inertia[i]
        add_origin(element, pose(self.model.body_ipos[i], self.model.body_iquat[i]))
        ET.SubElement(element, "mass", value=number_text([self.model.body_mass[i]]))
        words = number_text(np.diag(moments)[np.triu_indices(3)]).split()
        ET.SubElement(element, "inertia", dict(zip(INERTIA, words, strict=True)))
        return element

    def _fixed(self, name: str, parent: str, g: Array) -> None:
        add_joint(self.robot, free_name(f"{name}_fixed", self.taken), "fixed", (parent, name), g)

    # -- joints ------------------------------------------------------------------------------------------------------

    def _joint(self, j: int, link: str, g: Array, body: str) -> tuple[str, Array]:
        """Write a joint on `link`, in the body's frame `g`. Return the link beyond, and the body's frame in it.

        The link beyond is the `body`, if its frame fits.
        """
        model, name, kinds = self.model, self.joints[j], self.mujoco.mjtJoint
        ball, slide = (model.jnt_type[j] == kind for kind in (kinds.mjJNT_BALL, kinds.mjJNT_SLIDE))
        origin = pose(model.jnt_pos[j], [1.0, 0.0, 0.0, 0.0])
        axis, zero = np.array(model.jnt_axis[j]), np.zeros(3)
        twist = np.concatenate([axis, zero] if slide else [zero, axis])
        rest = 0.0 if ball else float(model.qpos0[model.jnt_qposadr[j]])
        back = exp(twist, -rest) @ np.linalg.inv(origin)
        limit = {} if ball else self._limit(j, slide=slide)
        turns = [(name, "prismatic" if slide else "revolute" if "lower" in limit else "continuous", axis)]
        if ball:
            self.balls[j] = name
            turns = [(name + end, "continuous", along) for end, along in zip(TURNS, np.eye(3)[::-1], strict=True)]
            if model.jnt_limited[j]:
                self.mjcf.note("mjcf-part-not-read", f"the range of the ball {name!r}")
        fits = bool(body) and np.array_equal(back, np.eye(4))
        ends = [link, *(free_name(f"{turn}_link", self.links) for turn, *_ in turns[: -1 if fits else None])]
        place = g @ origin
        for (turn, kind, along), pair in zip(turns, pairwise([*ends, body] if fits else ends), strict=True):
            element = add_joint(self.robot, turn, kind, pair, place, along, limit)
            if not ball:
                self.moving[j] = Moving(element, place, twist, rest)
            place = np.eye(4)
        return body if fits else ends[-1], back

    def _limit(self, j: int, *, slide: bool) -> dict[str, float]:
        """The numbers of `<limit>`. MJCF has no limits of velocity; 0 is read as "not given"."""
        model, name = self.model, self.joints[j]
        lower, upper = map(float, model.jnt_range[j]) if model.jnt_limited[j] else (-np.inf, np.inf)
        effort = self.efforts.get(j, 0.0)
        if model.jnt_actfrclimited[j]:
            effort = float(np.abs(model.jnt_actfrcrange[j]).max())
        least, most = self.commands.get(j, (-np.inf, np.inf))
        if least - ROUNDED > lower or most + ROUNDED < upper:
            told = f"the ctrlrange of {name!r} ({least:g} to {most:g}), narrower than the joint's range"
            self.mjcf.note("mjcf-scenery-left-out", told)
        bounds = {"lower": lower, "upper": upper} if slide or model.jnt_limited[j] else {}
        return {**bounds, "velocity": 0.0, "effort": effort}

    def _ranges(self) -> tuple[dict[int, float], dict[int, tuple[float, float]]]:
        """The largest effort that an actuator brings to each joint, and the positions that actuators command."""
        model, efforts, commands = self.model, dict[int, float](), dict[int, tuple[float, float]]()
        transmission, gain, bias = self.mujoco.mjtTrn, self.mujoco.mjtGain, self.mujoco.mjtBias
        for i in range(model.nu):
            joint, gear = int(model.actuator_trnid[i, 0]), float(model.actuator_gear[i, 0])
            if int(model.actuator_trntype[i]) > int(transmission.mjTRN_JOINTINPARENT):  # it pulls on something else
                continue
            limited = model.actuator_gaintype[i] == gain.mjGAIN_FIXED and model.actuator_ctrllimited[i]
            command = model.actuator_ctrlrange[i] * model.actuator_gainprm[i, 0]
            motor, servo = (model.actuator_biastype[i] == kind for kind in (bias.mjBIAS_NONE, bias.mjBIAS_AFFINE))
            if model.actuator_forcelimited[i] or (limited and motor):
                force = model.actuator_forcerange[i] if model.actuator_forcelimited[i] else command
                efforts[joint] = max(efforts.get(joint, 0.0), float(np.abs(force).max()) * abs(gear))
            stiffness = -float(model.actuator_biasprm[i, 1]) * gear
            rate = model.actuator_dyntype[i] == self.mujoco.mjtDyn.mjDYN_INTEGRATOR  # its command is a velocity
            if limited and servo and stiffness and not rate:
                least, most = sorted(map(float, command / stiffness))
                before = commands.get(joint, (-np.inf, np.inf))
                commands[joint] = (max(least, before[0]), min(most, before[1]))
        return efforts, commands

    # -- shapes ------------------------------------------------------------------------------------------------------

    def _shape(self, k: int) -> list[ET.Element]:
        """The visual and the collision of a geom. None for a shape that URDF lacks."""
        model, kinds = self.model, self.mujoco.mjtGeom
        kind = kinds(int(model.geom_type[k])).name.removeprefix("mjGEOM_").lower()
        g, size = pose(model.geom_pos[k], model.geom_quat[k]), np.array(model.geom_size[k])
        rod = {"radius": number_text(size[:1]), "length": number_text([2 * size[1]])}
        written = {"box": {"size": number_text(2 * size)}, "sphere": {"radius": rod["radius"]}}
        shape = {**written, "cylinder": rod, "capsule": rod}.get(kind)
        if kind == "mesh" and (mesh := self.meshes.get(int(model.geom_dataid[k]))):
            g, shape = g @ mesh.frame, {"filename": mesh.path, "scale": number_text(mesh.scale)}
        if shape is None:
            self.mjcf.note("mjcf-scenery-left-out", f"a shape of type {kind}")
            return []
        made = [ET.Element("visual")] if model.geom_group[k] < HIDDEN else []
        if made:
            name, rgba = self._colour(k)
            ET.SubElement(ET.SubElement(made[0], "material", name=name), "color", rgba=rgba)
        if model.geom_contype[k] or model.geom_conaffinity[k]:
            made.append(ET.Element("collision"))
        for element in made:
            add_origin(element, g)
            ET.SubElement(ET.SubElement(element, "geometry"), kind, shape)
        return made

    def _colour(self, k: int) -> tuple[str, str]:
        """The name and colour of a geom's material. urdfdom drops all shapes for a material without a name."""
        material, rgba = int(self.model.geom_matid[k]), self.model.geom_rgba[k]
        if material >= 0 and np.array_equal(rgba, np.array(UNPAINTED, np.float32)):
            name = self.mujoco.mj_id2name(self.model, self.mujoco.mjtObj.mjOBJ_MATERIAL, material)
            return name, _single(self.model.mat_rgba[material])
        return f"rgba {_single(rgba)}", _single(rgba)

    # -- what stands beside the bodies -------------------------------------------------------------------------------

    def couple(self) -> None:
        """Make followers of joints by `equality`, first those that stand still."""
        model, joint = self.model, self.mujoco.mjtEq.mjEQ_JOINT
        names = self._names("EQUALITY", model.neq)
        for i in sorted(range(model.neq), key=lambda i: model.eq_obj2id[i] >= 0):
            if not model.eq_active0[i]:
                continue
            kind = self.mujoco.mjtEq(int(model.eq_type[i])).name.removeprefix("mjEQ_").lower()
            reason = self._couple(i) if model.eq_type[i] == joint else "not between joints"
            if reason:
                self.mjcf.note("mjcf-loop-open", f"<{kind}> {names[i] or i} ({reason})")

    def _couple(self, i: int) -> str:
        """Let joint1 follow joint2, q₁ − rest₁ = a₀ + a₁ (q₂ − rest₂), or stand still. Return why it cannot."""
        first, second = int(self.model.eq_obj1id[i]), int(self.model.eq_obj2id[i])
        a0, a1, *higher = map(float, self.model.eq_data[i, :5])
        for j in (first, second) if second >= 0 else (first,):
            if j not in self.moving:
                return f"{self.joints[j]!r} is no hinge or slide of the arm"
        if second >= 0 and any(higher):
            return "its polycoef is not linear"
        if first in self.masters:
            return f"another constraint moves {self.joints[first]!r} already"
        before = second
        while before >= 0 and before != first:
            before = self.masters.get(before, -1)
        if before >= 0:
            return f"{self.joints[second]!r} follows {self.joints[first]!r}"
        self.masters[first], follower = second, self.moving[first]
        if second >= 0:
            offset = follower.rest + a0 - a1 * self.moving[second].rest
            add_mimic(follower.element, self.joints[second], a1, offset)
        else:
            follower.element.set("type", "fixed")
            follower.element[:] = [part for part in follower.element if part.tag in ("parent", "child")]
            add_origin(follower.element, follower.origin @ exp(follower.twist, follower.rest + a0))
            self.moving[first] = follower._replace(rest=-a0)  # its followers see a fixed joint, whose value is 0
        return ""

    def semantics(self, reading: Reading) -> Semantics | None:
        """The keyframes as named poses, and the pairs of `contact/exclude`; None if there are none."""
        for signature in self.model.exclude_signature:
            one, other = sorted((self.bodies[signature >> 16], self.bodies[signature & 0xFFFF]))
            self.pairs.add((one, other))
        taken = {key.get("name", "") for key in self.mjcf.keys}
        poses = {}
        for i, key in enumerate(self.mjcf.keys):
            name = key.get("name") or free_name(f"key{i}", taken)
            text = key.get("qpos")
            try:
                qpos = self.model.qpos0 if text is None else np.array(floats(text, len(text.split())))
            except ValueError as error:
                raise self.mjcf.error(key, str(error)) from error
            poses[name] = self._values(name, qpos)
        attached = self._names("KEY", self.model.nkey)
        poses |= {name: self._values(name, self.model.key_qpos[i]) for i, name in enumerate(attached) if name}
        states = tuple(GroupState(name, "", values) for name, values in poses.items() if values)
        if not states and not self.pairs:
            return None
        return Semantics(reading.path, self.robot.get("name", ""), states=states, disabled=frozenset(self.pairs))

    def _values(self, key: str, qpos: Array) -> dict[str, float]:
        """A keyframe's value of each joint. Empty unless its length is the model's, with or without free bodies."""
        full, addresses, kinds = np.array(self.model.qpos0), self.model.jnt_qposadr, self.mujoco.mjtJoint
        loose = [at + k for at in addresses[self.model.jnt_type == kinds.mjJNT_FREE] for k in range(7)]
        bound = np.delete(np.arange(len(full)), loose)
        if len(qpos) not in (len(full), len(bound)):
            told = f"the keyframe {key!r} ({len(qpos)} numbers; the joints have {len(bound)})"
            self.mjcf.note("mjcf-part-not-read", told)
            return {}
        full[bound if len(qpos) == len(bound) else slice(None)] = qpos
        values = {self.joints[j]: float(full[addresses[j]]) for j in self.moving}
        for j, name in self.balls.items():
            angles = to_rpy(from_quaternion_wxyz(full[addresses[j] : addresses[j] + 4]))[::-1]
            values |= {name + end: float(angle) for end, angle in zip(TURNS, angles, strict=True)}
        return values

    def gravity(self) -> tuple[float, float, float]:
        """The acceleration of free fall in the world's axes, with a note unless it is the usual one."""
        off = self.model.opt.disableflags & self.mujoco.mjtDisableBit.mjDSBL_GRAVITY
        x, y, z = (0.0, 0.0, 0.0) if off else map(float, self.model.opt.gravity)
        if (x, y, z) != GRAVITY:
            self.mjcf.note("mjcf-gravity", f"gravity ({x:g}, {y:g}, {z:g}) m/s²")
        return x, y, z


def _single(numbers: Array) -> str:
    """The shortest text of numbers of single precision."""
    return " ".join(str(np.float32(number)) for number in numbers)
