"""Tab completion: commands, options, keys, studies and flags."""

from __future__ import annotations

from pathlib import Path

import pytest

from rl_design_space.commands.completion import answer, suggestions


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("rl-design-space sho", {"show"}),
        ("/usr/bin/rl-design-space st", {"store", "study="}),
        ("rl-design-space world=", {"world=slip", "world=torus", "world=walled", "world=wind"}),
        (
            "rl-design-space study=table",
            {"study=table1", "study=table2", "study=table3", "study=table4", "study=table4_tails"},
        ),
        ("rl-design-space hydra/launcher=design_", {"hydra/launcher=design_dask", "hydra/launcher=design_ray"}),
        ("rl-design-space exploration=linear exploration.s", {"exploration.start="}),
        ("rl-design-space show exploration=l", {"exploration=linear"}),
        ("rl-design-space show world", {"world", "world=slip", "world=torus", "world=walled", "world=wind"}),
        ("rl-design-space show on", {"on_error"}),
        ("rl-design-space list w", {"world"}),
        ("rl-design-space list world ", {"--json"}),
        ("rl-design-space new w", {"world"}),
        ("rl-design-space store ", {"status", "compact"}),
        ("rl-design-space store status th", {"threads="}),
        ("rl-design-space sync see", set()),
        ("rl-design-space watch period=worst exploration=linear exploration.s", {"exploration.start="}),
        ("rl-design-space watch trial=w", {"trial=worst"}),
        ("rl-design-report he", {"heatmap"}),
        ("rl-design-report table", {"table1", "table2", "table3", "table4", "table4_tails"}),
        ("rl-design-report heatmap --r", {"--rows"}),
        ("rl-design-report heatmap --value st", {"steps_after=30"}),
        ("rl-design-report table4 tracking.exp", {"tracking.experiment="}),
    ],
)
def test_what_is_offered(line: str, offered: set[str]):
    assert set(suggestions(line)) == offered


def test_everything_is_offered_before_anything_is_typed():
    assert {"show", "world=", "task.", "seed="} <= set(suggestions("rl-design-space "))
    assert {"all", "curves", "table4"} <= set(suggestions("rl-design-report "))


def test_options_of_the_user_are_offered(tmp_path: Path):
    (tmp_path / "world").mkdir()
    (tmp_path / "world" / "ring.yaml").write_text("_target_: mine.Ring\n", encoding="utf-8")
    assert suggestions(f"rl-design-space --config-dir {tmp_path} world=r") == ["world=ring"]


def test_an_answer_is_for_the_shell_that_asks(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("COMP_LINE", "rl-design-space store s")
    assert answer(["-sc", "query=bash"]) == "status"
    monkeypatch.setenv("COMP_LINE", "rl-design-space store ")
    assert answer(["-sc", "query=fish"]) == "compact\nstatus"
    assert answer(["store", "status"]) is None


def test_both_commands_are_completed_by_the_installed_script(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("sys.argv", ["/bin/rl-design-space"])
    script = answer(["-sc", "install=bash"])
    assert script is not None
    assert script.endswith("-F hydra_bash_completion rl-design-space rl-design-report")
