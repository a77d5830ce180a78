"""Functions that replace xacro's while a file is expanded. They confine files and count work."""

from __future__ import annotations

import errno
import fnmatch
import keyword
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.dom import expatbuilder, xmlbuilder
from xml.parsers import expat

from ...support.errors import one_line
from ..document import Reading, note_file, parse_xml
from ..findings import Place, refusal
from ..packages import PackageIndex, is_package_name
from .arguments import Arguments
from .confinement import Confinement
from .evaluation import WORKING_FOLDER, Environment, Evaluation, say_nothing
from .left_out import NEEDED, LeftOut
from .work import CHARACTERS_PER_UNIT, Refused, Work, is_final

PACKAGE = "package://"
"""What `$(find NAME)` gives before the package's name. The folder stays out of the texts, which users may pass on."""

HERE = f"{PACKAGE}./"
"""The description's own folder."""

MISSING_PACKAGE = "/package-not-found/"
"""The folder of an unknown package, for a file in it that is to be opened."""

MAX_INCLUDES = 30
"""Depth of includes. Deeper ones form a circle, which would take seconds until the stack is full."""

FILE_COST = 200
ELEMENT_COST = 15
ATTRIBUTE_COST = 12
CHANGE_COST = 25
MACRO_COST = 100
SIBLINGS_PER_UNIT = 50
"""minidom looks through a parent's children whenever it changes one."""

XACRO = "http://www.ros.org/wiki/xacro"

_MACRO_PARAMETER = re.compile(
    r"^\s*([^\s:=]+?)\s*:?=\s*(\^\|?)?"
    r"(\$\{.*?\}|\$\(.*?\)|(?:'[^']*'|\"[^\"]*\"|[^\s'\"])+|)(?:\s+|$)(.*)"
)
"""xacro's pattern without its nested repetition, which takes forever on some texts."""

_KEPT = ("resolve_macro", "parse_macro_arg", "handle_macro_call", "eval_all", "grab_property", "replace_node")
"""Functions of xacro that ours call."""

_WILDCARD = re.compile(r"[*?[]")


class Expansion:
    """One expansion: its files, arguments and packages, and the functions that xacro gets for it."""

    def __init__(
        self,
        xacro: Any,
        path: Path,
        packages: PackageIndex,
        arguments: Mapping[str, str],
        ignore_packages: Iterable[str] = (),
        env_vars: Iterable[str] = (),
    ) -> None:
        self.path = path
        self.packages = packages
        self.given = dict(arguments)
        self.left_out = LeftOut(tuple(ignore_packages), path)
        self.found = Arguments()
        self.unknown_packages: set[str] = set()
        self._xacro = xacro
        self._original: dict[str, Any] = {name: getattr(xacro, name, None) for name in _KEPT}
        self._confinement = Confinement(path, packages)
        self._in_leavable = False
        self.work = Work()
        self.environment = Environment(path, tuple(env_vars))
        files = {"load_yaml": self.load_yaml, "abs_filename": self.named_from_here}
        self._evaluation = Evaluation(xacro, self.work, self.find, files, self.environment)

    def for_xacro(self) -> dict[str, Any]:
        """Values for the module `xacro`."""
        leaving_out = {
            "handle_macro_call": self.call_macro,
            "eval_all": self.evaluate,
            "grab_property": self.grab_property,
        }
        return {
            "_global_symbols": self._evaluation.symbols,
            "substitution_args_context": {"arg": {}},
            "filestack": None,
            "macrostack": None,
            "verbosity": 0,
            "re_macro_arg": _MACRO_PARAMETER,
            "parse": self.parse,
            "get_include_files": self.include_files,
            "eval_text": self._evaluation.text,
            "is_valid_name": lambda name: name.isidentifier() and not keyword.iskeyword(name),
            "parse_macro_arg": self.macro_parameter,
            "resolve_macro": self.resolve_macro,
            "replace_node": self.replace_node,
            **dict.fromkeys(("message", "warning", "error", "print_location"), say_nothing),
            "remove_previous_comments": say_nothing,  # no comment comes so far
            **(leaving_out if self.left_out.packages else {}),
        }

    # files

    def parse(self, text: Any, filename: str) -> Any:
        """The document in a file that may be read."""
        try:
            path, text = self._read(filename)
        except Exception:
            self._xacro.filestack.pop()
            raise
        self.work.charge_text(len(text))
        self.work.charge(ELEMENT_COST * text.count("<") + ATTRIBUTE_COST * text.count("="))
        root = parse_xml(text, Reading(path, self.packages))
        self.found.look_through(root, path)
        return _document(text, root, path)

    def include_files(self, pattern: str, symbols: Any) -> Iterator[str]:
        """The file that an include names, or those that its wildcards match."""
        name = self._absolute(str(self._evaluation.text(pattern, symbols)))
        package = self.left_out.package_of(name)
        if package is not None:
            what = f"the include of {os.path.basename(name)!r} is left out without package {package!r}"
            self.left_out.leave_out(self.place, what, package)
            return
        yield from self._matching(name) if _WILDCARD.search(name) and not os.path.exists(name) else [name]

    def _matching(self, pattern: str) -> list[str]:
        folder, name = os.path.split(pattern)
        if not os.path.isdir(folder):
            if _WILDCARD.search(folder):
                what = f"wildcards in the folder of {pattern!r} are not allowed"
                raise Refused("file-outside-packages", what, "use them in the file's name, or name each file")
            return []
        names = self._confinement.entries(folder)
        self.work.charge(len(names))
        shown = [other for other in names if name.startswith(".") or not other.startswith(".")]
        return [os.path.join(folder, match) for match in fnmatch.filter(shown, name)]

    def load_yaml(self, filename: str) -> Any:
        """The data in a YAML file that may be read."""
        name = self._absolute(str(filename))
        package = self.left_out.package_of(name)
        if package is not None:
            what = f"{os.path.basename(name)!r} counts as empty without package {package!r}"
            self.left_out.leave_out(self.place, what, package)
            return {}
        path, text = self._read(name)
        self._xacro.filestack.append(name)
        data = self._evaluation.yaml(text, str(path))
        self._xacro.filestack.pop()
        return data

    def _absolute(self, name: str) -> str:
        name = name.replace("\\", "/")
        if name.startswith(PACKAGE):
            package, _, rest = name[len(PACKAGE) :].partition("/")
            return f"{self._folder(package)}/{rest}"
        if "://" in name:
            what = f"{name!r} is a URI; only files of packages are opened"
            raise Refused("file-outside-packages", what, "write a path or $(find package)/…")
        return str(self._xacro.abs_filename_spec(name))

    def _read(self, name: str) -> tuple[Path, str]:
        """The real path and the text of a file that may be read. XacroException if there is none."""
        if len(self._xacro.filestack) > MAX_INCLUDES:
            what = f"an included file refers to itself without end: {MAX_INCLUDES} files are open"
            raise Refused("xacro-failed", what, "take out the include that comes back")
        self.work.charge(FILE_COST)
        try:
            if name.startswith(MISSING_PACKAGE):
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), name)
            note_file(Path(name))
            return self._confinement.read(name)
        except OSError as error:
            raise self._xacro.XacroException(f"{error.strerror}: {name}", exc=error) from error

    def _folder(self, package: str) -> str:
        if package == ".":
            return str(self.path.parent)
        if package == WORKING_FOLDER:
            return os.getcwd()
        return str(self.packages.find(package) or MISSING_PACKAGE + package)

    def find(self, package: str) -> str:
        """The text for the folder of a package."""
        known = self.packages.find(package) or self.packages.find_for_mesh_alone(package)
        if known is None and package not in self.left_out.packages:
            self.unknown_packages.add(package)
        if not is_package_name(package):
            return MISSING_PACKAGE + package
        self.left_out.learn(package, self._folder(package))
        return PACKAGE + package

    def named_from_here(self, name: str) -> str:
        """A path relative to the file being read, as a name that holds in every file."""
        if os.path.isabs(name) or name.startswith(PACKAGE):
            return name
        folder = os.path.dirname(self._xacro.filestack[-1] or self.path)
        return HERE + os.path.relpath(os.path.join(folder, name), self.path.parent)

    @property
    def place(self) -> Place:
        """The macro being expanded with the file that defines it, else the file."""
        if self._xacro.macrostack:
            macro = self._xacro.macrostack[-1]
            return Place(str(macro.history[-1][-1] or self.path), element="macro", name=macro.body.getAttribute("name"))
        return Place(str((self._xacro.filestack or [self.path])[-1]))

    def neighbours(self, folder: Path, absent: Path) -> list[str]:
        """Names in a readable folder to offer instead of `absent`: folders, or files of its kind."""
        try:
            names = self._confinement.entries(folder)
        except (Refused, OSError):
            return []
        entries = [folder / name for name in names if not name.startswith(".")]
        if absent.parent == folder:
            return [entry.name for entry in entries if entry.suffix == absent.suffix and not entry.is_dir()]
        return [entry.name for entry in entries if entry.is_dir()]

    # what is left out

    def call_macro(self, node: Any, macros: Any, symbols: Any) -> bool:
        """Call xacro's function. After an include was left out, leave out macros without a definition."""
        prefix, _, name = node.tagName.partition(":")
        if self.left_out and prefix == "xacro" and name != "call":
            try:
                self._original["resolve_macro"](name, macros, symbols)
            except KeyError:
                what = f"a call of the macro {name!r} is left out: only what was left out before may define it"
                self.left_out.leave_out(self.place, what)
                self.replace_node(node, None)
                return True
        return bool(self._original["handle_macro_call"](node, macros, symbols))

    def evaluate(self, node: Any, macros: Any, symbols: Any) -> None:
        """Call xacro's function. Leave out an element that the arm does not need if it needs a part left out."""
        evaluate = self._original["eval_all"]
        needed = node.tagName in NEEDED or node.tagName.startswith("xacro:") or node.parentNode is None
        if needed or self._in_leavable:
            evaluate(node, macros, symbols)
            return
        self._in_leavable = True
        try:
            self._or_leave_out(node, lambda: evaluate(node, macros, symbols))
        finally:
            self._in_leavable = False

    def grab_property(self, node: Any, table: Any) -> None:
        """Call xacro's function. A property that needs a part left out stays undefined."""
        self._or_leave_out(node, lambda: self._original["grab_property"](node, table))

    def _or_leave_out(self, node: Any, act: Callable[[], None]) -> None:
        """Call `act`. If it fails after something was left out, remove the element."""
        files, calls = len(self._xacro.filestack), len(self._xacro.macrostack)
        try:
            act()
        except self._xacro.XacroException as error:
            if not self.left_out or is_final(error):
                raise
            del self._xacro.filestack[files:], self._xacro.macrostack[calls:]
            name = str(node.getAttribute("name"))
            element = f"<{node.tagName}{f' name={name!r}' if name else ''}>"
            self.left_out.leave_out(self.place, f"{element} is left out: {one_line(str(error), 200)}")
            if node.parentNode is not None:
                self.replace_node(node, None)

    # work: `parse` charges for the contents of a file, these for copies and moves

    def resolve_macro(self, name: str, macros: Any, symbols: Any) -> Any:
        """Call xacro's function, and charge for the macro's body, which xacro then copies."""
        found = self._original["resolve_macro"](name, macros, symbols)
        self.work.charge(MACRO_COST + ELEMENT_COST * _size(found[2].body))
        return found

    def replace_node(self, node: Any, by: Any, content_only: bool = False) -> None:
        """Call xacro's function, and charge for what it moves, and for a block what xacro has copied."""
        new = by if isinstance(by, list) else [by] if by is not None else []
        moved = 1 + sum(len(part.childNodes) if content_only else 1 for part in new)
        copied = ELEMENT_COST * sum(map(_size, new)) if node.nodeName == "xacro:insert_block" else 0
        looked_through = (moved + len(node.parentNode.childNodes)) // SIBLINGS_PER_UNIT
        self.work.charge(CHANGE_COST + copied + moved * (1 + looked_through))
        self._original["replace_node"](node, by, content_only)

    def macro_parameter(self, text: str) -> Any:
        """Call xacro's function, and charge for its copy of the other parameters."""
        self.work.charge(1 + len(text) // CHARACTERS_PER_UNIT)
        return self._original["parse_macro_arg"](text)


def _document(text: str, root: ET.Element, path: Path) -> Any:
    """minidom's document without the file's encoding, and without comments, which slow xacro down."""
    options = xmlbuilder.Options()
    options.comments = False
    try:
        return expatbuilder.makeBuilder(options).parseString(re.sub(r"^\s*<\?xml[^>]*\?>", "", text))
    except expat.ExpatError as error:  # of namespaces: all else was well-formed before
        what, remedy = "an attribute is given twice, by two prefixes of one namespace", "keep one of them"
        if error.code == expat.errors.codes[expat.errors.XML_ERROR_UNBOUND_PREFIX]:
            names = [name for element in root.iter() for name in (element.tag, *element.attrib)]
            declared = {"xml", "xmlns", *(name[len("xmlns:") :] for name in names if name.startswith("xmlns:"))}
            lost = next((name for name in names if ":" in name and name.partition(":")[0] not in declared), "…:")
            prefix = lost.partition(":")[0]
            what = f"the prefix of {lost!r} is not declared"
            remedy = f'add xmlns:{prefix}="{XACRO if prefix == "xacro" else "…"}" to <robot>'
        raise refusal("xml-malformed", Place(str(path), error.lineno), what, remedy) from error


def _size(node: Any) -> int:
    """The number of nodes in the tree below, plus the units of its characters."""
    size, stack = 0, [node]
    while stack:
        part = stack.pop()
        size += 1 + len(getattr(part, "data", "")) // CHARACTERS_PER_UNIT
        if part.nodeType == part.ELEMENT_NODE:
            size += sum(1 + len(value) // CHARACTERS_PER_UNIT for _, value in part.attributes.items())
        stack.extend(part.childNodes)
    return size
