"""A small language of expressions over the values of a design point, for constraints.

It is a part of Python's grammar: numbers, texts, comparisons, `and`, `or`, `not`, arithmetic, `in`, lists, indices,
`… if … else …`, comprehensions, and a few functions. It has names for the values of the point and for nothing else: no
attributes of objects, no methods, no imports. Numbers, sizes and the number of steps are limited, so that every
expression ends at once. The tree is interpreted, not compiled: a kind of node without a method here does not exist.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from numbers import Integral, Real
from typing import Any

from rl_design_space.errors import ConfigError

#: Maximum numbers: characters of an expression, steps of an evaluation, items of a list with all lists in it, absolute
#: value of an integer, absolute value of an exponent or number of decimal places.
CHARACTERS, STEPS, ITEMS, LARGEST, EXPONENT = 2_000, 100_000, 10_000, 2**63, 64
#: Functions that an expression may call.
FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    function.__name__: function for function in (abs, all, any, len, max, min, range, round, set, sum)
}
_OPERATORS: Mapping[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Not: operator.not_,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda item, items: item in items,
    ast.NotIn: lambda item, items: item not in items,
}
#: Parts of nodes that are not evaluated themselves.
_PARTS = (ast.boolop, ast.expr_context, ast.comprehension, ast.keyword, ast.Slice)
_PLAIN = (str, int, float, type(None), Real)


class Expression:
    """A parsed expression.

    Args:
        text: the expression.

    Raises:
        ConfigError: it is not an expression of this language.
    """

    def __init__(self, text: str) -> None:
        if len(text) > CHARACTERS:
            raise ConfigError(f"should have at most {CHARACTERS:,} characters")
        try:
            self._tree = ast.parse(text.strip(), mode="eval").body
            nodes = list(ast.walk(self._tree))
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            reason = error.msg if isinstance(error, SyntaxError) else str(error) or "too many operators"
            raise ConfigError(f"should be a Python expression: {reason}") from error
        for node in reversed(nodes):  # the innermost first
            if not _is_known(node):
                found = ast.get_source_segment(text.strip(), node) or type(node).__name__
                raise ConfigError(f"{found}: not part of an expression; docs/sweeps.md says what is")

    def value(self, value_of: Callable[[str], Any]) -> Any:
        """Evaluate the expression.

        Args:
            value_of: returns the value of a dotted name; raises ConfigError if there is none.

        Raises:
            ConfigError: it cannot be evaluated.
        """
        try:
            return _Evaluation(value_of).visit(self._tree)
        except RecursionError as error:
            raise ConfigError("has too many operators inside each other") from error
        except (ArithmeticError, LookupError, TypeError, ValueError) as error:
            raise ConfigError(str(error)) from error


class _Evaluation(ast.NodeVisitor):
    """One evaluation of an expression.

    Args:
        value_of: returns the value of a dotted name.
    """

    def __init__(self, value_of: Callable[[str], Any]) -> None:
        self._value_of = value_of
        #: Values of the variables of comprehensions.
        self._variables: dict[str, Any] = {}
        self._steps = 0

    def visit(self, node: ast.AST) -> Any:
        """Return the value of a node; every item of it counts as a step.

        Raises:
            ConfigError: it is too large, is not a plain value, or has taken too long.
        """
        value = super().visit(node)
        self._steps += _size(value)
        if self._steps > STEPS:
            raise ConfigError(f"takes more than {STEPS:,} steps")
        return value

    def visit_Constant(self, node: ast.Constant) -> Any:
        return node.value

    def visit_Name(self, node: ast.Name) -> Any:
        return self._variables[node.id] if node.id in self._variables else self._value_of(node.id)

    def visit_Attribute(self, node: ast.Attribute) -> Any:
        name = _dotted(node)
        if name.partition(".")[0] in self._variables:
            raise ConfigError(f"{name}: only choices have values with a dotted name")
        return self._value_of(name)

    def visit_Tuple(self, node: ast.Tuple) -> Any:
        return tuple(map(self.visit, node.elts))

    def visit_List(self, node: ast.List) -> Any:
        return [*map(self.visit, node.elts)]

    def visit_Set(self, node: ast.Set) -> Any:
        return {*map(self.visit, node.elts)}

    def visit_BoolOp(self, node: ast.BoolOp) -> Any:
        value = None
        for operand in node.values:
            value = self.visit(operand)
            if bool(value) is isinstance(node.op, ast.Or):
                break
        return value

    def visit_UnaryOp(self, node: ast.UnaryOp) -> Any:
        value = self.visit(node.operand)
        return _OPERATORS[type(node.op)](value if isinstance(node.op, ast.Not) else _number(value))

    def visit_BinOp(self, node: ast.BinOp) -> Any:
        left, right = _number(self.visit(node.left)), _number(self.visit(node.right))
        if isinstance(node.op, ast.Pow) and abs(right) > EXPONENT:
            raise ConfigError(f"an exponent is at most {EXPONENT}")
        return _OPERATORS[type(node.op)](left, right)

    def visit_Compare(self, node: ast.Compare) -> Any:
        left = self.visit(node.left)
        for operation, comparator in zip(node.ops, node.comparators, strict=True):
            right = self.visit(comparator)
            if not _OPERATORS[type(operation)](left, right):
                return False
            left = right
        return True

    def visit_IfExp(self, node: ast.IfExp) -> Any:
        return self.visit(node.body if self.visit(node.test) else node.orelse)

    def visit_Subscript(self, node: ast.Subscript) -> Any:
        place = node.slice
        if not isinstance(place, ast.Slice):
            return self.visit(node.value)[self.visit(place)]
        bounds = [bound and self.visit(bound) for bound in (place.lower, place.upper, place.step)]
        return self.visit(node.value)[slice(*bounds)]

    def visit_Call(self, node: ast.Call) -> Any:
        name = _dotted(node.func)
        if name not in FUNCTIONS:
            raise ConfigError.unknown("function", name, FUNCTIONS)
        values = [*map(self.visit, node.args)]
        named = {str(keyword.arg): self.visit(keyword.value) for keyword in node.keywords}
        if name == "round" and any(abs(_number(places)) > EXPONENT for places in (*values[1:], *named.values())):
            raise ConfigError(f"round: to at most {EXPONENT} decimal places")
        if name == "sum":
            values = [[*map(_number, value)] if _is_collection(value) else _number(value) for value in values]
        return FUNCTIONS[name](*values, **named)

    def visit_ListComp(self, node: ast.ListComp | ast.SetComp | ast.GeneratorExp) -> Any:
        outer = dict(self._variables)
        found = [self.visit(node.elt) for _ in self._rounds(node.generators)]
        self._variables = outer
        return found

    def visit_GeneratorExp(self, node: ast.GeneratorExp) -> Any:
        return self.visit_ListComp(node)

    def visit_SetComp(self, node: ast.SetComp) -> Any:
        return set(self.visit_ListComp(node))

    def _rounds(self, generators: Sequence[ast.comprehension]) -> Iterator[None]:
        """Yield once for each combination of the variables of a comprehension, when they are set."""
        if not generators:
            yield
            return
        first, *rest = generators
        for item in self.visit(first.iter):
            self._variables[_dotted(first.target)] = item
            if all(map(self.visit, first.ifs)):
                yield from self._rounds(rest)


def _is_known(node: ast.AST) -> bool:
    """Return whether a node is part of the language."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, _PLAIN)
    if isinstance(node, ast.Attribute):
        return isinstance(node.value, (ast.Name, ast.Attribute))
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name)
    if isinstance(node, ast.comprehension):
        return isinstance(node.target, ast.Name)
    if isinstance(node, ast.keyword):
        return node.arg is not None
    return isinstance(node, _PARTS) or type(node) in _OPERATORS or hasattr(_Evaluation, f"visit_{type(node).__name__}")


def _dotted(node: ast.expr) -> str:
    """Return the dotted name that a node writes."""
    if isinstance(node, ast.Attribute):
        return f"{_dotted(node.value)}.{node.attr}"
    assert isinstance(node, ast.Name)
    return node.id


def _number(value: Any) -> Any:
    if not isinstance(value, Real):
        raise ConfigError(f"{value!r}: not a number")
    return value


def _is_collection(value: Any) -> bool:
    return isinstance(value, (tuple, list, set, frozenset, range))


def _size(value: Any) -> int:
    """Return the number of items of a value, with those of the collections in it.

    Raises:
        ConfigError: it has too many, or is not made of numbers, texts and truth values.
    """
    if isinstance(value, _PLAIN):
        if isinstance(value, Integral) and abs(int(value)) > LARGEST:
            raise ConfigError(f"an integer is at most {LARGEST:,}")
        return 1
    if not _is_collection(value):
        raise ConfigError(f"{type(value).__name__}: not a number, text, truth value, or list of them")
    size = len(value)
    for item in value if size <= ITEMS and not isinstance(value, range) else ():
        size += _size(item)
        if size > ITEMS:
            break
    if size > ITEMS:
        raise ConfigError(f"a list has at most {ITEMS:,} items")
    return 1 + size
