"""xacro to URDF text without ROS: the xacro program with our own functions for files, packages and expressions."""

from __future__ import annotations

import glob
import os
import re
import sys
import threading
import traceback
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any, NamedTuple
from xml.dom import expatbuilder, xmlbuilder
from xml.parsers import expat

from ...support.errors import DescriptionError, InputError, TwistarmError, closest, listed
from ...support.interrupts import ending_at_once
from ...support.messages import Argument, Text, package_folder
from ...support.wheels import Wheel, load
from ..document import Reading, Refused, parse_xml, read_inside, read_text
from ..findings import Finding, Place, finding, refusal
from ..packages import PackageIndex
from ..structure import ATTRIBUTES, CONTENTS
from .expressions import LEFT_OUT, evaluate, type_of

# ROS 2's is the same code and serves; ROS 1's lacks what is replaced here.
_WHEEL = Wheel("xacro", "xacro", has="process_file", oldest="2.1")

_NAME = f"{__package__}._xacro"

_LOCK = threading.Lock()  # The copies of xacro share a module of commands.

# What `$(find NAME)` gives before the package's name. The folder stays out of the texts, which users may pass on.
PACKAGE = "package://"
HERE = f"{PACKAGE}./"  # The description's own folder.
CWD = f"{PACKAGE}.cwd"  # The working folder, of the command `$(cwd)`.

QUIET = ("message", "warning", "error", "print_location")  # Functions of xacro that write on the terminal.

# Words of xacro that mean nothing without their prefix.
BARE = ("arg", "call", "if", "include", "insert_block", "macro", "property", "unless")
# Elements of a robot that are no calls of macros of these names.
URDF = {*CONTENTS, *ATTRIBUTES, "geometry", "material", "transmission", "sensor", "gazebo", "ros2_control"}

REMEDIES = {
    "Invalid parameter": "add it to the params= of the macro, or leave it out of the call",
    "missing attribute 'default'": 'write default="" and give the value when loading',
    "is not defined": "define it by <xacro:property …>; without the prefix it is no property",
}
"""Remedies by words of xacro's sentence."""

MAX_INCLUDES = 20  # Files inside one another; a robot has some five. xacro's own recursion ends after ten seconds.

_PLACE = "place"  # The key of an element's `Place` among its data.


class Expanded(NamedTuple):
    """The URDF text, findings, and every argument that the file and its includes take, {name: default}.

    A required argument has the default None.
    """

    text: str
    findings: tuple[Finding, ...]
    arguments: dict[str, str | None]


def expand_xacro(
    path: Path,
    packages: PackageIndex,
    arguments: Mapping[str, object] | None = None,
    ignore_packages: Iterable[str] = (),
    env_vars: Iterable[str] = (),
) -> Expanded:
    """Expand the file at `path`.

    It reads files of its package and of packages found by their name (`document.read_inside`), and only the environment
    variables in `env_vars`. Its expressions only compute (`expressions`). A missing package is an error only if an
    include or a YAML load needs it. Includes, YAML and macros of the packages in `ignore_packages` are left out.
    Ctrl-C ends the process meanwhile, because one operation of an expression may take any time.

    Raises DescriptionError with the file, the cause and the remedy. Raises InputError for an argument that the file
    does not take.
    """
    given = {
        name: str(value).lower() if isinstance(value, bool) else str(value) for name, value in (arguments or {}).items()
    }
    with _LOCK:
        expansion = _Expansion(path, packages, given, tuple(ignore_packages), tuple(env_vars))
        try:
            with ending_at_once():
                document = expansion.xacro.process_file(str(path), mappings=dict(given), verbosity=0)
                robot = document.documentElement
                text = robot.toxml()
        except Exception as error:
            raise expansion.explained(error) from error
    known = expansion.arguments
    for name in given:
        if name not in known:
            allowed = f"its arguments: {', '.join(known) or 'none'}"
            raise InputError(f"{path.name} has no xacro argument {name!r}{closest(name, known)} ({allowed})")
    # Without xacro's banner, which shows the file's folder, and with paths that any reader of URDF takes: those of a
    # package, and for files beside the description relative ones.
    text = '<?xml version="1.0" ?>' + text.replace(f"file://{PACKAGE}", PACKAGE).replace(HERE, "")
    return Expanded(text, expansion.findings(robot), known)


def is_xacro(path: Path) -> bool:
    """Whether a file needs expansion, by its name or by a xacro element in it."""
    return path.suffix == ".xacro" or "<xacro:" in read_text(path)


def arguments_in(root: ET.Element) -> dict[str, str | None]:
    """Every argument that a document declares or uses, with its default; None if it is required or not declared."""
    declared: dict[str, str | None] = {}
    used: dict[str, None] = {}
    for element in root.iter():
        if element.tag == "xacro:arg" and "name" in element.attrib:
            declared.setdefault(element.attrib["name"], element.get("default"))
        for text in (*element.attrib.values(), element.text or "", element.tail or ""):
            used |= dict.fromkeys(re.findall(r"\$\(arg\s+([^)\s]+)\s*\)", text))
    return declared | {name: None for name in used if name not in declared}


def _own_xacro() -> Any:
    """A new copy of PyPI's xacro, also in a ROS shell with another one; the program's `xacro` stays unchanged.

    xacro keeps arguments, symbols and the file stack in module globals, and an expansion replaces some of them.
    """
    file = Path(load(_WHEEL).__file__)
    spec: Any = spec_from_file_location(_NAME, file, submodule_search_locations=[str(file.parent)])
    copy = module_from_spec(spec)
    sys.modules[_NAME] = copy  # where its own imports look for it
    spec.loader.exec_module(copy)
    return copy


def _exchange(module: Any, functions: Mapping[str, Any]) -> None:
    """Put our functions in place of xacro's. TwistarmError if this xacro has no such names."""
    if missing := [name for name in functions if not hasattr(module, name)]:
        lacks = f"this xacro ({module.__file__}) has no {', '.join(missing)} and cannot be confined"
        raise TwistarmError(f"{lacks}; pip install xacro==2.1.1")
    vars(module).update(functions)


def _say_nothing(*_: Any, **__: Any) -> str:
    """Drop xacro's messages, which would go to the terminal."""
    return ""


class _Expansion:
    """One expansion: a copy of xacro with our functions, and what they note."""

    def __init__(
        self,
        path: Path,
        packages: PackageIndex,
        given: Mapping[str, str],
        ignored: tuple[str, ...],
        env_vars: tuple[str, ...],
    ) -> None:
        self.arguments: dict[str, str | None] = {}
        self._path, self._packages, self._given = path, packages, given
        self._ignored, self._env_vars = ignored, env_vars
        self._macros = {*BARE}
        self._notes: dict[str, Finding] = {}
        self.xacro = xacro = _own_xacro()
        self._commands = commands = import_module(f"{_NAME}.substitution_args")
        functions = {
            "parse": self._parse,
            "get_include_files": self._include_files,
            "load_yaml": self._load_yaml,
            "abs_filename_spec": self._named_from_here,
            "safe_eval": partial(evaluate, namespace=xacro.Table),
            "eval_extension": self._extension,
            "remove_previous_comments": _say_nothing,  # no comment comes so far
            **dict.fromkeys(QUIET, _say_nothing),
        }
        if ignored:
            functions["handle_macro_call"] = partial(self._call_macro, xacro.handle_macro_call)
        _exchange(xacro, functions)
        own = {"_eval": self._eval, "_eval_find": self._find, "_eval_env": self._env, "_eval_optenv": self._optenv}
        _exchange(commands, own)
        xacro._global_symbols = symbols = xacro.create_global_symbols()
        symbols["xacro"].update(arg=self._argument, **dict.fromkeys(QUIET, _say_nothing))
        for name in LEFT_OUT:
            dict.pop(symbols["python"], name, None)
        symbols["python"]["type"] = type_of

    def findings(self, robot: Any) -> tuple[Finding, ...]:
        """Packages that no opened file needed, hidden variables, parts left out, and words without xacro's prefix."""
        parts = [robot, *(part for tag in CONTENTS for part in robot.getElementsByTagName(tag))]
        for child in (child for part in parts for child in part.childNodes):
            tag = getattr(child, "tagName", "")
            if tag.rpartition(".")[2] in self._macros and tag not in URDF:
                at: Place = child.getUserData(_PLACE)
                what = f"<{tag}> lacks the prefix xacro: and does nothing"
                self._note("word-unread", replace(at, file=Path(at.file).name), what, f"write <xacro:{tag} …>")
        return tuple(self._notes.values())

    def explained(self, error: Exception) -> DescriptionError:
        """The error to raise, at the innermost element that xacro was expanding."""
        place = Place(str(self.xacro.filestack[-1]))
        for frame, _ in traceback.walk_tb(error.__traceback__):  # xacro's errors do not name the element
            node: Any = frame.f_locals.get("node")
            while hasattr(node, "getUserData") and node.getUserData(_PLACE) is None:  # a text
                node = node.parentNode
            if hasattr(node, "getUserData"):
                place = node.getUserData(_PLACE)
        text = " ".join(str(error).split())
        cause: BaseException | None = error
        while cause is not None:
            if isinstance(cause, DescriptionError):
                return cause
            if isinstance(cause, Refused):
                expression = re.search(r"when evaluating expression '(.*)'", text)
                where = f" (in ${{{expression[1]}}})" if expression else ""
                return refusal(cause.code, place, cause.what + where, cause.remedy)
            if isinstance(cause, RecursionError | MemoryError):
                what = "it nests without end: a macro, a property or an included file refers to itself, or is too deep"
                return refusal("xacro-failed", place, what)
            if isinstance(cause, OSError):
                values = Text(
                    "correct the path, or a value of {arguments} in it", arguments=Argument("xacro_args", None)
                )
                return refusal("xacro-failed", place, f"{cause.strerror}: {cause.filename}", values)
            if isinstance(cause, self._commands.ArgException):
                return self._missing_argument(str(cause), place)
            cause = getattr(cause, "exc", None) or cause.__cause__  # xacro keeps it in `exc`
        remedy = next((remedy for part, remedy in REMEDIES.items() if part in text), "")
        return refusal("xacro-failed", place, f"xacro cannot expand it: {text}", remedy)

    def _missing_argument(self, name: str, place: Place) -> DescriptionError:
        """The error for an argument without a value. The remedy has all of them, and a default that comes too late."""
        missing: dict[str, Any] = {name: self.arguments.get(name) or ...}
        required = [other for other, default in self.arguments.items() if default is None]
        missing |= {other: ... for other in required if other not in self._given}
        remedy = Text("pass {arguments}", arguments=Argument("xacro_args", missing))
        return refusal("xacro-arguments", place, f"the xacro argument {name!r} has no value here", remedy)

    def _note(self, code: str, place: Place, what: str, remedy: str) -> None:
        self._notes.setdefault(what, finding(code, place, what, remedy))

    # -- commands and the environment: a file could put a value in the robot's name, and so on pages that users pass on

    def _extension(self, text: str) -> str:
        """The text of `$(…)`."""
        return CWD if text == "$(cwd)" else self._commands.resolve_args(text, self.xacro.substitution_args_context)

    def _argument(self, name: str) -> Any:
        return self._commands._eval_arg(name, self.xacro.substitution_args_context["arg"])

    def _eval(self, expression: str, context: Any) -> str:
        """The text of `$(eval …)`. Its names are the arguments."""

        def converted(name: str) -> Any:
            return self._commands.convert_value(self._argument(name), "auto")

        symbols = self.xacro._global_symbols
        names = {**symbols["python"], **symbols["math"], "true": True, "false": False}
        names |= {"find": self._find, "env": self._env, "optenv": self._optenv, "arg": converted}
        return str(evaluate(expression, {name: converted(name) for name in context["arg"]} | names, self.xacro.Table))

    def _env(self, name: str) -> str:
        value = os.environ.get(name) if name in self._env_vars else None
        if value is None:
            remedy = Text("set it, and pass {allowed} to let the file read it", allowed=Argument("env_vars", [name]))
            raise Refused("xacro-failed", f"environment variable {name!r} is not set for it", remedy)
        return value

    def _optenv(self, name: str, default: str = "") -> str:
        if name in self._env_vars:
            return os.environ.get(name, default)
        what = f"it asks for the environment variable {name!r}, which counts as not set: {default!r} is used"
        remedy = Text("pass {allowed} to let the file read it", allowed=Argument("env_vars", [name]))
        self._note("environment-kept", Place(self._path.name), what, remedy)
        return default

    # -- files

    def _find(self, package: str) -> str:
        """The text for the folder of a package."""
        if self._packages.find_for_mesh(package) is None and package not in self._ignored:
            what = f"$(find {package}): package not found; nothing the kinematics needs uses it"
            remedy = Text("pass {folder} if its files matter", folder=package_folder(package))
            self._note("package-not-found", Place(self._path.name), what, remedy)
        return PACKAGE + package

    def _named_from_here(self, name: str) -> str:
        """A path relative to the file being read, as a name that holds in every file."""
        if os.path.isabs(name) or name.startswith(PACKAGE):
            return name
        folder = os.path.dirname(self.xacro.filestack[-1])
        return HERE + os.path.relpath(os.path.join(folder, name), self._path.parent)

    def _file(self, name: str) -> str:
        """The path of a name in the file being read. Refused for an unknown package."""
        name = name.replace("\\", "/")
        if name.startswith(PACKAGE):
            package, _, rest = name.removeprefix(PACKAGE).partition("/")
            folder = {".": self._path.parent, ".cwd": Path.cwd()}.get(package) or self._packages.find(package)
            if folder is None:
                remedy = Text(
                    "{remedy}; if the arm does not need it (sensor, gripper, simulator), pass {without}",
                    remedy=self._packages.remedy(package),
                    without=Argument("ignore_packages", [package]),
                )
                what = f"package {package!r} not found around the file or in a sourced ROS workspace"
                raise Refused("package-needed-not-found", what, remedy)
            return f"{folder}/{rest}"
        return os.path.join(os.path.dirname(self.xacro.filestack[-1]), name)

    def _parse(self, _: Any, filename: str) -> Any:
        """The document in a file that may be read."""
        if len(self.xacro.filestack) > MAX_INCLUDES:
            last = " > ".join(map(os.path.basename, self.xacro.filestack[-3:]))
            what = f"files include files more than {MAX_INCLUDES} deep, at last {last}"
            raise Refused("xacro-failed", what, "leave out the include by which a file includes itself")
        try:
            path, text = read_inside(filename, self._packages)
        except OSError as error:
            self.xacro.filestack.pop()
            raise self.xacro.XacroException(exc=error) from error  # as xacro does, for optional includes
        root = parse_xml(text, Reading(path, self._packages))
        self._macros |= {macro.get("name", "").removeprefix("xacro:") for macro in root.iter("xacro:macro")}
        for name, default in arguments_in(root).items():
            if self.arguments.get(name) is None:
                self.arguments[name] = default
        return _document(text, path)

    def _include_files(self, pattern: str, symbols: Any) -> Iterator[str]:
        """The file that an include names, or those that its wildcards match."""
        written = str(self.xacro.eval_text(pattern, symbols))
        if self._is_ignored(written):
            self._leave_out(f"the include of {os.path.basename(written)!r} is left out")
        elif wild := re.search(r"[*?[]", written):
            before = self._file(written[: wild.start()])  # a folder of the user may have such signs in its name
            yield from sorted(glob.glob(glob.escape(before) + written[wild.start() :]))
        else:
            yield self._file(written)

    def _load_yaml(self, filename: object) -> Any:
        """The data in a YAML file that may be read, with xacro's units."""
        import yaml

        if self._is_ignored(str(filename)):
            self._leave_out(f"{os.path.basename(str(filename))!r} counts as empty")
            return self.xacro.YamlDictWrapper({})

        class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc] # tags on PyYAML's would stay
            pass

        for unit in self.xacro.ConstructUnits:
            Loader.add_constructor(unit.value.tag, unit.constructor)
        _, text = read_inside(self._file(str(filename)), self._packages)
        return self.xacro.YamlListWrapper.wrap(yaml.load(text, Loader=Loader))

    # -- packages to do without

    def _is_ignored(self, name: str) -> bool:
        """Whether a file belongs to an ignored package, by `$(find …)` or by a folder of that name."""
        parts = name.removeprefix(PACKAGE).replace("\\", "/").split("/")
        return any(package in parts for package in self._ignored)

    def _leave_out(self, what: str) -> None:
        remedy = Text(
            "if it matters, pass {folder} instead of {without}",
            folder=package_folder(listed(self._ignored)),
            without=Argument("ignore_packages", None),
        )
        self._note("package-left-out", Place(os.path.basename(self.xacro.filestack[-1])), what, remedy)

    def _call_macro(self, call: Callable[..., bool], node: Any, macros: Any, symbols: Any) -> bool:
        """Call xacro's function. The call of an unknown macro is left out if a file was."""
        name = node.tagName.removeprefix("xacro:")
        if name not in ("call", node.tagName) and any(note.code == "package-left-out" for note in self._notes.values()):
            try:
                self.xacro.resolve_macro(name, macros, symbols)
            except KeyError:
                self._leave_out(f"the call of the macro {name!r} is left out: no file that is read defines it")
                self.xacro.replace_node(node, None)
                return True
        return call(node, macros, symbols)


def _document(text: str, path: Path) -> Any:
    """minidom's document without the file's encoding, and without comments, which slow xacro down."""
    options = xmlbuilder.Options()
    options.comments = False
    try:
        return _Builder(options, path).parseString(re.sub(r"^<\?xml[^>]*\?>", "", text))
    except expat.ExpatError as error:  # of namespaces: all else was well-formed before
        what = f"{expat.ErrorString(error.code)}: {text.splitlines()[error.lineno - 1].strip()}"
        xmlns = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
        remedy = f"declare each prefix once, as {xmlns} in <robot>; begin the name behind it with a letter"
        raise refusal("xml-malformed", Place(str(path), error.lineno), what, remedy) from error


class _Builder(expatbuilder.ExpatBuilderNS):
    """minidom's reader, which gives each element its place, and so each copy, as in the body of a macro."""

    def __init__(self, options: Any, path: Path) -> None:
        super().__init__(options)
        self._path = str(path)

    def start_element_handler(self, name: str, attributes: list[str]) -> None:
        super().start_element_handler(name, attributes)
        element: Any = self.curNode
        place = Place(self._path, self.getParser().CurrentLineNumber, element.tagName, element.getAttribute("name"))
        element.setUserData(_PLACE, place, self)

    def handle(self, _: int, key: str, place: Place, __: Any, copy: Any) -> None:
        """Called by minidom for each copy."""
        copy.setUserData(key, place, self)
