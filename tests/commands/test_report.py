"""The arguments of `rl-design-report`, and the study that `all` stands for."""

from __future__ import annotations

from pathlib import Path

import pytest

from rl_design_space._paths import CONF
from rl_design_space.commands.report import main, study_of_all
from rl_design_space.config.user_config import used
from rl_design_space.errors import ConfigError

SHIPPED = (CONF / "study" / "paper.yaml").read_text(encoding="utf-8")


def chosen_beside(folder: Path, **studies: str) -> str:
    """Return the study of all reports beside studies of the user's own."""
    (folder / "study").mkdir()
    for name, text in studies.items():
        (folder / "study" / f"{name}.yaml").write_text(text, encoding="utf-8")
    with used(folder):
        return study_of_all()


def without_default(text: str) -> str:
    """Return a page as files had it before `default` was a key."""
    return "".join(line for line in text.splitlines(keepends=True) if "default:" not in line)


def test_the_shipped_page_is_the_default():
    assert study_of_all() == "paper"


def test_a_page_of_the_users_own_is_not_taken_unless_it_is_the_default(tmp_path: Path):
    assert chosen_beside(tmp_path, mine=without_default(SHIPPED)) == "paper"


def test_the_only_page_needs_no_key(tmp_path: Path):
    assert chosen_beside(tmp_path, paper=without_default(SHIPPED)) == "paper"


def test_two_default_pages_are_refused_by_name(tmp_path: Path):
    with pytest.raises(ConfigError, match=r"all: needs one study .* default: true, not 2 \(mine, paper\)"):
        chosen_beside(tmp_path, mine=SHIPPED)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["outputs=x", "table3"], "comes first, as in `rl-design-report table3 outputs=x`"),
        (["outputs=x", "heatmap", "--rows", "seed"], "comes first, as in `rl-design-report heatmap outputs=x`"),
        (["tracking.uri=sqlite:///x"], "comes first, as in `rl-design-report table4 tracking.uri=sqlite:///x`"),
        (["table4", "study=fig3"], "study=fig3: `rl-design-report fig3` writes the report of that study"),
        (["table4", "--labels", "a=b", "study=fig3"], "`rl-design-report fig3` writes the report of that study"),
    ],
)
def test_the_name_of_a_report_comes_before_settings_and_once(
    arguments: list[str], message: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr("sys.argv", ["rl-design-report", *arguments])
    monkeypatch.setattr("rl_design_space.commands.report.handle_interrupts", lambda *_: None)
    with pytest.raises(SystemExit) as exit_:
        main()
    assert exit_.value.code == 2
    assert capsys.readouterr().err.endswith(f"{message}\n")
