"""The words of MJCF that change kinematics, limits or masses, to find misspelt ones."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator

from ...support.errors import closest

PARTS = "body frame replicate joint freejoint geom site camera light plugin attach composite flexcomp include inertial"

CHILDREN = {
    "mujoco": "compiler option size statistic visual default extension custom asset worldbody contact deformable "
    "tendon equality actuator sensor keyframe include",
    **dict.fromkeys(("worldbody", "body", "frame", "replicate"), PARTS),
    "default": "default mesh texture material joint geom site camera light pair equality tendon flex skin general "
    "motor position velocity intvelocity orientation pid damper cylinder muscle adhesion dcmotor plugin",
    "equality": "connect weld joint tendon flex flexvert flexstrain distance",
    "keyframe": "key",
}
"""The elements that MuJoCo takes inside an element."""

PLACED = "name class pos quat axisangle xyaxes zaxis euler user group"

ATTRIBUTES = {
    "compiler": "angle eulerseq autolimits coordinate meshdir texturedir assetdir strippath inertiafromgeom "
    "inertiagrouprange boundmass boundinertia balanceinertia settotalmass discardvisual fusestatic fitaabb alignfree "
    "usethread saveinertial savecanonical savecompiled conflict passthrough convexhull exactmeshinertia",
    "body": f"{PLACED} childclass mocap gravcomp sleep fuse simple",
    "frame": f"{PLACED} childclass",
    "inertial": f"{PLACED} mass diaginertia fullinertia",
    "joint": f"{PLACED} type axis ref range limited margin actuatorfrcrange actuatorfrclimited actuatorgravcomp "
    "armature damping frictionloss stiffness springref springdamper springyield solreflimit solimplimit solreffriction "
    "solimpfriction",
    "site": f"{PLACED} type size fromto rgba material mesh",
    "geom": f"{PLACED} type size fromto mesh hfield mass density shellinertia contype conaffinity condim priority "
    "friction solref solimp solmix margin gap rgba material fitscale fluidshape fluidcoef adhesion castshadow "
    "surfacevel",
    "equality/joint": "name class active joint1 joint2 polycoef solref solimp",
    "key": "name time qpos qvel act ctrl mpos mquat",
}
"""The attributes that MuJoCo takes, those of its older versions included."""


def unknown_words(root: ET.Element) -> Iterator[str]:
    """Each element and attribute that MuJoCo refuses, with the words that it resembles."""
    for parent in root.iter():
        known = CHILDREN.get(parent.tag, "").split()
        for element in parent if known else ():
            if element.tag not in known:
                yield f"<{element.tag[:60]}> in <{parent.tag}>{_near(element.tag, known)}"
            kind = f"equality/{element.tag}" if parent.tag == "equality" else element.tag
            words = ATTRIBUTES.get(kind, "").split()
            for word in element.attrib if words else ():
                if word not in words:
                    named = " ".join(filter(None, (f"<{element.tag}>", element.get("name"))))
                    yield f"{word[:60]} of {named}{_near(word, words)}"


def _near(word: str, known: list[str]) -> str:
    near = closest(word, known).removeprefix("; ")
    return f" ({near})" if near else ""
