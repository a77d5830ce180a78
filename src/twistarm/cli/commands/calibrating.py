"""`wiring` and `calibrate`: an arm's motors, axes and zeros against a log of measurements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from ...arm.arm import Arm
from ...calibration import Calibration, HandEye, check_wiring, corrected_urdf
from ...calibration import calibrate as fit
from ...support.errors import InputError
from ..numbers import LENGTH, argument, option, quantity, switch, typed_number, whole
from ..options import ArmArgument, Avoid, Json, answers, avoided
from ..output import Contents, Outputs, entries, plain, warn
from ..tables import Column, Table

Log = Annotated[Path, argument("LOG", "CSV: a column per motor, x, y, z [m], and qx, qy, qz, qw if measured.")]
PositionNoise = Annotated[float, quantity("m", "Standard deviation of the measured positions.")]
OrientationNoise = Annotated[float, quantity("rad", "Standard deviation of the measured orientations [°].")]
BasePositionNoise = Annotated[float, quantity("m", "The same of the base's own; 0 if exactly known.", zero=True)]
BaseOrientationNoise = Annotated[
    float, quantity("rad", "The same of the base's own [°]; 0 if exactly known.", zero=True)
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
    base_position_noise: BasePositionNoise = 0.01,
    base_orientation_noise: BaseOrientationNoise = 2.0,
) -> int:
    """Check signs, ratios and zeros of the motors against logged counts and measured tool positions."""
    report = check_wiring(
        source.load(), log, position_noise=position_noise, orientation_noise=orientation_noise,
        base_position_noise=base_position_noise, base_orientation_noise=base_orientation_noise,
    )  # fmt: skip
    off = f"{1000 * report.before:.1f} mm as the arm.toml says, {1000 * report.after:.1f} mm as found here"
    lines = [
        f"rows: {report.rows}; measured against computed: {off}",
        *(f"{motor.name}: {'; '.join(filter(None, (motor.verdict, motor.what, motor.remedy)))}"
          for motor in report.motors),
        f"{report.verdict}: {report.what}",
    ]  # fmt: skip
    out.show(plain(report) | {"ok": report.ok}, *lines)
    return 0 if report.ok else 1


def _hand_eye(found: HandEye) -> Iterator[str]:
    """How certain camera and tag are, and the text to paste."""
    sides = ("camera", found.parent, found.camera_std), ("tag", found.tag_parent, found.tag_std)
    for name, parent, (shift, turn) in sides:
        known = f"± {1e3 * shift:.2g} mm, {np.degrees(turn):.2g}°" if np.isfinite(shift + turn) else "not determined"
        yield f"{name} in {parent}: {known}"
    if not found.determined:
        yield "warning: this log does not determine camera and tag to 3 mm and 0.6°: measure more rows, turned more"
    whose = "the corrected arm" if found.corrected else "the arm as described"
    shift, turn = found.residual
    yield f"residual of the tag in the camera, median: {1e3 * shift:.2g} mm and {np.degrees(turn):.2g}°; with {whose}"
    yield from found.urdf.splitlines() if found.determined else ()


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
    found = fit(
        arm, logs, base="held" if base_held else "fit", tool="held" if tool_held else "fit", scales=scales,
        position_noise=position_noise, orientation_noise=orientation_noise, camera=camera, tag_size=tag_size,
        corner_noise=corner_noise, distances=dict(map(_distance, distance or ())), distance_noise=distance_noise,
    )  # fmt: skip
    more = found.next_postures(next_postures, scene=avoided(arm, avoid)) if next_postures else np.empty((0, arm.n))
    names = "base tool expected held_out held_out_before confirmed confirmed_here sound outliers warnings"
    means = {"before": float(found.before.mean()), "after": float(found.after.mean())}
    estimates = [entries(estimate, "value std seen") | estimate.parameter._asdict() for estimate in found.estimates]
    data = {"arm": found.arm.name} | means | entries(found, names)
    eye = found.hand_eye
    data |= {"estimates": estimates, "next": more, "hand_eye": None if eye is None else plain(eye) | {"urdf": eye.urdf}}
    # The answer comes before the files, which a correction that is not confirmed does not get.
    replace(outputs, files=()).show(data, *_parts(found, arm, more))
    # A refusal would repeat the last line above.
    if found.confirmed or (outputs.force and found.confirmed_here):
        outputs.say(outputs.write(_contents(found, outputs)))
    elif outputs.files:
        warn("no file is written")
    # Camera and tag are found without a corrected arm too.
    seen = eye is not None and eye.determined and not found.faults
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


def _distance(typed: str) -> tuple[tuple[str, str], float]:
    a, b, length, *more = [*typed.split("="), "", ""]
    value = typed_number(length, LENGTH)
    if len(more) != 2 or not np.isfinite(value):
        raise InputError(f"--distance takes A=B=LENGTH, as in left=right=0.05 or left=right=50mm; got {typed!r}")
    return (a, b), value


def _parts(found: Calibration, arm: Arm, more: Any) -> Iterator[Table | str]:
    """What people read: the corrections, where to measure next, the errors, and what is odd."""
    held = [str(estimate.parameter) for estimate in found.estimates if estimate.of_joint and not estimate.seen]
    yield f"held at 0, because others explain them in this log: {'; '.join(held) or 'none'}"
    if not found.faults:
        yield from found.changes()
        if len(more):
            joints = (Column(*column) for column in zip(arm.joint_names, more.T, arm.units, strict=True))
            yield Table("to measure next", [Column("", range(1, len(more) + 1)), *joints])
        before, after = 1000 * float(found.before.mean()), 1000 * float(found.after.mean())
        yield f"mean error [mm]: {before:.3g} with base and tool alone, {after:.3g} corrected"
        yield f"on rows left out: {1000 * found.held_out_before:.3g} and {1000 * found.held_out:.3g}"
        yield from _hand_eye(found.hand_eye) if found.hand_eye is not None else ()
    if found.outliers:
        yield f"rows that do not fit: {', '.join(found.problem.log.label[row - 1] for row in found.outliers)}"
    yield from (f"warning: {warning}" for warning in found.warnings if warning not in found.faults)
    here = "confirmed only where the log was taken (--force writes it)" if found.confirmed_here else "not confirmed"
    sound = "confirmed: the arm needs no correction" if found.sound else "confirmed"
    yield sound if found.confirmed else f"{here}: {found.why_not}"
