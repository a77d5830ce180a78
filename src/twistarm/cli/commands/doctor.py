"""`doctor`: faults of a description, their meaning and remedies."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, TextIO

import typer
from rich.table import Table

from ...checking.doctor import Diagnosis, examine
from ...checking.doctor.repair import COPY, Repair, repair
from ...checking.doctor.statements import summary
from ...checking.doctor.wording import codes_page
from ...description.findings import CODES, Finding
from ...description.findings import refused as refusal_of
from ...support.errors import InputError
from ...support.messages import plural
from ...support.path_redaction import without_places
from ..options import Json, takes_source
from ..output import console, finding_json, literal, print_json, say
from ..outputs import STDOUT, Force, Output, outputs_of
from ..wording import words

COLOURS = {"error": "bold red", "warning": "yellow", "info": "cyan"}


def _print_codes(wanted: bool) -> None:
    if wanted:
        say(*codes_page().splitlines())
        raise typer.Exit


Strict = Annotated[bool, typer.Option("--strict", help="Exit with 1 for warnings too.")]
Fix = Annotated[
    bool, typer.Option("--fix", help="Write a copy with the safe repairs made, to -o FILE.urdf; the original stays.")
]
Codes = Annotated[
    bool,
    typer.Option("--codes", is_eager=True, callback=_print_codes, help="List the codes of all findings, in Markdown."),
]


@takes_source
def doctor(
    source: str,
    load: dict[str, Any],
    strict: Strict = False,
    fix: Fix = False,
    output: Output = None,
    force: Force = False,
    codes: Codes = False,
    json: Json = False,
) -> int:
    """List faults of a description or an arm, their meaning and remedies."""
    if fix != (output is not None):
        raise InputError("--fix and -o FILE.urdf go together: the repaired copy gets that name")
    diagnosis = examine(source, **load)
    # A file that does not exist is the caller's error, not the doctor's business.
    if any(one.code == "file-not-found" and one.place.file == source for one in diagnosis.findings):
        raise refusal_of(diagnosis.findings)
    made = None
    if output is not None and diagnosis.description is not None:
        made = repair(diagnosis.description, COPY if output == STDOUT else output)
    outputs = outputs_of(output, {"urdf": (".urdf",)}, force=force, json=json, over_description=True)
    if made is not None:
        outputs.write({"urdf": lambda: made.text})
    if json:
        print_json(_as_json(source, diagnosis, output, made))
    else:
        _print(source, diagnosis, outputs.words)
        _print_repair(output, made, outputs.words)
    return 0 if _good(diagnosis, strict) and (output is None or made is not None) else 1


def _good(diagnosis: Diagnosis, strict: bool) -> bool:
    return diagnosis.worst not in (("error", "warning") if strict else ("error",))


def _print(source: str, diagnosis: Diagnosis, words: TextIO) -> None:
    out = console(words)
    out.print(f"[bold]{literal(_name(source, diagnosis))}[/bold]: {literal(_abilities(diagnosis))}")
    if diagnosis.findings:
        out.print(_page(diagnosis))
    out.print(counted(diagnosis.findings))


def _name(source: str, diagnosis: Diagnosis) -> str:
    known = diagnosis.arm or diagnosis.description
    return known.name if known else source


def _abilities(diagnosis: Diagnosis) -> str:
    arm, able = diagnosis.arm, diagnosis.able
    if arm is None or able is None:
        return "no arm until the errors below are mended"
    return f"{plural(arm.n, 'joint')} from {arm.base} to {arm.tip}; {summary(arm, able)}"


def _page(diagnosis: Diagnosis) -> Table:
    page = Table(show_header=False, show_lines=True)
    page.add_column(no_wrap=True)
    page.add_column(overflow="fold")
    for one in diagnosis.findings:
        colour = COLOURS[one.severity]
        place, what = (literal(text) for text in (str(one.place), words(one.what)))
        # A remedy may be lines of an arm.toml, in which names stand as TOML quotes them.
        remedy = "\n".join(literal(line) for line in words(one.remedy).split("\n"))
        said = [f"[dim]{place}[/dim]", what, f"→ {remedy}" if remedy else ""]
        page.add_row(f"[{colour}]{one.severity}[/{colour}]\n{one.code}", "\n".join(part for part in said if part))
    return page


def counted(findings: tuple[Finding, ...]) -> str:
    """`1 warning, 3 remarks`."""
    words = {"error": "error", "warning": "warning", "info": "remark"}
    numbers = {word: sum(one.severity == severity for one in findings) for severity, word in words.items()}
    return ", ".join(plural(n, word) for word, n in numbers.items() if n) or "nothing to remark"


def _print_repair(output: str | None, made: Repair | None, words: TextIO) -> None:
    if output is None:
        return
    if made is None:
        say(f"{output} not written: mend the errors above first", file=words)
        return
    for change in made.changes:
        say(f"repaired: {change}", file=words)
    complaint = f"Pinocchio's own parser does not read it: {made.complaint}"
    reads = complaint if made.complaint else "Pinocchio's own parser reads it"
    same = "the same links, joints, limits and poses"
    n = len(made.changes)
    repairs = plural(n, "repair") if n else "nothing to repair"
    say(f"written: {output} ({repairs}; {same}; {reads})", file=words)


def _as_json(source: str, diagnosis: Diagnosis, output: str | None, made: Repair | None) -> dict[str, Any]:
    arm, able = diagnosis.arm, diagnosis.able
    content: dict[str, Any] = {
        "source": without_places(source, Path(source)),
        "arm": _name(source, diagnosis),
        "n": arm and arm.n,
        "directions": able and {"position": able.position, "rotation_in_place": able.turning},
        "findings": [finding_json(one) | {"meaning": CODES[one.code].meaning} for one in diagnosis.findings],
    }
    if made is not None:
        content |= {"written": [output], "repairs": made.changes, "pinocchio_complaint": made.complaint}
    return content
