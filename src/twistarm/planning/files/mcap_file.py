"""MCAP files of ROS 2 messages about an arm by rosbags: writing, and reading as a motion."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from functools import partial
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ...arm.arm import Arm, require_arm
from ...support.checks import Array
from ...support.errors import InputError, listed, missing_extra, one_line, without_places
from ...support.files import TEMPORARY, why_no_file, writable, write_whole
from ...support.interrupts import Closeable
from ...support.messages import Argument, Text
from ...theory.rotations import to_xyzw
from ...theory.screws import inverse_of
from ..trajectory import Points, Trajectory, Writing
from .joint_trajectory import FIELDS, points_in

TRAJECTORY, STATE, TEXT = "trajectory_msgs/msg/JointTrajectory", "sensor_msgs/msg/JointState", "std_msgs/msg/String"
GEOMETRY, TIMES = "geometry_msgs/msg/", "builtin_interfaces/msg/"
SETPOINTS, LABELS = "/setpoints", "/labels"

SECOND = 10**9  # nanoseconds
NONE = np.zeros(0)

MAX_MESSAGES = 200_000  # Of a topic that is read: half an hour at 100 Hz.


def _import_rosbags() -> tuple[Any, Any, Any]:
    try:
        from rosbags import interfaces, rosbag2, typesys
    except ImportError as error:
        raise missing_extra("an MCAP file", "rosbags", "mcap") from error
    return rosbag2, interfaces, typesys.get_typestore(typesys.Stores.LATEST)


class Bag(Closeable):
    """A new MCAP file, written in a hidden folder beside its place and moved there at the end.

    Times are seconds after `start` [ns since 1970]. The first message is the description, at `time`.
    """

    def __init__(self, arm: Arm, path: str | os.PathLike[str], start: int = 0, time: float = 0.0) -> None:
        self._arm, self._target, self._start = require_arm(arm), writable(path), start
        if self._target.suffix.lower() != ".mcap":
            raise InputError(f"ROS 2 messages are written to *.mcap; got {path}")
        rosbag2, ros, self._store = _import_rosbags()
        storage_mcap: Any = import_module("rosbags.rosbag2.storage_mcap")
        try:
            self._folder = TemporaryDirectory(prefix=".", suffix=TEMPORARY, dir=self._target.parent)
        except OSError as error:
            raise InputError(f"cannot write {self._target}: {error.strerror or error}") from error
        plugin, modes = rosbag2.StoragePlugin.MCAP, rosbag2.CompressionMode
        self._writer = rosbag2.Writer(Path(self._folder.name) / "bag", version=8, storage_plugin=plugin)
        self._writer.set_compression(modes.STORAGE, rosbag2.CompressionFormat.ZSTD)
        self._writer.open()
        zstd = storage_mcap.zstd  # with checksums, which rosbags leaves out, or readers would not notice damage
        checked = {zstd.CompressionParameter.checksum_flag: 1}
        self._writer.storage.compressor = partial(zstd.compress, options=checked)
        self._topics: dict[str, Any] = {}
        self._links = {arm.tip: arm.base}
        if arm.description is not None:
            joints = arm.description.joints.values()
            self._links = {arm.tip: arm.tip_link} | {joint.child: joint.parent for joint in joints}
            reliable, latched = ros.QosReliability.RELIABLE, ros.QosDurability.TRANSIENT_LOCAL
            ever, alive = ros.QosTime(9223372036, 854775807), ros.QosLiveliness.AUTOMATIC
            how = ros.Qos(ros.QosHistory.KEEP_LAST, 1, reliable, latched, ever, ever, alive, ever, False)
            text = without_places(arm.description.text, arm.description.path)
            self.add("/robot_description", time, TEXT, text, qualities=(how,))

    def close(self) -> None:
        """Move the complete file to its path."""
        if os.path.exists(self._folder.name):
            with self._folder as folder:
                self._writer.close()
                write_whole(self._target, Path(folder) / "bag" / "bag.mcap")

    def of(self, kind: str, *fields: Any) -> Any:
        """A message, or a part of one, with its fields in order."""
        return self._store.types[kind](*fields)

    def add(self, topic: str, time: float, kind: str, *fields: Any, qualities: tuple[Any, ...] = ()) -> None:
        """Write a message. If its kind has a header, this has the time."""
        if topic not in self._topics:
            opened = self._writer.add_connection(topic, kind, typestore=self._store, offered_qos_profiles=qualities)
            self._topics[topic] = opened
        if "header" in self._store.types[kind].__dataclass_fields__:
            fields = (self._header(time), *fields)
        data = self._store.serialize_cdr(self.of(kind, *fields), kind)
        self._writer.write(self._topics[topic], self._start + round(time * SECOND), data)

    def add_state(self, time: float, theta: Array, theta_dot: Array = NONE) -> None:
        """Write the joints at theta (n,), and to /tf each link's pose in the link that carries it."""
        self.add("/joint_states", time, STATE, list(self._arm.joint_names), theta, theta_dot, NONE)
        poses, transforms = self._arm.poses(theta), []
        below, above = (np.array([poses[link] for link in links]) for links in zip(*self._links.items(), strict=True))
        g = inverse_of(above) @ below
        quaternions = to_xyzw(g[:, :3, :3]).tolist()
        for (child, parent), p, q in zip(self._links.items(), g[:, :3, 3].tolist(), quaternions, strict=True):
            place = self.of(f"{GEOMETRY}Vector3", *p), self.of(f"{GEOMETRY}Quaternion", *q)
            pose = self.of(f"{GEOMETRY}Transform", *place)
            transforms.append(self.of(f"{GEOMETRY}TransformStamped", self._header(time, parent), child, pose))
        self.add("/tf", time, "tf2_msgs/msg/TFMessage", transforms)

    def add_motion(self, topic: str, time: float, points: Iterable[tuple[Any, ...]]) -> None:
        """Write a JointTrajectory. A point is its time after `time` [s], θ (n,), θ̇ (n,) and perhaps θ̈ (n,)."""
        made = []
        for after, *states in points:
            begin = self.of(f"{TIMES}Duration", *divmod(round(after * SECOND), SECOND))
            made.append(self.of(f"{TRAJECTORY}Point", *(*states, NONE, NONE)[:4], begin))
        self.add(topic, time, TRAJECTORY, list(self._arm.joint_names), made)

    def _header(self, time: float, frame: str = "") -> Any:
        stamp = self.of(f"{TIMES}Time", *divmod(self._start + round(time * SECOND), SECOND))
        return self.of("std_msgs/msg/Header", stamp, frame)


def mcap_bytes(trajectory: Trajectory, how: Writing) -> bytes:
    """Return the content of the file that `save_trajectory` writes."""
    if how.arm is None:
        raise InputError(Text("an MCAP file holds the poses of all links: give {arm}", arm=Argument("arm")))
    if (arm := require_arm(how.arm)).joint_names != trajectory.joint_names:
        raise InputError(f"{arm.name} has other joints than {listed(trajectory.joint_names)}: give the motion's arm")
    points = list(zip(*trajectory.sample(how.dt), strict=True))
    with TemporaryDirectory(prefix="twistarm-") as folder:
        file = Path(folder) / "motion.mcap"
        with Bag(arm, file) as bag:
            bag.add_motion("/joint_trajectory", 0.0, points)
            for t, theta, theta_dot, _ in points:
                bag.add_state(t, theta, theta_dot)
            for time, text in trajectory.labels:
                bag.add(LABELS, time, TEXT, text)
        return file.read_bytes()


def read_mcap(arm: Arm, file: Path) -> Points:
    """Read the points of `arm` from a recording. Raises InputError, with the point."""
    if why := why_no_file(file):
        raise InputError(f"{file}: {why}")
    rosbag2, _, store = _import_rosbags()
    try:
        with rosbag2.Reader(file) as reader:
            message = _motion(arm, reader, store)
    except InputError as error:
        raise InputError(f"cannot read {file}: {error}") from error
    except Exception as error:  # damaged files raise errors of any type in rosbags
        why = f"it is no whole recording of ROS 2 ({one_line(str(error) or repr(error))})"
        remedy = "copy it again, or save what is whole by `mcap recover`, a program of mcap.dev"
        raise InputError(f"cannot read {file}: {why}; {remedy}") from error
    if not message["points"]:
        raise InputError(f"{file} holds neither one JointTrajectory nor joint states of {listed(arm.joint_names)}")
    return points_in(arm, message, str(file))


def _motion(arm: Arm, reader: Any, store: Any) -> dict[str, Any]:
    """Return the setpoints of a recording, its only JointTrajectory, or its joint states, as plain data."""

    def heard(kind: str, ending: str = "") -> Iterator[tuple[int, Any]]:
        layout = store.get_msgdef(kind)
        topics = [line for line in reader.connections if line.msgtype == kind and line.topic.endswith(ending)]
        for number, (_, time, data) in enumerate(reader.messages(topics) if topics else ()):
            if number == MAX_MESSAGES:
                raise InputError(f"it has more than {MAX_MESSAGES:,} messages on *{ending}; split it")
            decode = layout.deserialize_cdr_le if data[1] else layout.deserialize_cdr_be
            # rclpy leaves bytes behind a message, which the store itself refuses.
            message, _ = decode(data[4:], 0, layout.cls, store)
            yield time, message

    names, points, begin = list(arm.joint_names), list[dict[str, Any]](), 0
    motions = list(dict(heard(TRAJECTORY, SETPOINTS)).items())  # of one instant the last counts
    if not motions and sum(line.msgcount for line in reader.connections if line.msgtype == TRAJECTORY) == 1:
        motions = list(heard(TRAJECTORY))
    for time, motion in motions:
        names, begin = list(motion.joint_names), begin if points else time
        for point in motion.points:
            after = time - begin + point.time_from_start.sec * SECOND + point.time_from_start.nanosec
            points.append(_point(after, point.positions, point.velocities, point.accelerations))
    for time, state in () if motions else heard(STATE, "joint_states"):
        order = [state.name.index(name) for name in names if name in state.name]
        if len(order) == len(names) and len(state.position) == len(state.name):
            begin = begin if points else time
            points.append(_point(time - begin, state.position[order]))
    labels = [{"time": max(0, time - begin) / SECOND, "text": text.data} for time, text in heard(TEXT, LABELS)]
    return {"joint_names": names, "points": points, "labels": labels}


def _point(time: int, *states: Array) -> dict[str, Any]:
    start = dict(zip(("sec", "nanosec"), divmod(time, SECOND), strict=True))
    return dict(zip(FIELDS, map(np.ndarray.tolist, states), strict=False)) | {"time_from_start": start}
