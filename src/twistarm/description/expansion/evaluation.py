"""xacro's texts and YAML: `${expressions}` and `$(commands)` in them, evaluated with counted work."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...support.messages import Argument, Text
from ..findings import Finding, Place, finding
from .bounded_yaml import bounded_loader, is_deep
from .expressions import Expressions
from .names import DIRECT, math_names, python_names, tokenize
from .work import Refused, Work

_TOKEN = re.compile(r"(\$\$+[{(])|\$\{([^}]*)\}|\$\(([^)]*)\)|([^$]+|\$[^{($]+|\$$)")
"""xacro's tokens: escaped dollars, `${expression}`, `$(command)`, text."""

_FIND = re.compile(r"\$\(find ([^)\s]+)\)")

NODE_COST, CHARACTER_COST = 50, 0.6
"""Units that PyYAML in Python takes for a node, and for a character."""

WORKING_FOLDER = ".cwd"
"""The working folder, written as a package's name."""


class NotSetError(Exception):
    """A variable that the file needs has no value, or the caller does not name it."""


@dataclass
class Environment:
    """Replaces xacro's `$(env NAME)` and `$(optenv NAME default)`, also in `$(eval ...)`.

    A name outside `allowed` counts as not set. A file could otherwise put its value in the robot's name, and so on
    pages that users pass on.
    """

    file: Path
    allowed: tuple[str, ...] = ()
    _kept: dict[str, str] = field(default_factory=dict)

    def required(self, name: str) -> str:
        """The variable's value. NotSetError without one."""
        value = os.environ.get(name) if name in self.allowed else None
        if value is None:
            raise NotSetError(f"environment variable {name!r} is not set for it")
        return value

    def optional(self, name: str, default: str = "") -> str:
        """The variable's value, else the default."""
        if name in self.allowed:
            return os.environ.get(name, default)
        self._kept.setdefault(name, default)
        return default

    def findings(self) -> Iterator[Finding]:
        """One for each name that the file reads and the caller does not allow."""
        for name, default in self._kept.items():
            what = (
                f"it asks for the environment variable {name!r}, and was answered as if that were not set: {default!r}"
            )
            remedy = Text("pass {allowed} if it may know it", allowed=Argument("env_vars", [name]))
            yield finding("environment-kept", Place(self.file.name), what, remedy)


class Evaluation:
    """Replaces xacro's `eval_text` and its evaluation of expressions and commands.

    `find` evaluates `$(find package)`. `files` holds the functions about files.
    """

    def __init__(
        self,
        xacro: Any,
        work: Work,
        find: Callable[[str], str],
        files: Mapping[str, Callable[[str], Any]],
        environment: Environment,
    ) -> None:
        self._xacro, self._work, self._find, self._environment = xacro, work, find, environment
        self._expressions = Expressions(work, xacro.Table)
        python, mathematics = python_names(self._expressions), math_names(self._expressions)
        files = {**files, "dotify": lambda value: value}
        messages = dict.fromkeys(("message", "warning", "error", "print_location"), say_nothing)
        offered = {**files, **messages, "fatal": self._fail, "tokenize": tokenize, "arg": self._argument}
        self._commands = {
            **{"true": True, "false": False, "find": find},
            **{"env": environment.required, "optenv": environment.optional},
            **{"arg": lambda name: self._convert(self._argument(name))},
            **{**mathematics, **python},
        }
        for names in (offered, self._commands):
            self._expressions.offer(names)
        spaces = {"python": python, "math": mathematics, "xacro": offered}
        self.symbols = {
            **{**{name: python[name] for name in DIRECT}, **mathematics, **files},
            **{name: self._namespace(names) for name, names in spaces.items()},
        }
        """The names at the root of every scope, for xacro's `_global_symbols`."""

    def yaml(self, text: str, name: str) -> Any:
        """The data in a YAML text, by `bounded_loader`: plain, counted before it is built, with xacro's units.

        Expressions in it see the global names only. PyYAML's messages show `name`.
        """
        import yaml  # type: ignore[import-untyped,unused-ignore]

        def charge(nodes: int) -> str:
            self._work.charge(NODE_COST + nodes)
            return ""

        def number(expression: str) -> float:
            return float(self._expressions.evaluate(expression, self.symbols))

        self._work.charge(int(CHARACTER_COST * len(text)))
        units = {unit.value.tag: unit.value.conversion_constant for unit in self._xacro.ConstructUnits}
        stream = io.StringIO(text)
        stream.name = name
        try:
            return yaml.load(stream, Loader=bounded_loader(charge, units, number))
        except (RecursionError, yaml.YAMLError) as error:
            if is_deep(error):
                raise Refused("xacro-failed", "the YAML is nested too deeply", "write it flatter") from None
            raise

    def text(self, text: str, symbols: Any) -> Any:
        """A text with its expressions and commands replaced. A lone expression keeps its type."""
        if "$" not in text:
            return text
        results: list[Any] = []
        position = 0
        while position < len(text):
            match = _TOKEN.match(text, position)
            if match is None:
                raise self._xacro.XacroException(f"invalid expression: {text[position:]}")
            position = match.end()
            escaped, expression, command, plain = match.groups()
            if plain or escaped:
                results.append(plain or escaped[1:])
            else:
                results.append(self._replaced(expression, command, symbols))
        if len(results) == 1:
            return results[0]
        parts = list(map(str, results))
        self._work.charge(len(parts))
        self._work.charge_text(sum(map(len, parts)))
        return "".join(parts)

    def _replaced(self, expression: str | None, command: str | None, symbols: Any) -> Any:
        inside = str(self.text(expression if command is None else command, symbols))  # type: ignore[arg-type]
        try:
            return self._expressions.evaluate(inside, symbols) if command is None else self._run(inside)
        except Refused as refused:
            shown = f"$({inside})" if command is not None else f"${{{expression}}}"
            refused.expression = refused.expression or shown
            raise
        except Exception as error:
            told = f"when evaluating expression '{expression}'" if command is None else None
            raise self._xacro.XacroException(exc=error, suffix=told) from error

    def _run(self, command: str) -> str:
        """The text of `$(command)`."""
        self._work.charge_text(len(command))
        name, _, rest = command.strip().partition(" ")
        words = rest.split()
        if name == "eval":  # its names are the arguments
            return str(self._expressions.evaluate(rest, _CommandNames(self._commands, self._converted_argument)))
        if name == "cwd" and not words:
            return f"package://{WORKING_FOLDER}"
        if name == "optenv" and words:
            return self._environment.optional(words[0], " ".join(words[1:]))
        take = {"find": self._find, "arg": self._argument, "env": self._environment.required}.get(name)
        if take is None or len(words) != 1:
            raise ValueError(f"$({command}) is none of $(arg NAME), $(find PACKAGE), $(env NAME), $(eval …), $(cwd)")
        return _FIND.sub(lambda match: self._find(match[1]), str(take(words[0])))

    def _converted_argument(self, name: str) -> Any:
        return self._convert(self._xacro.substitution_args_context["arg"][name])

    def _convert(self, text: Any) -> Any:
        return self._xacro.substitution_args.convert_value(str(text), "auto")

    def _argument(self, name: str) -> Any:
        arguments = self._xacro.substitution_args_context["arg"]
        if name not in arguments:
            raise self._xacro.XacroException(f"Undefined substitution argument {name}")
        return arguments[name]

    def _namespace(self, names: Mapping[str, Any]) -> Any:
        namespace = self._xacro.NameSpace()
        namespace.update(names)
        return namespace

    def _fail(self, *words: Any) -> None:
        raise self._xacro.XacroException(" ".join(map(str, words)))


class _CommandNames(dict[str, Any]):
    """The names in `$(eval ...)`: functions and constants, then the arguments, converted to numbers if possible."""

    def __init__(self, names: Mapping[str, Any], argument: Callable[[str], Any]) -> None:
        super().__init__(names)
        self._argument = argument

    def __missing__(self, name: str) -> Any:
        return self._argument(name)


def say_nothing(*_: Any, **__: Any) -> str:
    """Drop xacro's messages, which would go to the terminal."""
    return ""
