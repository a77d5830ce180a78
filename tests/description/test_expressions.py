"""Expressions of xacro: what robots' files use is as in Python; nothing reaches out, nothing runs away."""

from __future__ import annotations

import math
from types import SimpleNamespace
from xml.sax.saxutils import quoteattr

import pytest

from hostile.sandbox import Sandbox
from hostile.sandbox import place as place
from twistarm.description.expansion.expressions import Expressions
from twistarm.description.expansion.names import DIRECT, math_names, python_names, tokenize
from twistarm.description.expansion.work import MAX_WORK, Refused, Work


class Space(dict[str, object]):
    """Stands for xacro's namespaces."""


class Dotted(dict[str, object]):
    """Stands for loaded YAML."""


CONFIG = Dotted(a=Dotted(b=3, c=[1, 2]), limit=Dotted(lower=-1.5, upper=2.5))
NAMES = {"x": 3, "name": "left_arm", "xyz": "0 0.5 1", "fingers": ["TH", "ff"], "rates": {"a": 1, "b": 2}, "off": None}

USED_IN_THE_FIELD = [
    "pi/2",
    "-x * 0.5 + 2**3 // 2 % 5",
    "1./12 * x * (3 * 0.1**2 + 0.2**2)",
    "radians(90) + sin(pi) + atan2(1, 2) + sqrt(2)",
    "math.pi - math.cos(0) + math.factorial(5) + math.comb(5, 2) + math.prod([2, 3]) + math.lcm(4, 6)",
    "x if name == 'left_arm' else -x",
    "name in ('left_arm', 'right_arm') and not x < 2 or x != 3",
    "0 < x <= 3",
    "off is None",
    "float(xyz.split()[1]) + x",
    "[str(i) + f for i, f in python.enumerate(fingers) if f.isupper()]",
    "dict(joint_1=0.0, joint_2=-1.57)['joint_2']",
    "{'a': 1, 'b': 2}['a'] + {3: 4}.get(5, 6)",
    "{k: v * 2 for k, v in rates.items()}",
    "list(python.set(fingers) - python.set(['TH'] if not off else []))",
    "python.isinstance(fingers, list)",
    "', '.join(sorted(fingers))",
    "'%s_%02d' % (name, x)",
    "'model_2024_%d%%' % x + '%5.2f' % rates['a']",
    "max(1, min(x, 2)) + round(2.567, 1) + len(fingers) + int('4') + python.abs(-2)",
    "python.sum([1, 2, 3]) + python.sum(i * i for i in range(4))",
    "list(map(str, [1, 2]))",
    "list(python.zip(fingers, [1, 2]))",
    "list(python.reversed([1, 2]))",
    "list(python.filter(None, [0, 1]))",
    "name.replace('left', 'right').startswith('right')",
    "name[:4] + name[-1] + name[::2]",
    "fingers + ['rf'] * 2",
    "(1, 2) + (3,)",
    "x << 2 | 1 & 3 ^ 5 >> 1",
    "~x + +x",
    "python.type(x) == python.int",
    "dict(rates, key=3)",
    "[c for c in name.rsplit('_', 1)] + sorted(rates.items())",
    "[key for key in rates.keys()] + list(rates.values())",
    "'ft' in name and 'x' not in name and 1 in {1, 2}",
    "inf > x and e < tau",
    "x ** -1 + 2.0 ** 0.5",
    "{'f': sin}['f'](0) + {'f': cos}['f'](0)",
]

HOSTILE = [
    # out of the language
    "().__class__",
    "(lambda: ().__class__.__bases__[0].__subclasses__())()",
    "'{0.__class__.__mro__}'.format(1)",
    "f'{().__class__}'",
    "(c := ().__class__)",
    "(i for i in [1]).gi_frame.f_back.f_globals",
    "xacro.load_yaml.__globals__['os'].system('touch @MARKER')",
    "python.vars(python.type)['__subclasses__'](python.type(()))",
    "python.type('X', (), dict())",
    "list(map(python.type(python.type(1)), ['X'], [(list,)], [dict()]))",
    "max(['touch @MARKER'], key=python.type(len))",
    "list[str]('abc')",
    "xacro.parent",
    "math.clear()",
    "[0 for math['pi'] in [3]]",
    "__builtins__['open']('@SECRET')",
    "().\uff3f\uff3fclass\uff3f\uff3f",
    "getattr((), '_' + '_class_' + '_')",
    "b'touch'",
    "x @ x",
    "[1][0, 1:2]",
    "[j async for j in [1]]",
    "xacro.load_yaml('@SECRET')",
    "xacro.load_yaml('\\x00')",
    "...",
    "xacro.load_yaml('\\ud800')",
    "python.set([(1, 2)])",
    "dict([((1, 2), 3)])",
    "10**4000",
    # out of bounds
    "[*a, *a]",
    "{**a, **a}",
    "[b for a, *b in [[1, 2]]]",
    "'%(())4000000000d' % {'()': 1}",
    "('%(a)s' * 100000) % {'a': 'x' * 100000}",
    "'%' % ()",
    "max([1000] * 500000, key=math.factorial)",
    "[1].sort(key=math.factorial)",
    "{(1, 2)}",
    "{(i, 2) for i in [1]}",
    "{'a': 1}.items() | {'b': 2}.items()",
    "python.frozenset([1])",
    "[1].append(2)",
    "9**9**9",
    "1 << 10**9",
    "[0] * 10**10",
    "[[0] * 1000] * 1000 * 1000",
    "'%1000000000d' % 1",
    "('%999d' * 200000) % python.tuple([1] * 200000)",
    "range(10**30)",
    "[1 for a in range(999) for b in range(999) for c in range(999)]",
    "python.sum([[0]] * 100000, [])",
    "list(python.zip(*[range(10**6)] * 10))",
    "math.factorial(10**6)",
    "math.comb(10**6, 5 * 10**5)",
    "math.prod(range(1, 10**5))",
    "math.lcm(*range(1, 10**5))",
    "round(5, -10**9)",
    "'a'.zfill(10**10)",
    "('a' * 1000).replace('a', 'b' * 10000).replace('b', 'c' * 10000)",
    "('a' * 100000).join(['b'] * 100000)",
    "int('f' * 10**6, 16)",
    "{i * (2**61 - 1): 0 for i in range(100000)}",
    "python.set([python.int(str(i) + '0' * 61, 2) for i in range(100000)])",
    "[s[:] for i in range(10**5) for s in ['a' * 10**6]]",
    "[s == t for i in range(10**5) for s, t in [('a' * 10**6, 'a' * 10**6 + '')]]",
    "xacro.tokenize('a' * 40 + '!', sep=']|(a+)+$[')",
    "(" * 3000 + "1" + ")" * 3000,
    "-" * 9000 + "1",
    "1+" * 4000 + "1",
    "1+" * 400 + "1",
    "[" + "1," * 6000 + "]",
    "x.a" * 4000,
]


def evaluator(work: Work | None = None) -> tuple[Expressions, dict[str, object]]:
    """The expressions without xacro around them, and their names."""
    expressions = Expressions(work or Work(), Space)
    python, mathematics = python_names(expressions), math_names(expressions)
    spaces = {"python": Space(python), "math": Space(mathematics)}
    direct = {name: python[name] for name in DIRECT}
    return expressions, {**direct, **mathematics, **spaces, **NAMES, "config": CONFIG}


@pytest.mark.parametrize("expression", USED_IN_THE_FIELD)
def test_what_robots_use_means_what_it_means_in_python(expression: str) -> None:
    import builtins

    expressions, names = evaluator()
    plain = {**vars(math), **NAMES, "math": math, "python": builtins}
    assert expressions.evaluate(expression, names) == eval(expression, plain)


def test_dots_are_items_of_namespaces_and_yaml() -> None:
    expressions, names = evaluator()
    assert expressions.evaluate("config.a.b + config['a'].c[1] - config.limit.lower", names) == 6.5
    assert expressions.evaluate("config.a.get('b')", names) == 3
    assert expressions.evaluate("math.sin(0) + python.len([1])", names) == 1
    with pytest.raises(NameError, match="name 'nothing' is not defined"):
        expressions.evaluate("math.nothing", names)


def test_namespaces_are_not_objects() -> None:
    """xacro's own Table has attributes that lead out; only its items count."""
    expressions, names = evaluator()
    names["math"].parent = SimpleNamespace(secret=1)  # type: ignore[attr-defined]
    with pytest.raises(NameError):
        expressions.evaluate("math.parent.secret", names)


@pytest.mark.parametrize("expression", HOSTILE, ids=lambda text: text[:50])
def test_hostile_expressions_are_refused_in_one_line(expression: str, place: Sandbox) -> None:
    """Handed in as an argument's default, where braces and parentheses are not xacro's."""
    argument = f'<xacro:arg name="evil" default={quoteattr(place.fill(expression))}/>'
    message = place.refuse(f'{argument}<xacro:property name="x" value="3"/><link name="${{$(arg evil)}}"/>')
    assert "arm.xacro" in message


@pytest.mark.slow
@pytest.mark.parametrize("expression", HOSTILE, ids=lambda text: text[:50])
def test_the_whole_of_what_is_allowed_is_over_in_seconds(expression: str, place: Sandbox) -> None:
    place.work = MAX_WORK
    test_hostile_expressions_are_refused_in_one_line(expression, place)


@pytest.mark.parametrize("expression", HOSTILE[::8], ids=lambda text: text[:50])
def test_hostile_commands_are_refused_in_one_line(expression: str, place: Sandbox) -> None:
    """`$(eval ...)`, reached with its parentheses through a property."""
    command = quoteattr("eval " + place.fill(expression))
    message = place.refuse(f'<xacro:property name="c" value={command}/><link name="$(${{c}})"/>')
    assert "arm.xacro" in message


@pytest.mark.parametrize(
    ("expression", "words"),
    [
        ("(lambda: 1)()", "a lambda"),
        ("x.__class__", "the attribute .__class__ of a int"),
        ("''.format(1)", "join texts with"),
        ("'a'.encode()", "allowed: capitalize"),
        ("max([1], key=len)", "key="),
        ("dict(**x)", "unpacking with **"),
        ("python.set([(1, 2)])", "a tuple as a key"),
        ("dict([('a', 1)])", "a dict() of pairs"),
        ("'%(a)s' % 1", "write fields such as %s"),
        ("1j", "use numbers and texts"),
        ("(-1) ** 0.5", "a complex is no value"),
        ("xacro.load_yaml('bytes.yaml')", "a bytes is no value"),
        ("xacro.tokenize('a', sep='^,')", "the separators"),
        ("math", "a namespace is no value"),
        ("python.type(len)(1)", "a function is no value"),
        ("'a' * 10**10", "more work"),
        ("2**20000", "bits"),
    ],
)
def test_a_refusal_names_the_expression_and_the_cause(expression: str, words: str, place: Sandbox) -> None:
    binary = {"bytes.yaml": "!!binary JTEwMDAwZA=="}
    found = place.refuse(f'<xacro:property name="x" value="3"/><link name="${{{expression}}}"/>', binary)
    assert words in found
    assert f"(in ${{{expression}}})" in found


def test_work_is_counted_alike_everywhere() -> None:
    work = Work()
    expressions, names = evaluator(work)
    expressions.evaluate("[i * i for i in range(100)]", names)
    first = MAX_WORK - work.left
    expressions.evaluate("[i * i for i in range(100)]", names)
    once = MAX_WORK - work.left - first
    expressions.evaluate("[i * i for i in range(100)]", names)
    assert MAX_WORK - work.left == first + 2 * once
    assert first > once, "compiling is paid for"
    assert 100 < once < 5000


LONG_TEXT, SOUGHT = "a" * 20_000, "a" * 5000 + "b" + "a" * 4999
PAID = {
    **{
        f"text.{search}": (MAX_WORK, {"text": LONG_TEXT, "sought": SOUGHT})
        for search in ("find(sought)", "replace(sought, 'b')", "rsplit(sep=sought)", "split(sought)",
                       "partition(sought)", "strip(sought)")
    },
    **dict.fromkeys(("text.split()[0]", "list(text)", "python.enumerate(values=text)"),
                    (60_000, {"text": "a b" * 20_000})),
    "[nested]": (5_000, {"nested": {"a": [0] * 10_000}}),
    "large == larger": (5_000, {"large": [0] * 3_000, "larger": [0] * 3_000}),
}  # fmt: skip
"""Searches by both lengths, texts by the pieces they are taken into, comparisons by what they compare."""


@pytest.mark.parametrize("expression", PAID)
def test_work_is_paid_for_by_the_sizes_of_what_takes_part(expression: str) -> None:
    allowed, values = PAID[expression]
    expressions, names = evaluator(Work(allowed))
    with pytest.raises(Refused, match="more work than any robot"):
        expressions.evaluate(expression, {**names, **values})


def test_the_separators_of_tokenize_are_characters() -> None:
    assert tokenize("a,b;c d") == ["a", "b", "c", "d"]
    assert tokenize("a+b-c_d", "+_-") == ["a", "b", "c", "d"]
    assert tokenize("a.b[c(d", ".[(") == ["a", "b", "c", "d"]
    assert tokenize("a,,b", ",", skip_empty=False) == ["a", "", "b"]
    for separators in ("^,", "+-_", "\\s", "]"):
        with pytest.raises(Refused, match="the separators .* are not allowed"):
            tokenize("a", separators)
