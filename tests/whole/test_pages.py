"""Every block in the README and in docs is executed, in the order in which a reader meets it, and every example."""

from __future__ import annotations

import inspect
import re
import runpy
import shlex
import shutil
import subprocess
import sys
from importlib import import_module
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import NamedTuple

import pytest

import twistarm
from needed import COMPILER, absent
from twistarm import stream
from twistarm.cli import application
from twistarm.design import parking

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]

NOT_RUN = {
    "serves": "waits for Ctrl-C",
    "installs": "changes the environment",
    "recurses": "runs the tests themselves",
    "another program": "is run by the tests of what it speaks to",
    "needs a browser": "is run by the tests of pictures",
}
"""Marks of blocks that are not run here, with the reason."""

# Kinds of blocks that are looked at, not run, unless a mark makes a file of them or an output.
FRAGMENTS = {"text", "toml", "xml", "cpp", "csv", "console"}


class Block(NamedTuple):
    mark: str
    kind: str
    text: str


FENCED = r"(?:^<!-- (?P<mark>[^>]+) -->\n)?^```(?P<kind>[^\n]*)\n(?P<text>.*?)^```$"
# A table whose last column says it in twistarm: each of its cells is a program.
COMPARED = r"^\|[^\n]*\| twistarm \|\n\|[-|]+\|\n(?P<rows>(?:\|[^\n]*\n)+)"


def blocks(page: Path) -> list[Block]:
    found = []
    for match in re.finditer(f"{FENCED}|{COMPARED}", page.read_text("utf-8"), flags=re.S | re.M):
        if match["rows"] is None:
            if not match["kind"].startswith("{"):  # a directive of the site's
                found.append(Block(match["mark"] or "", match["kind"], match["text"]))
        else:
            cells = [row.rsplit(" | ", 1)[1] for row in match["rows"].splitlines()]
            found += [Block("", "python", program) for cell in cells for program in re.findall(r"`([^`]+)`", cell)]
    return found


def laid_out(page: Path, folder: Path) -> None:
    """What the tour begins with: the reader's own arm in `my_arm/`, and the files that the page shows."""
    (folder / "my_arm").mkdir()
    for file in (ROOT / "robots" / "rover_arm").glob("*.xacro"):
        shutil.copy(file, folder / "my_arm" / file.name.replace("rover_arm.urdf", "my_arm.urdf"))
    for block in blocks(page):
        if block.mark.startswith("file "):
            (folder / block.mark.removeprefix("file ")).write_text(block.text, "utf-8")


def command(line: str, capsys: pytest.CaptureFixture[str]) -> str:
    """What a line that begins with `twistarm` prints, in this process: to start one takes longer than the command."""
    capsys.readouterr()
    program, *arguments = shlex.split(line, comments=True)
    assert program == "twistarm", f"a command the tests do not know: {line}"
    code, printed = application.run(arguments), capsys.readouterr()
    assert code == 0, f"{line}\n{printed.out}\n{printed.err}"
    return printed.out


def not_set_up() -> set[str]:
    """Modules of the extras that `make demo` does not install."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    (named,) = re.findall(r"tools/install.py (\S*guide\S*)$", (ROOT / "Makefile").read_text("utf-8"), flags=re.M)

    def packages(names: set[str]) -> set[str]:
        needed = [requirement for name in names for requirement in extras[name]]
        more = {
            extra for text in needed for inner in re.findall(r"^twistarm\[(.*)\]", text) for extra in inner.split(",")
        }
        plain = {re.split(r"[^\w.-]", text)[0].lower() for text in needed if not text.startswith("twistarm[")}
        return plain | (packages(more) if more else set())

    absent = packages({"all", "sweep"}) - packages(set(named.split(",")))
    return {module for module, owners in packages_distributions().items() if absent & {o.lower() for o in owners}}


# The language and its standard of a program that a page shows, by the kind of its block.
STANDARDS = {"cpp": ("c++", "c++17"), "c": ("c", "c99")}


def compiled(source: str, kind: str, said: str) -> None:
    """Compile and run a program that the page shows, with the headers in the folder that `bake` has named."""
    if not COMPILER:
        absent("no C++ compiler")
    include = said.split("-I ")[1].split()[0]
    language, standard = STANDARDS[kind]
    command = [COMPILER, "-x", language, f"-std={standard}", "-O0", "-I", include, source, "-o", "main"]
    subprocess.run(command, check=True, timeout=300)
    subprocess.run(["./main"], check=True, timeout=60)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_block_does_what_the_page_says(page, here, monkeypatch, capsys):
    laid_out(page, here)
    # A coarse search for a parking pose: tests/design and an example have the whole one.
    monkeypatch.setattr(parking, "POSES", 500)
    monkeypatch.setattr(parking, "CANDIDATES", 1)
    if page.name == "README.md":
        for module in not_set_up():  # what it shows works in what its set-up builds
            monkeypatch.setitem(sys.modules, module, None)
    names: dict[str, object] = {"__name__": "__main__"}
    said = ""
    for mark, kind, text in blocks(page):
        if mark in NOT_RUN:
            continue
        if mark == "output":
            line, _, shown = text.partition("\n")
            printed = command(line.removeprefix("$ "), capsys)
            assert [row.rstrip() for row in printed.splitlines()] == shown.splitlines()
        elif mark.startswith("file "):
            if kind in STANDARDS:
                compiled(mark.removeprefix("file "), kind, said)
            if kind == "matlab" and shutil.which("octave"):
                program = ["octave", "--no-gui", "--norc", "--quiet", mark.removeprefix("file ")]
                subprocess.run(program, check=True, timeout=120)
        elif kind == "python":
            exec(compile(text, str(page.relative_to(ROOT)), "exec"), names)
        elif kind == "sh":
            for row in text.splitlines():
                if row.strip() and not row.startswith("#"):
                    said += command(row, capsys)
        else:
            assert kind in FRAGMENTS, f"{page.name}: a block of the unknown kind {kind!r}"


def test_few_blocks_are_not_run():
    left_out = [block.mark for page in PAGES for block in blocks(page) if block.mark in NOT_RUN]
    assert len(left_out) <= 9, left_out


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_a_page_links_to_is_there(page):
    text = re.sub(r"```.*?^```$", "", page.read_text("utf-8"), flags=re.S | re.M)
    for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
        ours = re.fullmatch(r"https://[\w.]*github[\w.]*/twistarm/twistarm/(?:(?:blob|tree)/)?main/(.*)", target)
        if ours or not target.startswith("https://"):
            assert (ROOT / ours[1] if ours else page.parent / target).exists(), target


MODULES = ("", "screws", "joints", "poe", "rotations", "control.stream", "viewer", "calibration")


def public_names(module: str) -> set[str]:
    """What a module offers: its `__all__`, or the functions and classes that it defines."""
    found = import_module(f"twistarm.{module}") if module in ("control.stream", "viewer", "calibration") else twistarm
    found = getattr(twistarm, module) if module in twistarm.__all__ else found
    names = getattr(found, "__all__", None) or [
        name
        for name, value in vars(found).items()
        if getattr(value, "__module__", "") == found.__name__ and callable(value) and not name.startswith("_")
    ]
    return set(names)


REFERENCE = {page: page.read_text("utf-8") for page in sorted((DOCS / "api").glob("*.md"))}


@pytest.mark.parametrize("module", MODULES)
def test_every_public_name_has_its_entry_and_an_example(module):
    described = {name: page for page, text in REFERENCE.items() for name in re.findall(r":: (twistarm\.\S+)", text)}
    programs = {page: "\n".join(block.text for block in blocks(page) if block.kind == "python") for page in REFERENCE}
    for name in public_names(module) - {name.rpartition(".")[2] for name in MODULES}:
        full = f"twistarm.{module}.{name}" if module and name not in twistarm.__all__ else f"twistarm.{name}"
        assert full in described, f"{full} has no entry in docs/api"
        used = f"{module}.{name}" if module in ("screws", "joints", "poe", "rotations") else name
        assert re.search(rf"\b{re.escape(used)}\b", programs[described[full]]), f"{full} has no example"


def public_functions():
    """Every public function, and method of a public class, that a user can reach: {name: function}."""
    found = {}

    def visit(name, thing):
        if inspect.isclass(thing):
            for method, value in vars(thing).items():
                if not method.startswith("_"):
                    visit(f"{name}.{method}", getattr(value, "__func__", value))
        elif inspect.ismodule(thing):
            for function, value in vars(thing).items():
                if not function.startswith("_") and getattr(value, "__module__", "") == thing.__name__:
                    visit(f"{name}.{function}", value)
        elif inspect.isfunction(thing) and thing.__module__.startswith("twistarm"):
            found[name] = thing

    for name in twistarm.__all__:
        visit(name, getattr(twistarm, name))
    for name in stream.__all__:
        visit(f"stream.{name}", getattr(stream, name))
    return found


def test_functions_of_two_parameters_or_more_describe_each_of_them():
    functions = public_functions()
    assert len(functions) > 100
    lacking = {}
    for name, function in functions.items():
        parameters = inspect.signature(function).parameters.values()
        stars = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}
        names = [stars.get(p.kind, "") + p.name for p in parameters if p.name not in ("self", "cls")]
        described = inspect.getdoc(function).partition("\nArgs:\n")[2]
        missing = [p for p in names if not re.search(rf"^    {re.escape(p)}: ", described, re.M)]
        if len(names) > 1 and missing:
            lacking[name] = missing
    assert not lacking


def test_files_that_rules_and_recipes_name_are_there() -> None:
    """By their name, or by the end of their path."""
    root = Path(__file__).parents[2]
    folders = ("src", "core", "tests", "docs", "tools", "robots", "examples", "benchmarks")
    held = [file for folder in folders for file in (root / folder).rglob("*")]
    ends = {"/".join(file.parts[-k:]) for file in (*held, *root.glob("*")) for k in range(1, len(file.parts))}
    for page in ("docs/architecture.md", "CONTRIBUTING.md"):
        named = re.findall(r"`([\w./]+\.(?:py|hpp|cpp|js|json|md|html))`", (root / page).read_text("utf-8"))
        assert not [name for name in named if name.removeprefix("./") not in ends], page


def test_modules_among_the_public_names_can_be_imported_first():
    subprocess.run([sys.executable, "-c", "from twistarm import stream, viewer"], check=True)


EXAMPLES = Path(__file__).parents[2] / "examples"
PROGRAMS = sorted(file for file in EXAMPLES.rglob("[0-9]*.py") if "ros2" not in file.relative_to(EXAMPLES).parts)


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: str(path.relative_to(EXAMPLES)))
def test_it_runs_from_any_directory(
    program: Path, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", [str(program)])
    monkeypatch.syspath_prepend(program.parent)
    runpy.run_path(str(program), run_name="__main__")
    assert capsys.readouterr().out.strip(), "a lesson says what it found"
    assert list(here.iterdir()) == []
