"""Overrides that Hydra's grammar does not accept, or that choose no option: the message names the character."""

from __future__ import annotations

import shlex

import pytest

from rl_design_space.config.grammar import parse, sweep_size
from rl_design_space.errors import ConfigError

HINT = "overrides look like key=value, e.g. exploration.k=0.02"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("goals", f"not an override; {HINT}"),
        ("outputs=a#b", "character 10, \"#\", cannot be used here; quoted, it is text: 'outputs=\"a#b\"'"),
        (
            "tracking.experiment=a(b",
            "character 22, \"(\", is not closed; quoted, it is text: 'tracking.experiment=\"a(b\"'",
        ),
        ("outputs=f(a", "character 10, \"(\", is not closed; quoted, it is text: 'outputs=\"f(a\"'"),
        ("msa.lengths=[2,[3]", 'character 13, "[", is not closed; quoted, it is text: \'msa.lengths="[2,[3]"\''),
        ('outputs=a"b', 'character 10, """, cannot be used here; quoted, it is text: \'outputs="a\\"b"\''),
        ("wor ld.size=3", 'character 4, " ", cannot be used here'),
        ("seed=range(a,b)", "mismatch type argument start: str is incompatible with Union[int, float]"),
        ("seed=nope(1)", "Unknown function 'nope' Available: bool,choice,"),
        ("seed=range(0,10,0)", "the step of a range should not be 0"),
        ("seed=range(0,1,0.0)", "the step of a range should not be 0"),
        ("seed=range(0,3),7", "a sweep cannot be one of several values"),
        ("world.size=[range(2,4),3]", "a sweep cannot be one of several values"),
        ("representation=glob(d*),ad_hoc", "a sweep cannot be one of several values"),
        ("seed=range(0,inf)", "a range should begin and end at a number"),
        ("seed=range(0,1,nan)", "a range should begin and end at a number"),
        *(
            (text, "name exactly one option")
            for text in (
                *("world=10", "world=null", "world=[inf,1]", 'world=""', "world=[???]"),
                *('representation="",a:b:c', "representation=ad_hoc,1", "representation=range(0,3)", "+study=null"),
                *("world=[[torus]]", "hydra=bool(1)", "hydra/launcher=[null]", "~tracking=0.1", "+world@x=[[torus]]"),
            )
        ),
    ],
)  # fmt: skip
def test_a_refused_override_names_what_is_wrong_with_it(text: str, message: str):
    with pytest.raises(ConfigError) as caught:
        parse(["seed=1", text])
    assert str(caught.value).startswith(f"{text}: {message}")


@pytest.mark.parametrize("text", ["outputs=a#b", "outputs=it's here", 'outputs=a"b', "outputs=ε", "seed=["])
def test_the_quoted_form_is_the_same_text(text: str):
    with pytest.raises(ConfigError, match="quoted, it is text: ") as caught:
        parse([text])
    (quoted,) = shlex.split(str(caught.value).rpartition("it is text: ")[2])
    (override,) = parse([quoted])
    assert f"{override.key_or_group}={override.value()}" == text


def test_a_password_is_not_shown():
    with pytest.raises(ConfigError) as caught:
        parse(["tracking.uri=postgresql://me:secret@host/(a"])
    assert "secret" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("seed=1", 1), ("~seed", 1), ("study=null", 1), ("seed=1,2", 2), ("seed=choice(1,2,3)", 3),
        ("exploration.k=interval(0,1)", 1), ("seed=range(0,10,3)", 4), ("seed=range(10,0,-3)", 4),
        ("seed=range(3,0)", 0),
        ("exploration.k=range(0,1,0.3)", 4), ("exploration.k=range(0,0.9,0.3)", 4), ("exploration.k=range(1,0,0.5)", 0),
        ("seed=shuffle(range(0,10))", 10), (f"seed=range(0,{10**30})", 10**30),
    ],
)  # fmt: skip
def test_the_values_of_an_override_are_counted_without_being_listed(text: str, size: int):
    (override,) = parse([text])
    assert sweep_size(override) == size
    if override.is_discrete_sweep() and size < 100:
        assert len(list(override.sweep_iterator())) == size
