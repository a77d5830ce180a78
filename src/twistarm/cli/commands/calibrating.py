"""`wiring` and `calibrate`: an arm's motors, axes and zeros against a log of measurements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from ...arm.arm import Arm
from ...calibration import Calibration, HandEye, Residual, WiringReport, check_wiring, corrected_urdf
from ...calibration import calibrate as fit
from ...calibration.calibration import amount
from ...support.errors import InputError
from ...theory.rotations import to_rpy
from ..numbers import LENGTH, argument, option, quantity, switch, typed_number, whole
from ..options import ArmArgument, Avoid, Json, answers, avoided
from ..output import Contents, Outputs, entries, plain, warn
from ..tables import Column, Table, number

Log = Annotated[Path, argument("LOG", "CSV: a column per motor, x, y, z [m], and qx, qy, qz, qw if measured.")]
PositionNoise = Annotated[float, quantity("m", "Standard deviation of the measured positions.")]
OrientationNoise = Annotated[float, quantity("rad", "Standard deviation of the measured orientations [°].")]
BasePositionNoise = Annotated[
    float | None, quantity("m", "Standard deviation of the base's own position; 0 if exactly known.", zero=True)
]
BaseOrientationNoise = Annotated[
    float | None,
    quantity("rad", "Standard deviation of the base's own orientation [°]; 0 if exactly known.", zero=True),
]
Logs = Annotated[
    list[Path],
    argument(
        "LOG…", "CSV: a column per joint, then x, y, z, or rx … tz of solvePnP, or point, plane, wire and length."
    ),
]
HeldBase = Annotated[bool, switch("Positions are in the base frame; do not fit it.", "--base-held")]
HeldTool = Annotated[bool, switch("The measured point is the tip; do not fit it.", "--tool-held")]
Distance = Annotated[list[str] | None, option("A=B=LENGTH", "A known distance of two points; may be repeated.")]
DistanceNoise = Annotated[float, quantity("m", "Standard deviation of the known distances.")]
Mount = Annotated[
    Literal["tool", "base"] | None,
    option(
        "tool|base", "Hand-eye calibration: the camera is on the tool (eye-in-hand), or beside the arm (eye-to-hand)."
    ),
]
TagSize = Annotated[float | None, quantity("m", "Side of the tag, as solvePnP had it.")]
CornerNoise = Annotated[
    float, quantity("rad", "Standard deviation of a tag's corner in the image [°]: pixels over the focal length.")
]
Scales = Annotated[bool, switch("Fit a scale of each joint too.", "--scales")]
Next = Annotated[int, whole(0, 1000, "Name N configurations to measure next.", "--next")]
Written = Annotated[
    Outputs,
    answers(
        "output force json",
        {"urdf": (".urdf",), "toml": (".toml",)},
        output="The corrected description (*.urdf), or the motors' offsets for arm.toml (*.toml). "
        "With a toml the zeros are not in the urdf; repeat it.",
        force="Replace files that are there; write what is confirmed only where the log was taken.",
    ),
]


def wiring(
    source: ArmArgument,
    log: Log,
    out: Json,
    position_noise: PositionNoise = 0.002,
    orientation_noise: OrientationNoise = 1.0,
    base_position_noise: BasePositionNoise = None,
    base_orientation_noise: BaseOrientationNoise = None,
) -> int:
    """Check signs, ratios and zeros of the motors against logged counts and measured tool positions."""
    arm = source.load()
    noise: dict[str, Any] = {
        "position_noise": position_noise, "orientation_noise": orientation_noise,
        "base_position_noise": base_position_noise, "base_orientation_noise": base_orientation_noise,
    }  # fmt: skip
    report = check_wiring(arm, log, **noise)
    before, after = _residual(report.before), _residual(report.after)
    rows = "1 row" if report.rows == 1 else f"{report.rows} rows"
    faults = [motor for motor in report.motors if motor.verdict != "sound" and motor.what]
    lines = [
        f"{rows}; measured against computed: {before} as the arm.toml says, {after} as found here",
        *(f"{motor.name}: {'; '.join(filter(None, (motor.what, motor.remedy)))}" for motor in faults),
        f"{report.verdict}: {report.what}",
    ]
    out.show(plain(report) | {"ok": report.ok}, _motors_table(arm, report), *lines)
    return 0 if report.ok else 1


def _motors_table(arm: Arm, report: WiringReport) -> Table:
    motors, units = report.motors, dict(zip(arm.joint_names, arm.units, strict=True))
    # A question mark: the fault may be another motor's.
    verdicts = [
        ", ".join(motor.faults) + "?" * (motor.verdict == "possible fault") or motor.verdict for motor in motors
    ]
    times = [
        f"{number(motor.scale)} ± {f'{motor.scale_std:.1g}' if np.isfinite(motor.scale_std) else '?'}"
        for motor in motors
    ]
    added = [
        ", ".join(f"{joint} {amount(x, units[joint])}" for joint, x in motor.joint_offset.items()) for motor in motors
    ]
    named = {"motor": [motor.name for motor in motors], "verdict": verdicts, "readings times": times}
    columns = [Column(head, each) for head, each in (named | {"added to the joints": added}).items()]
    return Table(f"{report.arm}: its motors, and what fits the log", columns)


def _hand_eye(found: HandEye) -> Iterator[str]:
    """Camera and tag, how certain they are, and the text to paste."""
    poses = (
        ("camera", found.camera, found.parent, found.camera_std),
        ("tag", found.tag, found.tag_parent, found.tag_std),
    )
    for name, pose, parent, (shift, turn) in poses:
        place, rpy = (", ".join(f"{x:.{n}f}" for x in v + 0.0)
                      for n, v in ((1, 1e3 * pose[:3, 3]), (2, np.degrees(to_rpy(pose[:3, :3])))))  # fmt: skip
        known = f"± {1e3 * shift:.2g} mm, {np.degrees(turn):.2g}°" if np.isfinite(shift + turn) else "not determined"
        yield f"{name} in {parent}: {place} mm; rpy {rpy}° ({known})"
    if not found.determined:
        yield "warning: this log does not determine camera and tag to 3 mm and 0.6°: measure more rows, turned more"
    whose = "the corrected arm" if found.corrected else "the arm as described"
    shift, turn = found.residual
    yield f"residual of the tag in the camera, median: {1e3 * shift:.2g} mm and {np.degrees(turn):.2g}°; with {whose}"
    yield from found.urdf.splitlines() if found.determined else ()


def _residual(residual: Residual) -> str:
    position = f"{1000 * residual.position:.1f} mm"
    return position if residual.rotation is None else f"{position} and {np.degrees(residual.rotation):.2f}°"


def calibrate(
    source: ArmArgument,
    logs: Logs,
    outputs: Written,
    position_noise: PositionNoise = 1e-4,
    orientation_noise: OrientationNoise = 0.06,
    base_held: HeldBase = False,
    tool_held: HeldTool = False,
    distance: Distance = None,
    distance_noise: DistanceNoise = 1e-4,
    camera: Mount = None,
    tag_size: TagSize = None,
    corner_noise: CornerNoise = 0.046,
    scales: Scales = False,
    next_postures: Next = 0,
    avoid: Avoid = None,
) -> int:
    """Fit the arm's axes and zeros to measured positions of its tool. With --camera: hand-eye calibration."""
    arm = source.load()
    noise: dict[str, Any] = {
        "position_noise": position_noise,
        "orientation_noise": orientation_noise,
        "distance_noise": distance_noise,
    }
    frames: dict[str, Any] = {"base": "held" if base_held else "fit", "tool": "held" if tool_held else "fit"}
    distances = dict(map(_distance, distance or ()))
    views: dict[str, Any] = {"camera": camera, "tag_size": tag_size, "corner_noise": corner_noise}
    found = fit(arm, logs, **noise, **frames, **views, distances=distances, scales=scales)
    more = found.next_postures(next_postures, scene=avoided(arm, avoid)) if next_postures else np.empty((0, arm.n))
    names = "base tool expected held_out held_out_before confirmed confirmed_here outliers warnings"
    means = {"before": float(found.before.mean()), "after": float(found.after.mean())}
    data = {"arm": found.arm.name} | means | entries(found, names) | {"next": more, "hand_eye": _seen(found)}
    # The answer comes before the files, which a correction that is not confirmed does not get.
    replace(outputs, files=()).show(data, *_parts(found, arm, more))
    # A refusal would repeat the last line above.
    if found.confirmed or (outputs.force and found.confirmed_here):
        outputs.say(outputs.write(_contents(found, outputs)))
    elif outputs.files:
        warn("no file is written")
    # Camera and tag are found without a corrected arm too.
    seen = found.hand_eye is not None and found.hand_eye.determined and not found.faults
    return 0 if found.confirmed or seen else 1


def _contents(found: Calibration, outputs: Outputs) -> Contents:
    """The corrected description, and the offsets of the motors. What the one corrects, the other must not."""
    origins_alone = any(kind == "toml" for kind, _ in outputs.files)
    return {
        "urdf": lambda: corrected_urdf(found, zeros=not origins_alone, here=outputs.force),
        "toml": lambda: "\n".join(
            f"[actuators.{name}]\noffset = {offset!r}\n"
            for name, offset in found.require(here=outputs.force).motor_offsets().items()
        ),
    }


def _seen(found: Calibration) -> dict[str, Any] | None:
    names = "camera camera_std parent tag tag_std tag_parent residual corrected xyz rpy urdf"
    return None if found.hand_eye is None else entries(found.hand_eye, names)


def _distance(typed: str) -> tuple[tuple[str, str], float]:
    a, b, length, *more = [*typed.split("="), "", ""]
    value = typed_number(length, LENGTH)
    if len(more) != 2 or not np.isfinite(value):
        raise InputError(f"--distance takes A=B=LENGTH, as in left=right=0.05 or left=right=50mm; got {typed!r}")
    return (a, b), value


def _parts(found: Calibration, arm: Arm, more: Any) -> Iterator[Table | str]:
    """What people read: the corrections, where to measure next, the errors, and what is odd."""
    estimates, sound = found.estimates, not found.faults
    held = [str(estimate.parameter) for estimate in estimates if estimate.of_joint and not estimate.seen]
    yield f"held at 0, because others explain them in this log: {'; '.join(held) or 'none'}"
    parameters, values, stds, seen = zip(*estimates, strict=True)
    units = [parameter.unit for parameter in parameters]
    columns = [
        Column("joint", [parameter.owner for parameter in parameters], key="owner"),
        Column("what", [parameter.what for parameter in parameters]),
        Column("value", values, text=[*map(amount, values, units)]),
        Column("±", stds, text=[*map(amount, stds, units)], key="std"),
        Column("unit", units, people=False),
        Column("seen", seen, people=False),
    ]
    rows = [i for i, estimate in enumerate(estimates) if estimate.of_joint and estimate.seen and sound]
    yield Table(f"{arm.name}: its corrections", columns, key="estimates", rows=rows)
    if len(more) and sound:
        joints = (Column(*column) for column in zip(arm.joint_names, more.T, arm.units, strict=True))
        yield Table("to measure next", [Column("", range(1, len(more) + 1)), *joints])
    if sound:
        before = [float(found.before.mean()), found.held_out_before]
        errors = {"base and tool alone": before, "corrected": [float(found.after.mean()), found.held_out]}
        means = [Column(name, [1e3 * metres for metres in each], digits=3) for name, each in errors.items()]
        yield Table("mean error [mm]", [Column("", ["all rows", "rows left out"]), *means])
    yield from _hand_eye(found.hand_eye) if found.hand_eye is not None and sound else ()
    if found.outliers:
        yield f"rows that do not fit: {', '.join(found.problem.log.label[row - 1] for row in found.outliers)}"
    yield from (f"warning: {warning}" for warning in found.warnings if warning not in found.faults)
    if found.confirmed_here and found.expected > 2.0 * found.held_out:
        far = f"elsewhere in reach expect {1000 * found.expected:.2g} mm"
        yield f"warning: {far}: measure at other configurations, as --next names them"
    here = "confirmed only where the log was taken (--force writes it)" if found.confirmed_here else "not confirmed"
    yield "confirmed" if found.confirmed else f"{here}: {found.why_not}"
