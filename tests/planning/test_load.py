"""Motions read back from files: what was written, what others write, and what is refused with its place."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose

from test_export import LABELS, plain, with_motors
from twistarm import Actuators, load_trajectory, plan_joint, save_trajectory
from twistarm.cli.application import run
from twistarm.support.errors import InputError, LimitError

ENDINGS = (".csv", ".json", ".mcap")
RATES = {"velocity": 1.0, "acceleration": 2.0}


@pytest.fixture(scope="module")
def motion(rover):
    way = [rover.ready, rover.ready + [0.1, 0.3, -0.4, 0.2, 1.0], rover.ready + [-0.1, 0.1, -0.6, -0.3, -1.0]]
    planned = plan_joint(rover, way, limits=RATES)
    return replace(planned, labels=tuple((time * planned.duration / 5.0, text) for time, text in LABELS))


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("kind", ["s_curve", "time_optimal"])
def test_what_was_written_is_read_back(rover, motion, tmp_path, kind, ending):
    planned = plan_joint(rover, motion.waypoints, kind=kind, limits=RATES)
    planned = replace(planned, labels=((0.0, "open"), (1.0, "close"), (1.0, "-5 °C, \"now\": '…' \\"), (1.2345, "ü😀")))
    read = load_trajectory(rover, save_trajectory(planned, tmp_path / f"motion{ending}", dt=0.02, arm=rover))
    assert read.labels == planned.labels
    assert read.joint_names == planned.joint_names
    assert read.actuators is rover.actuators
    assert abs(read.duration - planned.duration) <= 1e-9
    for order in range(3):
        atol = 1e-9 if order < 2 else 1e-6  # a message has nanoseconds; at a jump of the acceleration any side is right
        assert_allclose(read(read.times[1:-1], order), planned(read.times[1:-1], order), atol=atol)
        if ending == ".csv":
            assert np.array_equal(read(read.times[:-1], order), planned(read.times[:-1], order))
    between = np.linspace(0.0, planned.duration, 2001)
    jump = 2.0 * rover.limits.acceleration.max() if kind == "time_optimal" else 2.0 * planned.peak(3).max() * 0.02
    assert np.abs(read(between) - planned(between)).max() <= jump * 0.02**2 / 32


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_motion_of_no_length_is_read_back(rover, tmp_path, ending):
    still = plan_joint(rover, [rover.ready], limits=RATES)
    assert load_trajectory(rover, save_trajectory(still, tmp_path / f"still{ending}", arm=rover)).duration == 0.0


def test_a_file_for_the_firmware_alone(tmp_path):
    arm, planned = with_motors()
    path = save_trajectory(planned, tmp_path / "firmware.csv", dt=0.05, counts=True)
    whole = save_trajectory(planned, tmp_path / "whole.csv", dt=0.05)
    with path.open(newline="") as counted, whole.open(newline="") as every:
        ours, theirs = csv.DictReader(counted), csv.DictReader(every)
        rows = list(ours)
        assert [{name: row[name] for name in ours.fieldnames} for row in theirs] == rows
    assert list(rows[0])[:3] == ["time [s]", "shoulder.counts [deg]", "shoulder.counts_rate [deg/s]"]
    with pytest.raises(InputError, match="the motors .* do not determine joint 'slide'"):
        load_trajectory(arm, path)
    with pytest.raises(InputError, match="this trajectory knows no motors"):
        save_trajectory(plain(planned), tmp_path / "none.csv", counts=True)
    assert not (tmp_path / "none.csv").exists()


def test_counts_are_read_back_where_the_motors_drive_every_joint(tmp_path):
    arm, _ = with_motors()
    G = np.diag([300.0, 100.0, -50.0, 60.0, 60.0])
    G[3, 4], G[4, 3] = 60.0, -60.0
    units, ticks = ("mm", "deg", "turn", "tick", "tick"), np.array([np.nan] * 3 + [4096, 1024])
    every = Actuators(("lift", "a", "b", "left", "right"), arm.joint_names, G, np.arange(5.0), units, ticks)
    arm = replace(arm, actuators=every)
    planned = plan_joint(arm, [arm.ready, arm.random_theta(2)], limits=RATES)
    read = load_trajectory(arm, save_trajectory(planned, tmp_path / "counts.csv", dt=0.05, counts=True))
    assert_allclose(read(read.times), planned(read.times), atol=1e-12)
    assert_allclose(read(read.times, 1), planned(read.times, 1), atol=1e-12)


def test_what_others_write(rover, tmp_path):
    """A message as `ros2 topic echo` prints it, and MoveIt's: another order, a gripper too, no velocities."""
    names = [*reversed(rover.joint_names), "gripper"]
    given = [*reversed(rover.ready.tolist()), 0.5]
    text = ["header:", "  stamp: {sec: 0, nanosec: 0}", "  frame_id: ''", "joint_names:", *(f"- {n}" for n in names)]
    for sec, more in ((1, 0.0), (2, 0.1), (4, 0.4)):
        text += ["points:"] if sec == 1 else []
        text += ["- positions:", *(f"  - {value + more}" for value in given), "  velocities: []", "  effort: []"]
        text += ["  time_from_start:", f"    sec: {sec}", "    nanosec: 500000000"]
    path = tmp_path / "echo.yaml"
    for lines in (text, ["joint_trajectory:", *(f"  {line}" for line in text)]):
        path.write_text("\n".join([*lines, "---", ""]))
        read = load_trajectory(rover, path)
        assert read.times.tolist() == [0.0, 1.0, 3.0]
        assert_allclose(read([0.0, 0.5, 2.0, 3.0]), rover.ready + np.array([[0.0], [0.05], [0.25], [0.4]]), atol=1e-12)
        assert "positions alone" in read.notes[0]


def changed(file, change):
    lines = change(file.read_text("utf-8").splitlines())
    copy = file.with_name(f"changed{file.suffix}")
    copy.write_text("\n".join(lines) + "\n", "utf-8")
    return copy


def line(number, change):
    return lambda lines: [change(text) if k == number else text for k, text in enumerate(lines, 1)]


BAD_CSV = {
    "no header": (
        lambda lines: lines[1:],
        "line 1: it has no 'time \\[s\\]'; a motion of rover_arm has each column once",
    ),
    "another arm": (
        line(1, lambda text: re.sub(r"\w+\.pos", "joint.pos", text)),
        "another arm.* rover_arm has 'slide'",
    ),
    "degrees": (line(1, lambda text: text.replace("elbow.position [rad]", "elbow.position [deg]")), "closest: 'elbow"),
    "short": (line(7, lambda text: text.rsplit(",", 1)[0]), "line 7: 15 values"),
    "word": (line(7, lambda text: "soon" + text[text.index(",") :]), "line 7: column 1"),
    "a picosecond": (line(7, lambda text: "0.080000000001" + text[text.index(",") :]), "line 7: time must increase"),
    "so fast": (
        line(7, lambda text: ",".join([*text.split(",")[:15], "1e300", *text.split(",")[16:]])),
        "line 7: no arm moves so far or so fast; got",
    ),
    "beyond": (line(7, lambda text: ",".join([text.split(",")[0], "9", *text.split(",")[2:]])), "joint 'slide' at 9 m"),
    "times in ms": (
        lambda lines: lines[:1] + [f"{1e3 * float(row.split(',')[0])},{row.partition(',')[2]}" for row in lines[1:]],
        "velocities mean .* times the change of the positions: check the unit of the times",
    ),
    "no line": (lambda lines: lines[:1], "holds no point of a motion"),
}


@pytest.mark.parametrize(("change", "why"), BAD_CSV.values(), ids=list(BAD_CSV))
def test_a_bad_line_is_told(rover, motion, tmp_path, change, why):
    file = save_trajectory(replace(motion, labels=()), tmp_path / "a.csv", dt=0.02)
    with pytest.raises((InputError, LimitError), match=why) as caught:
        load_trajectory(rover, changed(file, change))
    assert "changed.csv" in str(caught.value)


def test_a_motion_that_would_swing_beyond_a_limit_between_its_points_is_refused(rover, tmp_path):
    """From rest up to the elbow's limit at speed: the cubic between these points goes beyond it."""
    top = rover.limits.upper[2]
    joints = zip(rover.joint_names, rover.units, strict=True)
    rows = ["time [s]," + ",".join(f"{name}.position [{unit}],{name}.velocity [{unit}/s]" for name, unit in joints)]
    for time, (elbow, speed) in enumerate([(top - 0.5, 0.0), (top - 0.1, 0.8), (top - 0.1, -0.8), (top - 0.5, 0.0)]):
        rows.append(f"{time},0,0,0,0,{elbow},{speed},0,0,0,0")
    (tmp_path / "swing.csv").write_text("\n".join(rows) + "\n")
    with pytest.raises(LimitError, match=r"swing.csv: .*joint 'elbow' would swing to"):
        load_trajectory(rover, tmp_path / "swing.csv")


def at(*path, value=None):
    """A change of a message: what stands at `path` becomes `value`, or goes where there is none."""

    def change(message):
        *way, last = path
        for key in way:
            message = message[key]
        if value is None:
            del message[last]
        else:
            message[last] = value

    return change


BAD_MESSAGES = {
    "a name": (at("joint_names", 2, value="ellbow"), "have no 'elbow'; closest: 'ellbow'; "),
    "a typo": (lambda m: m.update(point=m.pop("points")), "unknown entry 'point' in Joint.*; closest: 'points'"),
    "no point": (at("points", 3, value=7), r"points\[3\] must be a table with positions, time_from_start"),
    "no position": (at("points", 3, "positions"), r"points\[3\] needs 'positions'; it has "),
    "a standstill": (at("points", 3, "time_from_start", value={"sec": 0, "nanosec": 0}), r"points\[3\]: time must in"),
    "half a second": (at("points", 3, "time_from_start", "sec", value=0.5), r"points\[3\].*\.sec must be a whole"),
    "beyond": (at("points", 3, "positions", 0, value=9.0), r"points\[3\]: joint 'slide' at 9 m is"),
    "a late label": (at("labels", 0, "time", value=99.0), "the times of labels must not decrease"),
    "no label": (at("labels", 0, "text"), r"labels\[0\] needs 'text'"),
}


@pytest.mark.parametrize(("change", "why"), BAD_MESSAGES.values(), ids=list(BAD_MESSAGES))
def test_a_bad_message_is_told(rover, motion, tmp_path, change, why):
    message = json.loads(save_trajectory(motion, tmp_path / "a.json", dt=0.1).read_text())
    change(message)
    for ending, write in ((".json", json.dumps), (".yaml", yaml.safe_dump)):
        path = tmp_path / f"changed{ending}"
        path.write_text(write(message))
        with pytest.raises((InputError, LimitError), match=why) as caught:
            load_trajectory(rover, path)
        assert f"changed{ending}" in str(caught.value)


FILES = {
    "none.csv": (None, "none.csv: no such file"),
    "binary.csv": (b"\xff\xfe\x00\x81\x00", "is no text"),
    "binary.yaml": (b"\xff\xfe\x00\x81\x00", "binary.yaml: "),
    "torn.json": (b'{"joint_names": [\n"a",', "torn.json is no JSON: .* line 2 column"),
    "torn.yaml": (b"joint_names: [\n'a',\npoints: {", r"torn.yaml:[34]: not usable YAML"),
    "nan.json": (b'{"points": [NaN]}', "numbers must be finite; got NaN"),
    "bomb.yaml": (b"a: &a [1]\nb: &b [*a, *a]\nc: !!python/object/apply:os.system [x]", "bomb.yaml:3"),
    "motion.txt": (b"", r"a motion is read from \*.csv, \*.json, \*.yaml, \*.yml, \*.mcap; got .*motion.txt"),
}


@pytest.mark.parametrize("name", FILES)
def test_files_that_are_none(rover, tmp_path, name):
    content, why = FILES[name]
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=why):
        load_trajectory(rover, tmp_path / name)


def test_counts_on_the_command_line(here, capsys):
    arguments = ["plan", "rover_arm", "--to", "zero", "--velocity", "1", "--acceleration", "1", "--counts"]
    assert run([*arguments, "-o", "motion.json"]) == 2
    assert "--counts goes with *.csv and *.h: a JointTrajectory is in rad and m" in capsys.readouterr().err
    assert run([*arguments, "-o", "motion.csv"]) == 2
    assert "[actuators.NAME]" in capsys.readouterr().err
    assert list(here.iterdir()) == []
