"""Descriptions of a file and of its keys from YAML comments."""

from __future__ import annotations

import pytest

from rl_design_space.catalogue.comments import first_sentence, key_comments, leading_comment

TEXT = """\
# @package _global_
# yaml-language-server: $schema=schema.json

# What the file is, e.g. an option. More of
# it.
first: 1 # behind

# above,
# in two lines
second: [1, 2]

# of a group

third:
  # of the inner one
  inner: "a # b" # really behind
block: # of the block
  - 1
defaults:
  - world: torus
  - study: null # of the study
plain: '#'
last: a#b"""


def test_the_leading_comment_follows_directives():
    assert leading_comment(TEXT) == "What the file is, e.g. an option. More of it."


@pytest.mark.parametrize("text", ["", "a: 1", "# @package x", "\n\na: 1 # b", "a: 1\n# b"])
def test_a_file_may_have_no_leading_comment(text: str):
    assert leading_comment(text) == ""


def test_the_comment_of_a_key_is_behind_it_or_above_it():
    assert key_comments(TEXT) == {
        "first": "behind",
        "second": "above, in two lines",
        "third.inner": "really behind",
        "block": "of the block",
        "defaults.study": "of the study",
    }


def test_a_comment_at_the_beginning_describes_the_file():
    assert key_comments("# the file\nkey: 1\n") == {}


@pytest.mark.parametrize("text", ["", "# only a comment", "- a # list\n- b", "text"])
def test_a_file_without_keys_has_no_comments_of_keys(text: str):
    assert key_comments(text) == {}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("One. Two.", "One"),
        ("Table 4 (section 3.5): steps, e.g. of 100. Next", "Table 4 (section 3.5): steps, e.g. of 100"),
        ("Which is it? Table 4.", "Which is it?"),
        ("no end", "no end"),
        ("ε = start·l^(-τ)", "ε = start·l^(-τ)"),
        ("", ""),
    ],
)
def test_the_first_sentence_is_the_summary(text: str, sentence: str):
    assert first_sentence(text) == sentence
