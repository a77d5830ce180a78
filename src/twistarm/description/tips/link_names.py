"""Meanings of link and joint names: tools, fingers, wheels and legs, sensors, ornaments."""

from __future__ import annotations

import re
from functools import cache

_ENDING = r"(_(link|frame|point|site))*(_\d+)?$"

TOOLS = [
    re.compile(rf"(?:^|_)(?:{tool}){_ENDING}")
    for tool in (
        "tool0",
        "tcp|tool_cent(er|re)(_point)?",
        "grasp(ing)?(_?(target|cent(er|re)))?|gripper_?(frame|cent(er|re)|tip)|ee_gripper|pinch",
        r"tool(_?tip)?\d*",
        r"ee\d*|eef|end_?effector\d*",
        "end_?effector_.*|end",
    )
]
"""Names that mean "this is the tool", in order of preference, behind any prefix. The last may mean other links too."""

PARTS = {
    part: re.compile(pattern)
    for part, pattern in {
        "flange": rf"(?:^|_)(flange|attachment){_ENDING}",
        "carrier": rf"(?:^|_)(gripper|hand|claw|suction|suction_cup|vacuum|pen|nozzle|probe|magnet|scoop){_ENDING}",
        "finger": (
            r"finger|knuckle|thumb|claw|jaw|grip|grab|palm|pinc|clamp|tong|"
            r"(?:^|_)(hand|pad|prong|mors|mover|moving)(?:_|\d|$)"
        ),
        "jaw": r"finger|knuckle|thumb|jaw|(?:^|_)(mover|moving|movable)(?:_|\d|$)",
        "locomotion": (
            r"wheel|cast[eo]r|rocker|bogie|suspension|steer|tyre|propell|thigh|calf|shank|ankle|coxa|femur|tibia|"
            r"(?:^|_)(tires?|track|axle|diff|differential|leg|hip|knee|foot|feet|toe)(?:_|\d|$)"
        ),
        "sensor": (
            r"camera|lidar|gimbal|kinect|"
            r"(?:^|_)(cam|eyes?|radar|ptz|antenna|head|neck|pan|tilt|mast|screen|laser)(?:_|\d|$)"
        ),
        "wrist": r"wrist|twist|rotat|(?:^|_)(roll|yaw|pitch)(?:_|\d|$)",
        "ornament": (
            r"camera|lidar|gimbal|kinect|realsense|optical|sensor|motor|servo|marker|aruco|april_?tag|microphone|speaker|"
            r"visual|collision|inertia|antenna|accelero|display|calib|bearing|screw|cable|cover|ft_frame|"
            r"(?:^|_)(mast|cam|laser|screen|lights?|leds?|lamp|imu|tags?|sc|com|itb|zed|d4\d5i?|range|sonar|gyro|depth|rgb|"
            r"button|wire|dummy)(?:_|\d|$)"
        ),
        "linkage": (
            r"cylinder|piston|hydraulic|linear_?actuator|parallel_?(link|rod|bar)|"
            r"(?:^|_)(cyl|rod|ram|strut|spring)(?:_|\d|$)"
        ),
    }.items()
}
"""Names by the part that they tell of.

A flange holds a tool, a carrier is a hand or a tool by its last word, a jaw moves. Locomotion is a wheel, its carrier
or a leg. A sensor is a camera, a head or a mast. A wrist turns a hand. An ornament, such as a light or a tag, only
hangs on an arm. A linkage is a cylinder, a rod or another part that follows.
"""


@cache
def plain(name: str) -> str:
    """The name in lower case with single underscores: `px100/ee_gripperLink` is px100_ee_gripper_link."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()
    return re.sub(r"[^a-z0-9]+", "_", words).strip("_")


def tells_of(part: str, *names: str) -> bool:
    """Whether one of the names is that of a `part`, a key of `PARTS`."""
    return any(PARTS[part].search(plain(name)) for name in names)


def tool_rank(name: str) -> int | None:
    """The rank of a link's name among usual names of tools, 0 the most usual, None for any other name."""
    if tells_of("ornament", name) or tells_of("jaw", name):
        return None
    return next((rank for rank, usual in enumerate(TOOLS) if usual.search(plain(name))), None)


def is_tool(name: str) -> bool:
    """Whether the name is one that only a tool has."""
    return tool_rank(name) in range(len(TOOLS) - 1)


def is_flange(name: str) -> bool:
    """Whether the name is that of a flange."""
    return tells_of("flange", name) and not tells_of("ornament", name)
