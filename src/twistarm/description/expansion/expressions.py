"""xacro's expressions: checked on their syntax tree, then run with every operation guarded.

What the tree may hold is a list of what arms' descriptions use: numbers, texts, lists, arithmetic, comparisons,
conditions, items, comprehensions and calls. Lambdas, assignments, f-strings, whatever `*` and `**` unpack and names
that begin with two underscores are not on it. Attributes are looked up by `Guards`, which knows no object but
namespaces and loaded YAML, so that nothing of Python itself can be reached, by whatever detour.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from types import CodeType
from typing import Any

from .guards import OPERATORS, REFUSED, Guards, key
from .work import MAX_BITS, SCOPES_PER_UNIT, Refused

MAX_LENGTH = 10_000
"""Longer texts than anyone writes as one expression; Python's parser recurses over them."""

MAX_DEPTH = 200
"""Levels of the syntax tree: a sum of so many terms is one."""

EVALUATION_COST = 10
COMPILATION_COST = 10
"""For each node of the tree, once."""

_WORDS = {
    "Lambda": "a lambda",
    "NamedExpr": "an assignment (:=)",
    "JoinedStr": "an f-string",
    "FormattedValue": "an f-string",
    "TemplateStr": "a t-string",
    "MatMult": "the operator @",
    "Starred": "unpacking with *",
}

_ALLOWED = (
    *(ast.Expression, ast.Constant, ast.Name, ast.Attribute, ast.Subscript, ast.Slice),
    *(ast.Call, ast.keyword),
    *(ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp),
    *(ast.List, ast.Tuple, ast.Set, ast.Dict),
    *(ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp, ast.comprehension),
    *(ast.expr_context, ast.boolop, ast.unaryop, ast.cmpop),
    *(getattr(ast, name) for name in OPERATORS),
)


_COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp)


class Expressions:
    """Evaluates expressions with `guards`; each text is checked and compiled once."""

    def __init__(self, guards: Guards) -> None:
        self._guards = guards
        self._compiled: dict[str, tuple[CodeType, int]] = {}

    def evaluate(self, expression: str, names: Mapping[str, Any]) -> Any:
        """The value of `expression`; Refused, or what Python raises for a mistake in it."""
        known = self._compiled.get(expression)
        if known is None:
            known = self._compiled[expression] = compile_guarded(expression.strip())
            self._guards.work.charge(COMPILATION_COST * known[1])
        code, cost = known
        self._guards.work.charge(cost)
        return self._guards.data(self._guards.work.weigh(eval(code, _Scope(names, self._guards))))


class _Scope(dict[str, Any]):
    """The names of one evaluation: the guards under names that no expression can write, then the caller's."""

    def __init__(self, names: Mapping[str, Any], guards: Guards) -> None:
        super().__init__(
            {
                "__builtins__": {},
                "__operate": guards.operate,
                "__attribute": guards.attribute,
                "__method": guards.method,
                "__call": guards.call,
                "__iterate": guards.iterate,
                "__weigh": guards.work.weigh,
                "__item": lambda value: guards.data(guards.work.weigh(value)),
                "__key": key,
            }
        )
        self._names = names
        self._work = guards.work
        self._cost = getattr(names, "depth", 0) // SCOPES_PER_UNIT

    def __missing__(self, name: str) -> Any:
        self._work.charge(self._cost)
        return self._names[name]


def compile_guarded(expression: str) -> tuple[CodeType, int]:
    """The checked expression as code in which guards stand for operations, and the cost of one evaluation."""
    if len(expression) > MAX_LENGTH:
        raise Refused(REFUSED, f"an expression of more than {MAX_LENGTH} characters", "split it into properties")
    try:
        tree = ast.parse(expression, mode="eval")
    except (RecursionError, MemoryError):
        if len(expression) > MAX_DEPTH:
            raise Refused(REFUSED, "an expression nested that deep", "split it into properties") from None
        raise
    cost = EVALUATION_COST + _check_nodes(tree)
    guarded = ast.fix_missing_locations(_Guarding().visit(tree))
    return compile(guarded, "<expression>", "eval"), cost


def _check_nodes(tree: ast.AST) -> int:
    """How many nodes the tree has; Refused where one of them is not allowed or too deep."""
    count, level = 0, [tree]
    for _ in range(MAX_DEPTH):
        if not level:
            return count
        for node in level:
            if not isinstance(node, _ALLOWED):
                kind = type(node).__name__
                raise Refused(REFUSED, f"{_WORDS.get(kind, kind)} is not allowed", "use names, operators and calls")
        count += len(level)
        level = [child for node in level for child in ast.iter_child_nodes(node)]
    raise Refused(REFUSED, "an expression nested that deep", "split it into properties")


class _Guarding(ast.NodeTransformer):
    """Puts a guard in the place of every operation."""

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        if not isinstance(node.value, (str, int, float, type(None))):
            raise Refused(REFUSED, f"{node.value!r:.40} is not allowed", "use numbers and texts")
        if isinstance(node.value, int) and node.value.bit_length() > MAX_BITS:
            raise Refused(REFUSED, f"a whole number of more than {MAX_BITS} bits", "use a float")
        return node

    def visit_Name(self, node: ast.Name) -> ast.expr:
        _check_name(node.id)
        return node

    def visit_keyword(self, node: ast.keyword) -> Any:
        if node.arg is None:
            raise _unpacked()
        _check_name(node.arg)
        return self.generic_visit(node)

    def visit_Dict(self, node: ast.Dict) -> ast.expr:
        keys: list[ast.expr | None] = []
        for part in node.keys:
            if part is None:
                raise _unpacked()
            keys.append(_guard("__key", self.visit(part)))
        return _guard("__weigh", ast.Dict(keys, [self.visit(value) for value in node.values]))

    def visit_Set(self, node: ast.Set) -> ast.expr:
        return _guard("__weigh", ast.Set([_guard("__key", self.visit(member)) for member in node.elts]))

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        _check_attribute(node)
        return _guard("__attribute", self.visit(node.value), ast.Constant(node.attr))

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        _check_read(node)
        value = self.visit(node.value)
        if isinstance(node.slice, ast.Slice):
            return _guard("__weigh", ast.Subscript(value, self.generic_visit(node.slice), ast.Load()))
        return ast.Subscript(value, _guard("__item", self.visit(node.slice)), ast.Load())

    def visit_Slice(self, node: ast.Slice) -> ast.expr:
        raise Refused(REFUSED, "a slice of several dimensions is not allowed", "slice once")

    def visit_Call(self, node: ast.Call) -> ast.expr:
        arguments = [self.visit(argument) for argument in node.args]
        named = [self.visit(argument) for argument in node.keywords]
        if isinstance(node.func, ast.Attribute):
            _check_attribute(node.func)
            receiver = [self.visit(node.func.value), ast.Constant(node.func.attr)]
            return ast.Call(_name("__method"), [*receiver, *arguments], named)
        return ast.Call(_name("__call"), [self.visit(node.func), *arguments], named)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        return _guard("__operate", ast.Constant(type(node.op).__name__), self.visit(node.left), self.visit(node.right))

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        if any(isinstance(operator, (ast.In, ast.NotIn)) for operator in node.ops):
            if len(node.ops) > 1:
                raise Refused(REFUSED, "`in` between several operands is not allowed", "join comparisons with `and`")
            operands = self.visit(node.left), self.visit(node.comparators[0])
            return _guard("__operate", ast.Constant(type(node.ops[0]).__name__), *operands)
        weighed: list[ast.expr] = [_guard("__weigh", self.visit(part)) for part in (node.left, *node.comparators)]
        return ast.Compare(weighed[0], node.ops, weighed[1:])

    def generic_visit(self, node: ast.AST) -> Any:
        cost = sum(1 for _ in ast.walk(node)) if isinstance(node, _COMPREHENSIONS) else 0
        super().generic_visit(node)
        if isinstance(node, _COMPREHENSIONS):
            for part in node.generators:
                part.iter = _guard("__iterate", part.iter, ast.Constant(cost))
            if isinstance(node, ast.SetComp):
                node.elt = _guard("__key", node.elt)
            if isinstance(node, ast.DictComp):
                node.key = _guard("__key", node.key)
            return _guard("__weigh", node)
        if isinstance(node, (ast.List, ast.Tuple)) and isinstance(node.ctx, ast.Load):
            return _guard("__weigh", node)
        return node

    def visit_GeneratorExp(self, node: ast.GeneratorExp) -> Any:
        """A list instead: a generator would run later, and its frame is a way out."""
        return self.visit(ast.ListComp(node.elt, node.generators))


def _guard(name: str, *arguments: ast.expr) -> ast.Call:
    return ast.Call(_name(name), list(arguments), [])


def _name(name: str) -> ast.Name:
    return ast.Name(name, ast.Load())


def _check_name(name: str) -> None:
    if name.startswith("__"):
        raise Refused(REFUSED, f"the name {name} is not allowed", "names of properties begin otherwise")


def _unpacked() -> Refused:
    return Refused(REFUSED, "unpacking with ** is not allowed", "write each entry")


def _check_attribute(node: ast.Attribute) -> None:
    _check_read(node)
    if node.attr.startswith("_"):
        raise Refused(REFUSED, f"the attribute .{node.attr} is not allowed", "use ['...'] for a key of that name")


def _check_read(node: ast.Attribute | ast.Subscript) -> None:
    if not isinstance(node.ctx, ast.Load):
        raise Refused(REFUSED, "an assignment is not allowed", "expressions compute and change nothing")
