"""xacro's texts: `${expressions}` and `$(commands)` in them, evaluated by checked expressions with counted work."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from .environment import Environment
from .expressions import Expressions
from .guards import Guards
from .names import direct_names, dotify, math_names, python_names, tokenize
from .work import Refused, Work

_TOKEN = re.compile(r"(\$\$+[{(])|\$\{([^}]*)\}|\$\(([^)]*)\)|([^$]+|\$[^{($]+|\$$)")
"""xacro's tokens: escaped dollars, `${expression}`, `$(command)`, text."""


WORKING_FOLDER = ".cwd"
"""Stands for it as a package's name would."""


class Evaluation:
    """Stands in the place of xacro's `eval_text` and `safe_eval`, and of its `$(eval ...)`.

    `find` answers `$(find package)`, `files` holds the functions about files.
    """

    def __init__(
        self,
        xacro: Any,
        work: Work,
        find: Callable[[str], str],
        files: Mapping[str, Callable[[str], Any]],
        environment: Environment,
    ) -> None:
        self._xacro = xacro
        self._work = work
        self._guards = Guards(work, xacro.Table)
        self._expressions = Expressions(self._guards)
        self._commands: dict[str, Any] = {}
        self.symbols = self._make_symbols(find, files, environment)
        """The names at the root of every scope, for xacro's `_global_symbols`."""

    def number(self, expression: str) -> float:
        """The value of an expression in YAML, which sees the global names alone."""
        return float(self._expressions.evaluate(expression, self.symbols))

    def text(self, text: str, symbols: Any) -> Any:
        """A text with its expressions and commands replaced; a lone expression keeps its type."""
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
            if expression is not None:
                results.append(self._evaluate(expression, symbols))
            elif command is not None:
                results.append(self._run(f"$({self.text(command, symbols)})"))
            else:
                results.append(escaped[1:] if escaped else plain)
        if len(results) == 1:
            return results[0]
        parts = list(map(str, results))
        self._work.charge(len(parts))
        self._work.charge_text(sum(map(len, parts)))
        return "".join(parts)

    def _evaluate(self, expression: str, symbols: Any) -> Any:
        try:
            return self._expressions.evaluate(str(self.text(expression, symbols)), symbols)
        except Refused as refused:
            refused.expression = refused.expression or f"${{{expression}}}"
            raise
        except Exception as error:
            suffix = f"when evaluating expression '{expression}'"
            raise self._xacro.XacroException(exc=error, suffix=suffix) from error

    def _run(self, command: str) -> str:
        self._work.charge(1 + len(command))
        if command == "$(cwd)":
            return f"package://{WORKING_FOLDER}"
        try:
            result = str(self._xacro.eval_extension(command))
        except Exception as error:
            for refused in (error, getattr(error, "exc", None)):
                if isinstance(refused, Refused):
                    refused.expression = refused.expression or command
                    raise refused from error
            raise
        self._work.charge_text(len(result))
        return result

    def command(self, expression: str, context: Mapping[str, Any]) -> str:
        """The text that `$(eval expression)` stands for: its names are the arguments."""
        return str(self._expressions.evaluate(expression, _CommandNames(self._commands, context["arg"], self._convert)))

    def _convert(self, text: Any) -> Any:
        return self._xacro.substitution_args.convert_value(str(text), "auto")

    def _argument(self, name: str) -> Any:
        arguments = self._xacro.substitution_args_context["arg"]
        if name not in arguments:
            raise self._xacro.XacroException(f"Undefined substitution argument {name}")
        return arguments[name]

    def _make_symbols(
        self, find: Callable[[str], str], functions: Mapping[str, Callable[[str], Any]], environment: Environment
    ) -> dict[str, Any]:
        python, mathematics = python_names(self._guards), math_names(self._guards)
        files = {**functions, "dotify": dotify}
        messages = dict.fromkeys(("message", "warning", "error", "print_location"), say_nothing)
        offered = {**files, **messages, "fatal": self._fail, "tokenize": tokenize, "arg": self._argument}
        self._commands = {
            **{"true": True, "false": False, "find": find},
            **{"env": environment.required, "optenv": environment.optional},
            **{"arg": lambda name: self._convert(self._argument(name))},
            **mathematics,
            **python,
        }
        spaces = {"python": python, "math": mathematics, "xacro": offered}
        return {**direct_names(python), **mathematics, **files, **{k: self._namespace(v) for k, v in spaces.items()}}

    def _namespace(self, names: Mapping[str, Any]) -> Any:
        namespace = self._xacro.NameSpace()
        namespace.update(names)
        return namespace

    def _fail(self, *words: Any) -> None:
        raise self._xacro.XacroException(" ".join(map(str, self._guards.data(words))))


class _CommandNames(dict[str, Any]):
    """The names in `$(eval ...)`: functions and constants first, then the arguments, as numbers where they are."""

    def __init__(self, names: Mapping[str, Any], arguments: Mapping[str, Any], convert: Callable[[Any], Any]) -> None:
        super().__init__(names)
        self._arguments = arguments
        self._convert = convert

    def __missing__(self, name: str) -> Any:
        return self._convert(self._arguments[name])


def say_nothing(*_: Any, **__: Any) -> str:
    """xacro's messages go to the terminal, which is the command line's."""
    return ""
