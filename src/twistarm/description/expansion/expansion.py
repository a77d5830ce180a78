"""One expansion: the functions and names that the private copy of xacro gets for a description."""

from __future__ import annotations

import errno
import fnmatch
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any
from xml.dom import expatbuilder, xmlbuilder
from xml.parsers import expat
from xml.parsers.expat import errors

from ...support.errors import listed
from ...support.messages import Argument, Text, package_folder
from ..document import Reading, Refused, parse_xml, read_inside, real_inside
from ..findings import Finding, Place, finding, refusal
from ..packages import NAMES, PackageIndex
from ..structure import ATTRIBUTES, CONTENTS
from .expressions import LEFT_OUT, evaluate, type_of

# What `$(find NAME)` gives before the package's name. The folder stays out of the texts, which users may pass on.
PACKAGE = "package://"
HERE = f"{PACKAGE}./"  # The description's own folder.
WORKING_FOLDER = ".cwd"  # The working folder, written as a package's name.
# The folder of an unknown package, for a file in it that is to be opened.
MISSING_PACKAGE = "/package-not-found/"

XACRO = "http://www.ros.org/wiki/xacro"

QUIET = ("message", "warning", "error", "print_location")  # Functions of xacro that write on the terminal.

REPLACED = (
    *("_global_symbols", "substitution_args_context", "filestack", "macrostack", "verbosity", "all_includes"),
    *("parse", "get_include_files", "eval_text", "eval_extension", "safe_eval", "remove_previous_comments"),
    *("handle_macro_call", *QUIET),
)
"""Names in the module `xacro` that an expansion replaces."""

# Words of xacro that mean nothing without their prefix.
BARE = ("arg", "call", "if", "include", "insert_block", "macro", "property", "unless")
# Elements of URDF, or of other programs, that are no calls of macros of these names.
URDF = {*ATTRIBUTES, "geometry", "material", "transmission", "sensor", "gazebo", "ros2_control", "dynamics"}

_FIND = re.compile(r"\$\(find ([^)\s]+)\)")


class Expansion:
    """The files, arguments, packages and environment of one description."""

    def __init__(
        self,
        xacro: Any,
        path: Path,
        packages: PackageIndex,
        arguments: Mapping[str, str],
        ignore_packages: Iterable[str] = (),
        env_vars: Iterable[str] = (),
    ) -> None:
        self.path, self.packages, self.given = path, packages, dict(arguments)
        self._xacro, self._ignored, self._env_vars = xacro, tuple(ignore_packages), tuple(env_vars)
        self._documents: list[dict[str, str | None]] = []
        self._unknown: set[str] = set()
        self._macros, self._bare = {*BARE}, dict[str, Place]()
        self._notes: dict[str, Finding] = {}
        self.failed: Place | None = None

    def findings(self) -> tuple[Finding, ...]:
        """Packages that no opened file needed, variables that are not shown, and parts left out."""
        unknown = []
        for package in sorted(self._unknown):
            what = f"$(find {package}): package not found; nothing the kinematics needs uses it"
            remedy = Text("pass {folder} if its files matter", folder=package_folder(package))
            unknown.append(finding("package-not-found", Place(self.path.name), what, remedy))
        for tag, place in self._bare.items():
            if tag.rpartition(".")[2] in self._macros:
                what = f"<{tag}> lacks the prefix xacro: and does nothing"
                unknown.append(finding("word-unread", place, what, f"write <xacro:{tag} …>"))
        return (*unknown, *self._notes.values())

    @property
    def arguments(self) -> dict[str, str | None]:
        """The arguments that the files read so far declare or use, with their first default, None without one."""
        found: dict[str, str | None] = {}
        for one in self._documents:
            found |= {name: default for name, default in one.items() if found.get(name) is None}
        return found

    def attributes(self) -> dict[str, Any]:
        """Values for the module `xacro`, which keeps its state in module globals."""
        return {
            "_global_symbols": self._symbols(),
            "substitution_args_context": {"arg": {}},
            "filestack": None,
            "macrostack": None,
            "verbosity": 0,
            "all_includes": [],
            "parse": self._parse,
            "get_include_files": self._include_files,
            "eval_text": self._text,
            "eval_extension": lambda command: self._command(command[2:-1]),
            "safe_eval": partial(evaluate, namespace=self._xacro.Table),
            "remove_previous_comments": _say_nothing,  # no comment comes so far
            **dict.fromkeys(QUIET, _say_nothing),
            **({"handle_macro_call": self._call_macro} if self._ignored else {}),
        }

    @property
    def place(self) -> Place:
        """The macro being expanded with the file that defines it, else the file; the place that `failed`, if any."""
        place = self.failed or Place(str((self._xacro.filestack or [self.path])[-1]))
        if self._xacro.macrostack:
            macro = self._xacro.macrostack[-1]
            file = place.file if self.failed else str(macro.history[-1][-1] or self.path)
            return replace(place, file=file, element="macro", name=macro.body.getAttribute("name"))
        return place

    # names and texts

    def _symbols(self) -> Any:
        """xacro's own names, with our functions about files and arguments."""
        symbols = self._xacro.create_global_symbols()
        own = {"load_yaml": self._load_yaml, "abs_filename": self._named_from_here}

        def fail(*words: Any) -> None:
            raise self._xacro.XacroException(" ".join(map(str, words)))

        symbols["xacro"].update(own, arg=self._argument, fatal=fail)
        symbols["xacro"].update(dict.fromkeys(QUIET, _say_nothing))
        symbols.update(own)
        python = symbols["python"]
        for name in LEFT_OUT:
            dict.pop(python, name)
        python["type"] = type_of
        return symbols

    def _text(self, text: str, symbols: Any) -> Any:
        return self._xacro.original["eval_text"](text, symbols) if "$" in text else text

    def _command(self, command: str) -> str:
        """The text of `$(command)`."""
        name, _, rest = command.strip().partition(" ")
        words = rest.split()
        if name == "eval":  # its names are the arguments
            python = self._xacro._global_symbols["python"]
            names = {**python, **self._xacro._global_symbols["math"], "true": True, "false": False}
            names |= {"find": self._find, "env": self._required, "optenv": self._optional}
            names |= {"arg": lambda argument: self._converted(self._argument(argument))}
            arguments = self._xacro.substitution_args_context["arg"]
            names = {argument: self._converted(value) for argument, value in arguments.items()} | names
            return str(evaluate(rest, names, self._xacro.Table))
        if name == "cwd" and not words:
            return PACKAGE + WORKING_FOLDER
        if name == "optenv" and words:
            return self._optional(words[0], " ".join(words[1:]))
        take = {"find": self._find, "arg": self._argument, "env": self._required}.get(name)
        if take is None or len(words) != 1:
            what = f"$({command}) is none of $(arg NAME), $(find PACKAGE), $(env NAME), $(eval …), $(cwd)"
            raise self._xacro.XacroException(what)
        return _FIND.sub(lambda match: self._find(match[1]), str(take(words[0])))

    def _argument(self, name: str) -> Any:
        arguments = self._xacro.substitution_args_context["arg"]
        if name not in arguments:
            raise self._xacro.XacroException(f"Undefined substitution argument {name}")
        return arguments[name]

    def _converted(self, text: Any) -> Any:
        return self._xacro.substitution_args.convert_value(str(text), "auto")

    # the environment: a file could put a value in the robot's name, and so on pages that users pass on

    def _required(self, name: str) -> str:
        value = os.environ.get(name) if name in self._env_vars else None
        if value is None:
            remedy = Text("set it, and pass {allowed} to let the file read it", allowed=Argument("env_vars", [name]))
            raise Refused("xacro-failed", f"environment variable {name!r} is not set for it", remedy)
        return value

    def _optional(self, name: str, default: str = "") -> str:
        if name in self._env_vars:
            return os.environ.get(name, default)
        what = f"it asks for the environment variable {name!r}, which counts as not set: {default!r} is used"
        remedy = Text("pass {allowed} to let the file read it", allowed=Argument("env_vars", [name]))
        self._notes.setdefault(f"env {name}", finding("environment-kept", Place(self.path.name), what, remedy))
        return default

    # files

    def _find(self, package: str) -> str:
        """The text for the folder of a package."""
        if self.packages.find_for_mesh(package) is None and package not in self._ignored:
            self._unknown.add(package)
        is_word = NAMES["ignore_packages"][0].fullmatch(package)
        return PACKAGE + package if is_word else MISSING_PACKAGE + package

    def _named_from_here(self, name: str) -> str:
        """A path relative to the file being read, as a name that holds in every file."""
        if os.path.isabs(name) or name.startswith(PACKAGE):
            return name
        folder = os.path.dirname(self._xacro.filestack[-1] or self.path)
        return HERE + os.path.relpath(os.path.join(folder, name), self.path.parent)

    def _absolute(self, name: str) -> str:
        name = name.replace("\\", "/")
        if name.startswith(PACKAGE):
            package, _, rest = name[len(PACKAGE) :].partition("/")
            own = {".": str(self.path.parent), WORKING_FOLDER: os.getcwd()}.get(package)
            return f"{own or self.packages.find(package) or MISSING_PACKAGE + package}/{rest}"
        if "://" in name:
            what = f"{name!r} is a URI; only files of packages are opened"
            raise Refused("file-outside-packages", what, "write a path or $(find package)/…")
        folder = os.path.dirname(self._xacro.filestack[-1] or self.path)
        return os.path.join(folder, name)

    def _read(self, name: str) -> tuple[Path, str]:
        """The real path and the text of a file that may be read. XacroException if there is none."""
        try:
            if name.startswith(MISSING_PACKAGE):
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), name)
            return read_inside(name, self.packages)
        except OSError as error:
            raise self._xacro.XacroException(f"{error.strerror}: {name}", exc=error) from error

    def _parse(self, text: Any, filename: str) -> Any:
        """The document in a file that may be read."""
        try:
            path, text = self._read(filename)
        except Exception:
            self._xacro.filestack.pop()
            raise
        reading = Reading(path, self.packages)
        root = parse_xml(text, reading)
        self._documents.append(arguments_in(root))
        self._note_names(root, reading)
        return _document(text, path)

    def _note_names(self, part: ET.Element, reading: Reading) -> None:
        """Remember the macros, and the elements that may be calls without the prefix."""
        for child in part:
            if child.tag == "xacro:macro":
                self._macros.add(child.get("name", "").removeprefix("xacro:"))
            if child.tag in CONTENTS or child.tag.startswith("xacro:"):
                self._note_names(child, reading)
            elif child.tag not in URDF:
                self._bare.setdefault(child.tag, reading.place(child))

    def _include_files(self, pattern: str, symbols: Any) -> Iterator[str]:
        """The file that an include names, or those that its wildcards match."""
        written = str(self._text(pattern, symbols))
        if self._is_ignored(written):
            self._leave_out(f"the include of {os.path.basename(written)!r} is left out")
            return
        name = self._absolute(written)
        folder, last = os.path.split(name)
        if not re.search(r"[*?[]", last) or os.path.exists(name):
            yield name
        elif os.path.isdir(folder):
            names = sorted(os.listdir(real_inside(folder, self.packages)))
            visible = [other for other in names if last.startswith(".") or not other.startswith(".")]
            yield from (os.path.join(folder, match) for match in fnmatch.filter(visible, last))

    def _load_yaml(self, filename: str) -> Any:
        """The data in a YAML file that may be read, with xacro's units."""
        import yaml

        if self._is_ignored(str(filename)):
            self._leave_out(f"{os.path.basename(str(filename))!r} counts as empty")
            return self._xacro.YamlDictWrapper({})

        class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc] # tags on PyYAML's would stay
            pass

        for unit in self._xacro.ConstructUnits:
            Loader.add_constructor(unit.value.tag, unit.constructor)
        name = self._absolute(str(filename))
        _, text = self._read(name)
        self._xacro.filestack.append(name)
        data = yaml.load(text, Loader=Loader)
        self._xacro.filestack.pop()
        return self._xacro.YamlListWrapper.wrap(data)

    # packages to do without

    def _is_ignored(self, name: str) -> bool:
        """Whether a file belongs to an ignored package, by `$(find …)` or by a folder of that name."""
        parts = Path(name.removeprefix(PACKAGE).replace("\\", "/")).parts
        return any(package in parts for package in self._ignored)

    def _leave_out(self, what: str) -> None:
        place = replace(self.place, file=os.path.basename(self.place.file))
        remedy = Text(
            "if it matters, pass {folder} instead of {without}",
            folder=package_folder(listed(self._ignored)),
            without=Argument("ignore_packages", None),
        )
        self._notes.setdefault(what, finding("package-left-out", place, what, remedy))

    def _call_macro(self, node: Any, macros: Any, symbols: Any) -> Any:
        """Call xacro's function. The call of an unknown macro is left out if a file was."""
        name = node.tagName.removeprefix("xacro:")
        if name not in ("call", node.tagName) and any(note.code == "package-left-out" for note in self._notes.values()):
            try:
                self._xacro.resolve_macro(name, macros, symbols)
            except KeyError:
                self._leave_out(f"the call of the macro {name!r} is left out: no file that is read defines it")
                self._xacro.replace_node(node, None)
                return True
        return self._xacro.original["handle_macro_call"](node, macros, symbols)


def _document(text: str, path: Path) -> Any:
    """minidom's document without the file's encoding, and without comments, which slow xacro down."""
    options = xmlbuilder.Options()
    options.comments = False
    try:
        return _Builder(options, path).parseString(re.sub(r"^<\?xml[^>]*\?>", "", text))
    except expat.ExpatError as error:  # of namespaces: all else was well-formed before
        line = text.split("\n")[error.lineno - 1]
        name = re.findall(r"[^\s<>]*$", line[: error.offset])[0] + re.findall(r"^<?[^\s/>=]*", line[error.offset :])[0]
        why, remedy = expat.ErrorString(error.code), f'declare each prefix once, as xmlns:xacro="{XACRO}" in <robot>'
        if error.code == errors.codes[errors.XML_ERROR_INVALID_TOKEN]:
            why, remedy = "behind its colon no name begins with a digit or colon", "rename it, as in xacro:control_2dof"
        raise refusal("xml-malformed", Place(str(path), error.lineno), f"{name.lstrip('<')}: {why}", remedy) from error


PLACE = "place"  # The key of an element's `Place` among its data.


class _Builder(expatbuilder.ExpatBuilderNS):
    """minidom's reader, which gives each element its place, and so each copy, as in the body of a macro."""

    def __init__(self, options: Any, path: Path) -> None:
        super().__init__(options)
        self._path = str(path)

    def start_element_handler(self, name: str, attributes: list[str]) -> None:
        super().start_element_handler(name, attributes)
        self.curNode.setUserData(PLACE, Place(self._path, self.getParser().CurrentLineNumber), self)

    def handle(self, _: int, key: str, place: Place, __: Any, copy: Any) -> None:
        """Called by minidom for each copy."""
        copy.setUserData(key, place, self)


def _say_nothing(*_: Any, **__: Any) -> str:
    """Drop xacro's messages, which would go to the terminal."""
    return ""


_USED = re.compile(r"\$\(arg\s+([^)\s]+)\s*\)")


def arguments_in(root: ET.Element) -> dict[str, str | None]:
    """Every argument that a document declares or uses, with its default; None if it is required or not declared."""
    declared: dict[str, str | None] = {}
    used: dict[str, None] = {}
    for element in root.iter():
        if element.tag == "xacro:arg" and "name" in element.attrib:
            declared.setdefault(element.attrib["name"], element.get("default"))
        for text in (*element.attrib.values(), element.text or "", element.tail or ""):
            used |= dict.fromkeys(_USED.findall(text) if "$(" in text else ())
    return declared | {name: None for name in used if name not in declared}
