"""Imports point one way, heavy ones stay where they are used, and nothing prints but the command line."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import twistarm

PACKAGE = Path(twistarm.__file__).parent
FILES = sorted(file for file in PACKAGE.rglob("*.py") if file.parent.name != "lessons")
KNOWN = set(FILES)

FLOORS = (
    ("cli",),
    ("guide",),
    ("viewer", "export"),
    ("checking", "control", "design"),
    ("planning", "calibration"),
    ("ik",),
    ("collision",),
    ("arm",),
    ("description",),
    ("theory", "limits"),
    ("_core",),
    ("support",),
)
"""The rooms of the package, top to bottom: a room imports what stands on lower floors, and itself."""

DEPTH = {name: depth for depth, floor in enumerate(FLOORS) for name in floor}

ALLOWED = {
    "pinocchio": ("arm/pinocchio_model.py",),
    "meshcat": ("viewer",),
    "tornado": ("viewer/server",),
    "umsgpack": ("viewer",),
    "trimesh": ("description/meshes",),
    "collada": ("description/meshes",),
    "yourdfpy": ("checking/other_readers.py",),
    "mujoco": ("description/mjcf/compilation.py",),
    "ompl": ("planning/free_moves.py",),
    "scipy": ("planning", "guide/exercises"),
    "matplotlib": ("guide", "design/voxel_map.py"),
    "jupytext": ("guide/building",),
    "markdown_it": ("guide/teaching/markup.py",),
    "mdit_py_plugins": ("guide/teaching/markup.py",),
    "latex2mathml": ("guide/teaching/markup.py",),
    "pygments": ("guide/teaching/markup.py",),
    "lz4": ("planning/files/mcap_file.py",),
    "rosbags": ("planning/files/mcap_file.py",),
    "serial": ("control/stream/serial_link.py",),
    "xacro": ("description/expansion",),
    "yaml": ("description", "export/limits_yaml.py"),
    "typer": ("cli",),
    "rich": ("cli",),
}
"""The rooms, or files, that may import a library."""

# Imported at the top of modules that are themselves imported late.
AT_THE_TOP = {"typer", "rich", "tornado", "umsgpack"}


def room_of(file: Path) -> str:
    return file.relative_to(PACKAGE).parts[0].removesuffix(".py")


@cache
def syntax(file: Path) -> ast.Module:
    return ast.parse(file.read_text("utf-8"))


@cache
def imports(file: Path) -> tuple[tuple[ast.stmt, str, bool], ...]:
    """Every import as (node, absolute module name, at the top of the file)."""
    return tuple(_imports(file))


def _imports(file: Path) -> Iterator[tuple[ast.stmt, str, bool]]:
    tree = syntax(file)
    top = set(map(id, tree.body))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node, alias.name, id(node) in top
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node, node.module or "", id(node) in top
        elif isinstance(node, ast.ImportFrom):
            parents = ["twistarm", *file.relative_to(PACKAGE).parts[:-1]]
            home = ".".join(parents[: len(parents) - node.level + 1])
            if node.module:
                yield node, f"{home}.{node.module}", id(node) in top
            else:
                for alias in node.names:
                    yield node, f"{home}.{alias.name}", id(node) in top


def test_imports_point_one_way() -> None:
    for file in FILES:
        room = room_of(file)
        if room in ("__init__",):
            continue
        for _, module, _ in imports(file):
            if module.startswith("twistarm."):
                other = module.split(".")[1]
                assert other == room or DEPTH[other] > DEPTH[room], f"{file.relative_to(PACKAGE)} imports {other}"


def test_libraries_stay_in_their_rooms() -> None:
    for file in FILES:
        place = file.relative_to(PACKAGE).as_posix()
        for _, module, top in imports(file):
            library = module.split(".")[0]
            if library in ALLOWED:
                assert place.startswith(ALLOWED[library]), f"{library} is not for {place}"
                assert not top or library in AT_THE_TOP, f"{library} at the top of {place}"


def test_only_the_command_line_prints_or_exits() -> None:
    for file in FILES:
        if room_of(file) == "cli":
            continue
        for node in ast.walk(syntax(file)):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in ("print", "exit", "quit"), f"{file.name}:{node.lineno}"
            if isinstance(node, ast.Attribute) and node.attr == "exit":
                assert not (isinstance(node.value, ast.Name) and node.value.id == "sys"), f"{file.name}:{node.lineno}"


def test_the_command_line_prints_in_one_module() -> None:
    """What is printed may hold names from files: `output` shows them, whatever they are."""
    for file in sorted((PACKAGE / "cli").rglob("*.py")):
        if file.name == "output.py":
            continue
        for node in ast.walk(syntax(file)):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id != "print", f"{file.name}:{node.lineno}"
        assert "rich.markup" not in {module for _, module, _ in imports(file)} or file.name == "tables.py"


VIEWER_FLOORS = (
    ("viewer",),
    ("server",),
    ("site",),
    ("screenshot",),
    ("saved_page",),
    ("stage",),
    ("parts",),
    ("scene",),
    ("messages", "jobs"),
)
"""The rooms and modules of the view, top to bottom."""


def package_imports(file: Path, *, typing: bool = True) -> set[Path]:
    """The package's files that a file imports at any place, also late, and with `typing` for the sake of types."""
    tree = syntax(file)
    branches = [node for node in tree.body if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)]
    for_types = {line for branch in branches for line in range(branch.lineno, (branch.end_lineno or 0) + 1)}
    found = set()
    for node, module, _ in imports(file):
        if (node.lineno in for_types and not typing) or not module.startswith("twistarm."):
            continue
        below = [alias.name for alias in node.names] if isinstance(node, ast.ImportFrom) else []
        for name in [module, *(f"{module}.{member}" for member in below)]:
            path = PACKAGE.joinpath(*name.split(".")[1:])
            found |= {file for file in (path.with_suffix(".py"), path / "__init__.py") if file in KNOWN}
    return found - {file}


def circle(graph: dict[Path, set[Path]]) -> str:
    """The modules of one circle, "" without a circle."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return " -> ".join(file.relative_to(PACKAGE).as_posix() for file in error.args[1])
    return ""


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Neither late nor for the sake of types."""
    graph = {file: package_imports(file) for file in FILES if file != PACKAGE / "__init__.py"}
    assert circle(graph) == ""


def test_the_rooms_of_the_view_import_one_way() -> None:
    depth = {name: floor for floor, names in enumerate(VIEWER_FLOORS) for name in names}
    for file in sorted((PACKAGE / "viewer").rglob("*.py")):
        room = file.relative_to(PACKAGE / "viewer").parts[0].removesuffix(".py")
        for other in package_imports(file, typing=False):
            if room != "__init__" and other.is_relative_to(PACKAGE / "viewer"):
                below = other.relative_to(PACKAGE / "viewer").parts[0].removesuffix(".py")
                assert below == room or depth[below] > depth[room], f"{file.name} imports {below}"


HEADERS = Path(__file__).parents[2] / "core" / "include" / "twistarm"

HEADER_FLOORS = {"numeric": {"numeric"}, "kinematics": {"numeric", "kinematics"}}
HEADER_FLOORS["ik"] = {*HEADER_FLOORS["kinematics"], "ik"}
HEADER_FLOORS["closed_form"] = {*HEADER_FLOORS["ik"], "closed_form"}
HEADER_FLOORS["servo"] = {*HEADER_FLOORS["kinematics"], "servo"}
# The rooms of the C++ core, and those that each of them includes.
HEADER_FLOORS["planning"] = {*HEADER_FLOORS["kinematics"], "planning"}


def test_headers_include_one_way() -> None:
    headers = sorted(HEADERS.glob("*/*.hpp"))
    assert {header.parent.name for header in headers} == set(HEADER_FLOORS)
    for header in headers:
        for included in re.findall(r'#include "([^"]+)"', header.read_text("utf-8")):
            target = (header.parent / included).resolve()
            assert target.is_file(), f"{header.name} includes {included}"
            assert target.parent.name in HEADER_FLOORS[header.parent.name], f"{header.name} includes {included}"


def test_the_table_names_every_room() -> None:
    assert {room_of(file) for file in FILES} - {"__init__"} <= set(DEPTH)


def test_importing_twistarm_and_its_view_imports_nothing_heavy() -> None:
    heavy = [*ALLOWED, "cmeel"]
    program = f"import sys, twistarm, twistarm.viewer; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "[]"


def test_all_names_what_there_is() -> None:
    assert sorted(twistarm.__all__) == list(twistarm.__all__)
    for name in twistarm.__all__:
        assert getattr(twistarm, name).__doc__, f"{name} has no docstring"
