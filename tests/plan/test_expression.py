"""The language of constraints: what it knows, and that nothing else is possible."""

from __future__ import annotations

import time
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.errors import ConfigError
from rl_design_space.plan.expression import CHARACTERS, FUNCTIONS, Expression

VALUES = {"world": "torus", "world.size": 5, "world.shape": (5, 5), "msa.lengths": (2, 3), "exploration.k": 0.5}


def value_of(name: str) -> object:
    if name not in VALUES:
        raise ConfigError(f"{name}: no such name")
    return VALUES[name]


@pytest.mark.parametrize(
    "text",
    [
        "world == 'torus' and max(msa.lengths, default=1) >= min(world.shape)",
        "world in {'torus', \"walled\"} or not world.size < 3",
        "world.shape[0] * world.shape[1] - 2 ** 3 // 2 % 3 + -1 / 4",
        "1 < world.size <= 5 != 6",
        "any(length > 2 for length in msa.lengths if length != 2)",
        "[a * b for a in msa.lengths for b in range(a)]",
        "{a % 2 for a in (1, 2, 3)}",
        "sum([1, 2.5], 3) + round(exploration.k, 1) + abs(-2) + len(set(msa.lengths))",
        "'or' in world and world[0:2] == 'to' and msa.lengths[-1] == 3",
        "exploration.k if world.size > 3 else None",
        "exploration.k is not None and True",
        "[msa.lengths for a in (1,) if all((a, True))]",
        "[(a, [b for b in (a, 2)]) for a in (1,)]",
        "max(a for a in world.shape) >= 5 and 'x' not in ['y']",
    ],
)
def test_an_expression_means_what_it_means_in_python(text: str):
    names: dict[str, Any] = dict(FUNCTIONS)
    for name, value in VALUES.items():
        choice, _, key = name.partition(".")
        named = names.setdefault(choice, _Option(VALUES.get(choice, "")))
        setattr(named, key or "itself", value)
    assert Expression(text).value(value_of) == eval(text, names)


class _Option(str):
    """The name of an option, with its values as attributes."""


@pytest.mark.parametrize(
    "text",
    [
        # Ways out of the sandbox that there was.
        "().__class__.__base__.__subclasses__()",
        "world.__class__",
        "world.size.real",
        "world.shape.__class__.__mro__[1]",
        "world.format(1)",
        "abs.__self__",
        "[a for a in (1,)][0].__class__",
        "(lambda: 1)()",
        "(a := 1)",
        "f'{world}'",
        "__import__('os')",
        "print(1)",
        "abs",
        "max(1, 2, key=abs)",
        "[a.real for a in (1,)]",
        "[world.size for world in (1,)]",
        "[a for world.size in (1,)]",
        "[*world.shape]",
        "max(*world.shape)",
        "max(**{})",
        "{1: 2}",
        "b'x'",
        "1j",
        "(-1) ** 0.5",
        "...",
        "await x",
        "(yield)",
        "world.size; world.size",
        "import os",
        "'%s' % world",
        "world + world",
        "[1] + [2]",
        "1 << 2",
        "1 @ 2",
        "",
        "\0",
        "world.size > 'a'",
        "1 / 0",
        "world.shape[9]",
        # What would take for ever, or all memory.
        "9 ** 9 ** 9",
        "2 ** 64",
        "2.0 ** 65",
        "1e999 ** 1e999",
        "10 ** 64 * 10 ** 64",
        f"{'9' * 1900}",
        "'a' * 10 ** 9",
        "(1,) * 10 ** 9",
        "'%999999999d' % 1",
        "round(5, -10 ** 9)",
        "round(5, ndigits=-10 ** 9)",
        "round(1e300)",
        "range(10 ** 12)",
        "sum(range(10 ** 5))",
        "max(range(2 ** 62), 1)",
        "any(a < 0 for a in range(9999) for b in range(9999) for c in range(9999))",
        "[b for a in [range(9999)] for b in [[a, a], [a, a]]]",
        "[1 for a in [[1] * 1] for a in [[1, 1]] " + "for a in [[a, a]] " * 40 + "if a == a]",
        "-" * 1500 + "1",
        "not " * 450 + "1",
        "(" * 500 + "1" + ")" * 500,
        "[" * 500 + "]" * 500,
        "1" + " + 1" * (CHARACTERS // 4),
        "1" + "+1" * 950,
        "world.size" + ".a" * 900,
    ],
)
def test_nothing_else_is_possible_and_all_ends_soon(text: str):
    begun = time.monotonic()
    with pytest.raises(ConfigError) as caught:
        Expression(text).value(value_of)
    assert len(str(caught.value)) < CHARACTERS + 200
    assert time.monotonic() - begun < 5


#: Fragments of which texts are made that are almost expressions.
FRAGMENTS = [
    *"()[]{}.,:+-*/%<>=&|^~@!'\"\\ #\n0", "9", "**", "//", "==", "<=", " and ", " or ", "not ", " in ", " is ", " if ",
    " else ", "for a in ", "a", "lambda a:", "await ", "*", ":=", "f'", "world", "world.size", "world.shape",
    "msa.lengths", "__class__", "None", "True", "1e999", "10", *FUNCTIONS, "range(9)", "[a for a in range(99)]",
]  # fmt: skip


@given(st.lists(st.sampled_from(FRAGMENTS), max_size=12).map("".join))
@settings(max_examples=300, deadline=1000)
def test_any_text_has_a_plain_value_or_a_message(text: str):
    try:
        value = Expression(text).value(value_of)
    except ConfigError:
        return
    assert isinstance(value, (int, float, str, type(None), tuple, list, set, range))
