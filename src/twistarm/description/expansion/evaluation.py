"""The names and functions of xacro's `${expressions}` and `$(commands)`."""

from __future__ import annotations

import builtins
import math
import re
from collections.abc import Callable, Mapping
from typing import Any

from .environment import Environment
from .expressions import REFUSED, Expressions
from .refused import Refused

_BUILTINS = """
    abs all any bool dict divmod enumerate filter float int isinstance len list map max min ord range repr reversed
    round set sorted str sum tuple zip
"""
PYTHON = {name: getattr(builtins, name) for name in _BUILTINS.split()} | {"type": lambda value: type(value)}
"""The namespace `python`. Of xacro's, `vars`, `slice`, `hash` and `complex` are not in it."""

MATH = {name: value for name, value in vars(math).items() if not name.startswith("_")}
"""The namespace `math`."""

DIRECT = ["list", "dict", "map", "len", "str", "float", "int", "bool", "min", "max", "round", "sorted", "range"]
"""Names that need no `python.` before them."""

_MARKED = re.compile(r"\$[{($]")
"""The begin of an expression, of a command, or of what is escaped."""

WORKING_FOLDER = "package://.cwd"
"""The text of `$(cwd)`."""


class Evaluation:
    """Evaluates expressions and commands for xacro.

    `find` evaluates `$(find package)`. `files` holds the functions about files.
    """

    def __init__(
        self,
        xacro: Any,
        find: Callable[[str], str],
        files: Mapping[str, Callable[[str], Any]],
        environment: Environment,
    ) -> None:
        from xacro import substitution_args  # type: ignore[import-untyped,unused-ignore]

        self._xacro, self._commands, self._eval_text = xacro, substitution_args, xacro.eval_text
        told = {name: xacro._global_symbols["xacro"][name] for name in ("message", "warning", "error", "fatal")}
        files = {**files, "dotify": lambda value: value}
        own = {**files, **told, "print_location": lambda: "", "tokenize": tokenize, "arg": self._argument}
        commands = {"find": find, "env": environment.required, "optenv": environment.optional}
        self._in_commands = {
            **{"true": True, "false": False, "arg": lambda name: self._converted(self._argument(name))},
            **{**commands, **MATH, **PYTHON},
        }
        self._symbols = {name: PYTHON[name] for name in DIRECT} | MATH | files
        for name, names in {"python": PYTHON, "math": MATH, "xacro": own}.items():
            self._symbols[name] = xacro.NameSpace()
            self._symbols[name].update(names)
        self._expressions = Expressions(xacro.Table, own, self._in_commands)
        vars(substitution_args).update(
            {f"_eval_{name}": command for name, command in commands.items()}, _eval=self._eval
        )
        self.functions = {
            **{"_global_symbols": self._symbols, "eval_text": self.text},
            **{"safe_eval": self._expression, "eval_extension": self._command},
        }
        """What replaces xacro's."""

    def text(self, text: str, symbols: Any) -> Any:
        """A text with its expressions and commands replaced. xacro's own function is slow on plain texts."""
        return self._eval_text(text, symbols) if _MARKED.search(text) else text

    def number(self, expression: str) -> float:
        """The value of an expression in YAML, with the global names only."""
        return float(self._expression(expression, self._symbols))

    def _expression(self, expression: Any, symbols: Mapping[str, Any]) -> Any:
        """The value of `${expression}`."""
        return self._expressions.evaluate(str(expression), symbols)

    def _command(self, text: str) -> str:
        """The text of `$(command)`."""
        if text == "$(cwd)":
            return WORKING_FOLDER
        if text[2:-1].split()[:1] not in (["arg"], ["find"], ["env"], ["optenv"], ["eval"]):
            allowed = "$(arg NAME), $(find PACKAGE), $(env NAME), $(optenv NAME …), $(eval …), $(cwd)"
            raise self._xacro.XacroException(f"{text} is none of {allowed}")
        try:
            return str(self._commands.resolve_args(text, self._xacro.substitution_args_context))
        except self._commands.ArgException as error:
            raise self._xacro.XacroException(f"Undefined substitution argument {error}") from error
        except Exception as error:
            raise self._xacro.XacroException(exc=error) from error

    def _eval(self, expression: str, context: Mapping[str, Any]) -> str:
        """The text of `$(eval expression)`, whose names are the arguments too."""
        arguments = {name: self._converted(value) for name, value in context["arg"].items()}
        return str(self._expressions.evaluate(expression, arguments | self._in_commands))

    def _converted(self, text: Any) -> Any:
        return self._commands.convert_value(str(text), "auto")

    def _argument(self, name: str) -> Any:
        arguments = self._xacro.substitution_args_context["arg"]
        if name not in arguments:
            raise self._xacro.XacroException(f"Undefined substitution argument {name}")
        return arguments[name]


def tokenize(text: str, sep: str = ",; ", skip_empty: bool = True) -> list[str]:
    """xacro's function. `sep` lists characters. Characters that would make it a pattern are refused."""
    if set("]\\^") & set(sep) or "-" in sep[1:-1]:
        what = f"the separators {sep[:40]!a} are not allowed"
        raise Refused(REFUSED, what, "list characters; none of ] \\ ^, - last")
    words = re.split(f"[{re.escape(sep)}]", text)
    return [word for word in words if word] if skip_empty else words
