"""xacro's expressions, examined before Python evaluates them.

An expression may compute. A dot reaches an item of a namespace or of loaded YAML, or a method of a text, a number or a
list. It never reaches another attribute: attributes lead from any object to all of Python. There are no builtins beyond
those that xacro offers.
"""

from __future__ import annotations

import ast
import functools
import warnings
from types import CodeType
from typing import Any

from ..document import Refused

REFUSED = "xacro-expression-refused"

# Types of values whose methods only compute.
DATA = (str, bool, int, float, complex, list, tuple, dict, set, frozenset, range)
OUT = ("format", "format_map")  # Methods that reach attributes by themselves.
LEFT_OUT = ("vars", "hash", "slice")  # Functions of xacro that lead out of expressions.

# What changes names, or waits.
NOT_COMPUTING = (ast.NamedExpr, ast.Await, ast.Yield, ast.YieldFrom)


class _Guarded(ast.NodeTransformer):
    """Calls our function for each attribute."""

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        reach = ast.Name("__attribute__", ast.Load())
        return ast.Call(reach, [self.visit(node.value), ast.Constant(node.attr)], [])


def evaluate(expression: str, names: Any, namespace: Any) -> Any:
    """The value of an expression with these global names. `namespace` is the type of xacro's scopes.

    Raises Refused, or Python's error for a mistake in it.
    """

    def attribute(value: Any, name: str) -> Any:
        if isinstance(value, namespace):
            try:
                return value[name]
            except KeyError:
                raise NameError(f"name {name!r} is not defined") from None
        if isinstance(value, DATA) and not name.startswith("_") and name not in OUT:
            return getattr(value, name)  # a class of xacro makes items of a dictionary of its attributes
        what = f"the attribute .{name} of a {type(value).__name__} is not allowed"
        raise Refused(REFUSED, what, "join texts with + and str()" if name.startswith("format") else "")

    names.update(__builtins__={"__attribute__": attribute})
    value = eval(_compiled(expression.strip()), names)
    if isinstance(value, namespace) or (callable(value) and not isinstance(value, type)):
        raise Refused(REFUSED, f"the result is a {type(value).__name__}", "call it, or name one of its items")
    return value


def type_of(value: Any) -> type:
    """The type of data, in place of `type`, which makes classes, and these call what they are given."""
    if not isinstance(value, (*DATA, type(None))):
        raise Refused(REFUSED, "a type of this value is not allowed", "compare numbers, texts and lists")
    return type(value)


@functools.lru_cache(4096)
def _compiled(expression: str) -> CodeType:
    """The code. Refused if a part of the syntax tree is not allowed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about odd expressions, which nobody who reads the file can mend
        tree = ast.parse(expression, mode="eval")
        for node in ast.walk(tree):
            is_target = isinstance(node, ast.Attribute | ast.Subscript) and not isinstance(node.ctx, ast.Load)
            if is_target or isinstance(node, NOT_COMPUTING) or getattr(node, "is_async", False):
                raise Refused(REFUSED, "an expression that does more than compute", "use names, operators and calls")
            for name in (getattr(node, field, None) for field in ("id", "attr", "arg")):
                if isinstance(name, str) and name.startswith("__"):
                    raise Refused(REFUSED, f"the name {name} is not allowed", "use the names that xacro offers")
        return compile(ast.fix_missing_locations(_Guarded().visit(tree)), "<expression>", "eval")
