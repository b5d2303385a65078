"""Limits on YAML: sizes are known before any value exists."""

from __future__ import annotations

from pathlib import Path

import pytest

from rl_design_space.config.yaml_limits import CHARACTERS, DEPTH, VALUES, load_plain, read_text
from rl_design_space.errors import ConfigError

#: Each line doubles the values of the line before.
BOMB = "a0: &a0 [x, x]\n" + "".join(f"a{n}: &a{n} [*a{n - 1}, *a{n - 1}]\n" for n in range(1, 31))
MERGED = "a0: &a0 {k0: x}\n" + "".join(f"a{n}: &a{n} {{<<: [*a{n - 1}, *a{n - 1}]}}\n" for n in range(1, 31))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BOMB, f"more than {VALUES:,} values"),
        (MERGED, f"more than {VALUES:,} values"),
        ("a: &a [*a]", f"more than {VALUES:,} values"),
        ("[" * 100_000, f"more than {DEPTH} collections"),
        ("{a: " * 100_000, f"more than {DEPTH} collections"),
        ("- " * 1000, f"more than {DEPTH} collections"),
        ("&a " + "[" * 25 + "]" * 25 + "\n", ""),
        ("[&a " + "[" * 25 + "]" * 25 + ", " + "[" * 25 + "*a" + "]" * 25 + "]", f"more than {DEPTH} collections"),
        ("x" * (CHARACTERS + 1), f"more than {CHARACTERS:,} characters"),
        (f"[{', '.join('x' * VALUES)}]", f"more than {VALUES:,} values"),
        ("a: 2020-99-99", "not YAML: month"),
        (f"a: {'9' * 5000}", "not YAML: "),
        ("a: !!python/object/apply:os.getcwd []", "not YAML: could not determine a constructor"),
    ],
    ids=[
        "bomb",
        "merged",
        "itself",
        "lists",
        "mappings",
        "blocks",
        "fits",
        "alias",
        "long",
        "wide",
        "date",
        "number",
        "call",
    ],
)
def test_what_is_too_large_is_refused_at_once(text: str, message: str):
    if not message:
        load_plain(text, "my.yaml")
        return
    with pytest.raises(ConfigError, match=r"^my\.yaml: ") as caught:
        load_plain(text, "my.yaml")
    assert message in str(caught.value)


def test_aliases_may_be_used():
    assert load_plain("a: &a {b: 1}\nc: *a\nd: {<<: *a, e: 2}\n", "") == {
        "a": {"b": 1}, "c": {"b": 1}, "d": {"b": 1, "e": 2},
    }  # fmt: skip


def test_no_more_of_a_file_is_read_than_shows_that_it_is_too_large(tmp_path: Path):
    (tmp_path / "my.yaml").write_bytes(b"\xff" + b"x" * (2 * CHARACTERS))
    assert len(read_text(tmp_path / "my.yaml")) == CHARACTERS + 1
