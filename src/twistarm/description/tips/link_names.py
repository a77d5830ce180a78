"""Meanings of link and joint names: tools, fingers, wheels, legs, sensors and ornaments."""

from __future__ import annotations

import re
from collections.abc import Iterable

_ENDING = r"(_(link|frame|point|site))*(_\d+)?$"

_TOOLS = (
    "tool0",
    "tcp|tool_cent(er|re)(_point)?",
    "grasp(ing)?(_?(target|cent(er|re)))?|gripper_(frame|cent(er|re)|tip)|ee_gripper|pinch",
    r"tool(_?tip)?\d*",
    r"ee\d*|eef|end_?effector\d*",
    "end_?effector_.*|end",
)
"""Names that mean "this is the tool", in order of preference, behind any prefix."""

_USUAL = [re.compile(rf"(?:^|_)(?:{tool}){_ENDING}") for tool in _TOOLS]
_FLANGE = re.compile(rf"(?:^|_)flange{_ENDING}")
_CARRIER = re.compile(rf"(?:^|_)(gripper|hand|claw|suction|suction_cup|vacuum|pen|nozzle|probe|magnet|scoop){_ENDING}")
_FINGER = re.compile(
    r"finger|knuckle|thumb|claw|jaw|grip|grab|palm|pinc|clamp|tong|(?:^|_)(hand|pad|prong|mors|mover|moving)(?:_|\d|$)"
)
_JAW = re.compile(r"finger|knuckle|thumb|jaw|(?:^|_)(mover|moving|movable)(?:_|\d|$)")
_HAND = re.compile(r"grip|jaw|palm|(?:^|_)(hand|stator)(?:_|\d|$)")
_ROLLING = re.compile(
    r"wheel|cast[eo]r|rocker|bogie|suspension|steer|tyre|propell|thigh|calf|shank|ankle|coxa|femur|tibia|"
    r"(?:^|_)(tires?|track|axle|diff|differential|leg|hip|knee|foot|feet|toe)(?:_|\d|$)"
)
_CAMERA = re.compile(r"camera|lidar|gimbal|kinect|(?:^|_)(cam|eyes?|radar|ptz|antenna)(?:_|\d|$)")
_SENSOR = re.compile(_CAMERA.pattern + r"|(?:^|_)(head|neck|pan|tilt|mast|screen|laser)(?:_|\d|$)")
_WRIST = re.compile(r"wrist|twist|rotat|(?:^|_)(roll|yaw|pitch)(?:_|\d|$)")
_ORNAMENT = re.compile(
    r"camera|lidar|gimbal|kinect|realsense|optical|sensor|motor|servo|marker|aruco|april_?tag|microphone|speaker|"
    r"visual|collision|inertia|antenna|accelero|display|calib|bearing|screw|cable|cover|ft_frame|"
    r"(?:^|_)(mast|cam|laser|screen|lights?|leds?|lamp|imu|tags?|sc|com|itb|zed|d4\d5i?|range|sonar|gyro|depth|rgb|"
    r"button|wire|dummy)(?:_|\d|$)"
)
_LINKAGE = re.compile(
    r"cylinder|piston|hydraulic|linear_?actuator|parallel_?(link|rod|bar)|(?:^|_)(cyl|rod|ram|strut|spring)(?:_|\d|$)"
)


PARTS = {
    "finger": _FINGER,
    "hand": _HAND,
    "locomotion": _ROLLING,
    "camera": _CAMERA,
    "sensor": _SENSOR,
    "wrist": _WRIST,
    "linkage": _LINKAGE,
}
"""What names tell of: a hand or a part of one, what jaws move on, a wheel, what carries it or a leg, what looks or
listens, a head, a mast or a camera, a joint that turns a hand, and a cylinder, a rod or what else only follows."""


def plain(name: str) -> str:
    """The name in lower case with single underscores: `px100/ee_gripperLink` is px100_ee_gripper_link."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()
    return re.sub(r"[^a-z0-9]+", "_", words).strip("_")


def tool_rank(name: str) -> int | None:
    """The rank of a tool's name, 0 the most usual; None for other names."""
    if is_ornament(name) or is_jaw(name):
        return None
    words = plain(name)
    return next((rank for rank, usual in enumerate(_USUAL) if usual.search(words)), None)


def is_tool(name: str) -> bool:
    """Whether the name is one that only a tool has."""
    rank = tool_rank(name)
    return rank is not None and rank < len(_TOOLS) - 1


def is_flange(name: str) -> bool:
    """Whether it is named as what a tool is screwed on."""
    return _FLANGE.search(plain(name)) is not None and not is_ornament(name)


def carries_tool(name: str) -> bool:
    """Whether the last word is a hand or a tool: `gripper_link`, `suction_cup`, `pen`."""
    return _CARRIER.search(plain(name)) is not None


def is_ornament(name: str) -> bool:
    """Whether its name is that of an attachment: a camera, a light, a motor, a tag."""
    return _ORNAMENT.search(plain(name)) is not None


def is_jaw(name: str) -> bool:
    """Whether it is named like the moving part of a hand."""
    return _JAW.search(plain(name)) is not None


def tells_of(part: str, names: Iterable[str]) -> bool:
    """Whether one of the names is that of a `part`, a key of `PARTS`."""
    return any(PARTS[part].search(plain(name)) for name in names)
