"""Documentation is whole: each parameter is described, and the files that rules and recipes name are there."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from pathlib import Path

import twistarm
from twistarm import stream, testing


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
    visit("testing", testing)
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
    subprocess.run([sys.executable, "-c", "from twistarm import stream, testing"], check=True)
