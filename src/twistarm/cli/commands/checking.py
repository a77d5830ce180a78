"""`doctor`, `check`, `freeze` and `collisions`: what is wrong with an arm, and what has changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import RenderableType
from rich.padding import Padding
from rich.text import Text

from ...checking.crosscheck import CrossCheck, crosscheck
from ...checking.difference import NOT_COVERED, compare, golden_text
from ...checking.doctor import examine
from ...checking.doctor.arm_checks import summary
from ...checking.doctor.repair import COPY, repair
from ...collision import Scene
from ...collision.survey import srdf_text, survey
from ...description.findings import CODES, Finding, codes_page
from ...description.findings import refused as refusal_of
from ...support.errors import InputError, printable, without_places
from ...support.messages import plural
from ..numbers import option, quantity, switch, whole
from ..options import ArmArgument, Json, SceneFile, answers
from ..output import STDOUT, Outputs, entries, note, plain, progress_bar, say
from ..tables import Column, Table, theta_values, unit_text
from ..wording import words


def _print_codes(wanted: bool) -> None:
    if wanted:
        say(*codes_page().splitlines())
        raise typer.Exit


Strict = Annotated[bool, switch("Exit with 1 for warnings too.", "--strict")]
Fix = Annotated[bool, switch("Write a copy with the safe repairs made, to -o FILE.urdf; the original stays.", "--fix")]
Codes = Annotated[
    bool, switch("List the codes of all findings, in Markdown.", "--codes", is_eager=True, callback=_print_codes)
]


Repaired = Annotated[Outputs, answers("output force json", {"urdf": (".urdf",)}, over_description=True)]


def doctor(source: ArmArgument, out: Repaired, strict: Strict = False, fix: Fix = False, codes: Codes = False) -> int:
    """List faults of a description or an arm, their meaning and remedies."""
    if fix != (len(out.files) == 1):
        raise InputError("--fix and -o FILE.urdf go together: the repaired copy gets that name")
    diagnosis = examine(source.name, **source.keywords) if source.tool is None else examine(source.load())
    findings, arm, able = diagnosis.findings, diagnosis.arm, diagnosis.able
    # A file that does not exist is the caller's error, not the doctor's business.
    if any(finding.code == "file-unreadable" and finding.place.file == source.name for finding in findings):
        raise refusal_of(findings)
    known = arm or diagnosis.description
    name = known.name if known else source.name
    data: dict[str, Any] = {
        "source": without_places(source.name, Path(source.name)),
        "arm": name,
        "n": arm and arm.n,
        "directions": able and {"position": able.position, "rotation_in_place": able.turning},
        "findings": [plain(finding) | {"meaning": CODES[finding.code].meaning} for finding in findings],
    }
    does = "it cannot be loaded until the errors below are fixed"
    if arm is not None and able is not None:
        does = f"{plural(arm.n, 'joint')} from {arm.base} to {arm.tip}; {summary(arm, able)}"
    words_of = {"error": "error", "warning": "warning", "info": "remark"}
    numbers = {word: sum(finding.severity == severity for finding in findings) for severity, word in words_of.items()}
    counted = ", ".join(plural(n, word) for word, n in numbers.items() if n) or "nothing to remark"
    parts: list[Any] = [f"{name}: {does}", *_paragraphs(findings), counted]
    contents: dict[str, Callable[[], str]] | None = None
    for _, file in out.files:
        if diagnosis.description is None:
            parts.append(f"{file} not written: fix the errors above first")
            continue
        made = repair(diagnosis.description, COPY if file == STDOUT else file)
        reads = f"does not read it: {made.complaint}" if made.complaint else "reads it"
        parts += [f"repaired: {change}" for change in made.changes]
        parts.append(f"the same links, joints, limits and poses; Pinocchio's own parser {reads}")
        data |= {"repairs": made.changes, "pinocchio_complaint": made.complaint}
        contents = {"urdf": partial(str, made.text)}
    out.show(data, *parts, files=contents)
    good = diagnosis.worst not in (("error", "warning") if strict else ("error",))
    return 0 if good and bool(out.files) == (contents is not None) else 1


def _paragraphs(findings: Sequence[Finding]) -> Iterator[RenderableType]:
    """Severity, code and place of each finding, then what and the remedy."""
    colours = {"error": "bold red", "warning": "yellow", "info": "cyan"}
    for one in findings:
        head = (one.severity, colours[one.severity]), f" {one.code}  ", (printable(str(one.place)), "dim")
        yield Text.assemble(*head)
        # A remedy may be lines of an arm.toml.
        remedy = f"→ {words(one.remedy)}".split("\n") if one.remedy else []
        lines = [words(one.what), *remedy]
        yield Padding(Text("\n".join(map(printable, lines))), (0, 0, 0, 4), expand=False)


Samples = Annotated[int, whole(1, 1_000_000, "Random configurations to look at.")]
Against = Annotated[str | None, option("FILE", "Report differences from a golden file, a baked arm or another ARM.")]


def check(source: ArmArgument, out: Json, samples: Samples = 1000, against: Against = None) -> int:
    """Compare product of exponentials, Pinocchio and yourdfpy; --against lists changes."""
    arm = source.load()
    difference = None if against is None else compare(arm, against)
    with progress_bar("cross-check") as progress:
        result = crosscheck(arm, samples, progress=progress)
    good = result.ok and (difference is None or difference.same)
    data = {"arm": result.arm, "ok": good}
    if difference is None:
        lines = [verdict(result)]
    else:
        data |= {"unchanged": difference.same, "not_covered": NOT_COVERED}
        data |= entries(difference, "changes notes pose_error jacobian_error")
        # A .json is the arm as it was; anything else is another arm.
        since = str(against).endswith(".json")
        same, other = ("unchanged since", "CHANGED since") if since else ("the same as", "DIFFERENT from")
        lines = [f"{verdict(result)}; {same if difference.same else other} {against}"]
        lines += [f"{'changed' if since else 'different'}: {change}" for change in difference.changes]
    out.show(data, *lines, *comparisons(result))
    for remark in difference.notes if difference else ():
        note(remark)
    return 0 if good else 1


def verdict(result: CrossCheck) -> str:
    """What the rows come to, in one line."""
    silent = [engine for engine in result.left_out if engine in ("pinocchio", "yourdfpy", "mujoco")]
    agree = f"the engines agree, but {' and '.join(silent)} compared nothing" if silent else "all engines agree"
    return f"{result.arm}: {agree if result.ok else 'THE ENGINES DISAGREE'}"


def comparisons(result: CrossCheck) -> tuple[Table | str, ...]:
    """The comparisons, and what could not be compared."""
    rows = result.comparisons
    columns = [
        Column("quantity", [row.quantity for row in rows]),
        Column("engines", [row.engines for row in rows]),
        Column("worst", [row.worst for row in rows], text=[f"{row.worst:.1e}" for row in rows]),
        Column("tolerance", [row.tolerance for row in rows], text=[f"{row.tolerance:.0e}" for row in rows]),
        Column("samples", [row.samples for row in rows]),
        Column("ok", [row.ok for row in rows], text=["ok" if row.ok else "WRONG" for row in rows]),
        Column("not compared", [row.not_compared for row in rows], people=False),
    ]
    compared = [i for i, row in enumerate(rows) if not row.not_compared]
    left_out = [row for row in rows if row.not_compared]
    lines = (f"not compared: {row.quantity} ({', '.join(row.engines)}): {row.not_compared}" for row in left_out)
    legend = (
        "engines: poe = product of exponentials, core = the same compiled, walk and tree = our reader, "
        "as written = of the file before repairs"
    )
    return Table("", columns, "comparisons", rows=compared), legend, *lines


Golden = Annotated[Outputs, answers("output force", {"json": (".json",)})]


def freeze(source: ArmArgument, out: Golden) -> None:
    """Write a golden file: names, screws, home, limits, motors and masses."""
    arm = source.load()
    out = out if out.files else out.named(f"{Path(arm.name).name}.golden.json")
    for name in out.write({"json": lambda: golden_text(arm)}):
        if name != STDOUT:
            later = f"later, with the same ARM and options: twistarm check … --against {name}"
            say(f"{name}: {arm.name} frozen; {later}", f"not covered: {', '.join(NOT_COVERED)}")


Margin = Annotated[float, quantity("m", "Distance below which a pair collides.", zero=True)]
Srdf = Annotated[Outputs, answers("output force rad json", {"srdf": (".srdf",)}, over_description=True)]


def collisions(
    source: ArmArgument, out: Srdf, scene: SceneFile = None, margin: Margin = 0.0, samples: Samples = 2000
) -> None:
    """List which pairs of links are not checked and why, and which collide; -o ARM.srdf writes the former."""
    arm = source.load()
    with progress_bar("allowed pairs") as progress:
        if scene is None:
            made = Scene(arm, margin=margin, progress=progress)
        else:
            made = Scene.load(arm, scene, margin=margin or None, progress=progress)
        made.find_allowed_pairs()
    with progress_bar("configurations") as progress:
        found = survey(made, samples, progress=progress)
    allowed = [{"links": pair, "reason": reason} for pair, reason in made.allowed.items()]
    lines = [f"{arm.name}: {len(allowed)} pairs of links are not checked"]
    for reason in dict.fromkeys(made.allowed.values()):
        pairs = [" – ".join(pair) for pair, why in made.allowed.items() if why == reason]
        lines.append(f"{reason}: {', '.join(pairs)}")
    lines.append("Default: collide at zero or ready. Always: nearly everywhere. Never: in no random configuration.")
    lines.append(f"collides in {100.0 * found.share:.1f} % of {found.samples} random configurations")
    columns = [
        Column("links", [pair.links for pair in found.pairs]),
        Column("share", [pair.share for pair in found.pairs], text=[f"{pair.share:.1%}" for pair in found.pairs]),
        Column("theta", [pair.theta for pair in found.pairs],
               text=[theta_values(arm, pair.theta, out.radians, digits=3) for pair in found.pairs]),
    ]  # fmt: skip
    heads = (f"{name} [{unit_text(unit, out.radians)}]" for name, unit in zip(arm.joint_names, arm.units, strict=True))
    order = f"examples as in --theta: {', '.join(heads)}"
    out.show(
        {"arm": arm, "allowed": allowed, "samples": found.samples, "share": found.share, "findings": made.findings},
        *lines,
        Table("pairs that collide", columns, "colliding"),
        *([order] if found.pairs else []),
        *(finding.text for finding in made.findings),
        files={"srdf": lambda: srdf_text(made)},
    )
