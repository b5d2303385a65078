"""Importance, the best, interactions and profiles of recorded runs, against numbers computed from the simulations."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from rl_design_space.commands import figure_words as command
from rl_design_space.config.build import construct
from rl_design_space.errors import ConfigError
from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.report import Best, Heatmap, Importance, Interactions, Profile
from rl_design_space.report.base import MAIN, Report
from rl_design_space.report.designs import Designs
from rl_design_space.report.runs import Runs
from tests.points import planned_point
from tests.tracking.stores import copy_database, options, record, tracker_at

SIZE = ("task.trials=6", "world.size=4", "exploration=linear")
REPRESENTATIONS, SLOPES, REWARDS = ("ad_hoc", "direction"), (0.02, 0.1), ("many_rewards", "end_reward")
PERIODS = 12


def learn(*overrides: str) -> LearningCurves:
    return simulate(planned_point([*SIZE, *overrides]).point, threads=1)


#: By representation, slope, reward: two seeds of each design; of one design more periods.
LEARNED = {
    (*key, seed): learn(
        f"representation={key[0]}", f"exploration.k={key[1]}", f"reward={key[2]}", f"seed={seed}",
        f"task.periods={PERIODS + 4 * (key == ('ad_hoc', 0.1, 'many_rewards'))}",
    )
    for key in product(REPRESENTATIONS, SLOPES, REWARDS) for seed in (0, 1)
}  # fmt: skip


@pytest.fixture(scope="module")
def outputs(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("matters")
    copy_database(empty_database, folder / "mlflow.db")
    tracker = tracker_at(folder / "mlflow.db")
    for (name, k, reward, seed), curves in LEARNED.items():
        overrides = [f"representation={name}", f"exploration.k={k}", f"reward={reward}", f"seed={seed}"]
        planned = planned_point([*SIZE, *overrides, f"task.periods={len(curves.steps)}"])
        record(tracker, replace(planned, studies=("mine",)), curves)
    return folder


@pytest.fixture(scope="module")
def runs(outputs: Path) -> Runs:
    reader = options(outputs / "mlflow.db").reader()
    return Runs.of_frame(reader.frame(), reader, "the command")


def y(name: str, k: float, reward: str) -> np.ndarray:
    """Return log(steps / optimum) of the common periods of a design, seed 0 first."""
    parts = [LEARNED[name, k, reward, seed] for seed in (0, 1)]
    return np.concatenate([np.log(p.steps.sum(axis=1) / (6 * p.optimum))[:PERIODS] for p in parts])


CELLS = np.array([[[y(name, k, r) for r in REWARDS] for k in SLOPES] for name in REPRESENTATIONS])


def drawn(figure: Report, runs: Runs) -> tuple[pd.DataFrame, str]:
    frames = figure.frames(runs)
    plt.close(figure.draw(frames))
    assert figure.numbers(frames) or isinstance(figure, Heatmap)
    return frames[MAIN], "\n".join(figure.text(frames))


def test_seeds_are_repetitions_and_only_common_periods_count(runs: Runs):
    designs = Designs(runs)
    assert (len(designs), designs.periods, designs.seeds) == (8, 2 * PERIODS, {0: PERIODS, 1: PERIODS})
    assert designs.names == ["exploration.k", "representation", "reward"]
    (remark,) = designs.remarks()
    assert "8 designs, paired by the 24 periods of 2 seeds" in remark
    assert "up to 32 periods" in remark


def test_importance_is_the_analysis_of_variance_of_the_simulations(runs: Runs):
    frame, text = drawn(Importance(), runs)
    assert list(frame) == ["effect", "share", "low", "high", "total", "total_low", "total_high"]
    # Contrasts of signs are orthogonal: the square of each is the variance that it explains.
    signs = np.array([-1, 1])
    names = {"representation": signs[:, None, None], "exploration.k": signs[None, :, None], "reward": signs}

    def explained(*which: str) -> float:
        contrast = (CELLS * np.prod([names[n] + np.zeros((2, 2, 2)) for n in which], axis=0)[..., None]).mean((0, 1, 2))
        return contrast.mean() ** 2 - contrast.var(ddof=1) / len(contrast)

    single = {name: explained(name) for name in names}
    pairs = {" × ".join(sorted(p)): explained(*p) for p in (("representation", "exploration.k"),
             ("representation", "reward"), ("exploration.k", "reward"))}  # fmt: skip
    rest = explained(*names)
    whole = sum(single.values()) + sum(pairs.values()) + rest
    found = frame.set_index("effect")
    assert found["share"].to_dict() == pytest.approx({n: v / whole for n, v in {**single, **pairs}.items()})
    total = single["reward"] + sum(v for n, v in pairs.items() if "reward" in n) + rest
    assert found.loc["reward", "total"] == pytest.approx(total / whole)
    assert (frame["low"] <= frame["share"]).all()
    assert (frame["share"] <= frame["high"]).all()
    assert "paired by the 24 periods" in text


def test_headings_have_the_words_of_a_scale_or_its_label():
    assert Importance().heading == "What matters for log(steps / optimum)"
    assert Importance(scale="total_steps").heading == "What matters for total_steps"
    assert Interactions(labels={"log_over_optimum": "log ratio"}).heading.endswith(", by log ratio")


def test_importance_by_trial_is_that_of_each_trial(runs: Runs):
    frame = Importance().frames(runs)["_by_trial"]
    assert sorted(frame["first_trial"].unique()) == list(range(6))
    last = frame[frame["first_trial"] == 5].set_index("effect")
    means = np.array(
        [[[np.log(np.concatenate([LEARNED[n, k, r, s].steps[:PERIODS, 5] / LEARNED[n, k, r, s].optimum[:PERIODS]
                                  for s in (0, 1)])) for r in REWARDS] for k in SLOPES] for n in REPRESENTATIONS]
    )  # fmt: skip
    variance = means.mean(axis=3).var() - ((means - means.mean(axis=(0, 1, 2))).var(axis=3, ddof=1) / 24).mean()
    assert last["variance"].iloc[0] == pytest.approx(variance, rel=1e-4)
    assert last["share"].sum() == pytest.approx(1, abs=1e-6)


def test_given_a_choice_the_others_are_decomposed(runs: Runs):
    frame, _ = drawn(Importance(given={"representation": "direction"}, scale="steps_after=3"), runs)
    assert set(frame["effect"]) == {"exploration.k", "reward", "exploration.k × reward"}
    drawn(Importance(given={"representation": "direction"}, scale="total_steps,statistic=median"), runs)
    with pytest.raises(ConfigError, match="representation=distance: no run has this value; there is "):
        Importance(given={"representation": "distance"}).frames(runs)
    one = {"representation": "direction", "exploration.k": 0.1, "reward": "end_reward"}
    with pytest.raises(ConfigError, match="differ in nothing but their seed"):
        Importance(given=one).frames(runs)
    with pytest.raises(ConfigError, match=r"^scale: log: no such measure"):
        construct(Importance, {"scale": "log"})


def test_empty_cells_are_named_where_nothing_can_be_said(runs: Runs):
    def only(*keys: tuple[str, float]) -> Runs:
        points = [p for p in runs.points if (p.parameters["representation"], p.parameters["exploration.k"]) in keys]
        return Runs(points, runs._reader)

    diagonal = only(("ad_hoc", 0.02), ("direction", 0.1))
    with pytest.raises(ConfigError, match=r"2 of 4 combinations have no point: .*exploration\.k=0\.02 repr"):
        Importance(given={"reward": "end_reward"}).frames(diagonal)
    frame, text = drawn(Importance(), diagonal)
    assert set(frame["effect"]) == {"reward"}
    assert "representation: nothing can be said, because" in text
    assert "exploration.k=0.02 representation=direction reward=" in text


def test_the_best_designs_are_paired_and_one_is_the_best_by_any_measure(runs: Runs):
    frame, text = drawn(Best(), runs)
    assert list(frame) == [
        "exploration.k", "representation", "reward", "value", "low", "high", "in_best_set", "loss_at_most",
        "probability_best", "periods_to_decide",
    ]  # fmt: skip
    assert len(frame) == 8
    assert frame["value"].is_monotonic_increasing
    assert frame["in_best_set"].iloc[0]
    assert frame["probability_best"].sum() == pytest.approx(1)
    first = frame.iloc[0]
    key = (first["representation"], first["exploration.k"], first["reward"])
    assert first["value"] == pytest.approx(np.concatenate([LEARNED[*key, s].total_steps for s in (0, 1)]).mean())
    assert "8 designs of 24 to 32 periods of 2 seeds, each two paired by the periods that both have" in text
    assert "among the best" in text
    for statistic in ("median", "iqm", "cvar=25"):
        robust, _ = drawn(Best(statistic=statistic), runs)
        assert robust["in_best_set"].any()
    assert "is the mean of" not in text
    assert "*cvar=25* of 24 periods is the mean of 6" in drawn(Best(statistic="cvar=25"), runs)[1]
    descending, _ = drawn(Best(value="near_share=3"), runs)
    assert descending["value"].is_monotonic_decreasing
    alone, _ = drawn(Best(given={"representation": "ad_hoc", "exploration.k": 0.1, "reward": "end_reward"}), runs)
    assert alone[["in_best_set", "loss_at_most", "probability_best"]].to_numpy().tolist() == [[True, 0, 1]]


def test_cells_of_a_heatmap_that_may_be_the_best_have_a_star(runs: Runs):
    figure = Heatmap(rows="representation,reward", cols="exploration.k")
    frame, text = drawn(figure, runs)
    best = Best().frames(runs)[MAIN]
    names = ["representation", "reward", "exploration.k"]
    both = frame.merge(best, on=names)
    assert (both["in_best_set_x"] == both["in_best_set_y"]).all()
    assert "★: cannot be told from the best cell" in text
    axis = figure.draw({MAIN: frame}).axes[0]
    assert sum("★" in label.get_text() for label in axis.texts) == frame["in_best_set"].sum()
    plt.close(axis.figure)
    assert "in_best_set" not in Heatmap(rows="representation", cols="exploration.k", mean=True).frames(runs)[MAIN]


def test_interactions_are_paired_differences_at_each_value(runs: Runs):
    frame, _ = drawn(Interactions(choice="reward", other="exploration.k"), runs)
    by_k = [(CELLS[:, place, 0] - CELLS[:, place, 1]).mean() for place in (0, 1)]  # many − end
    assert frame["value"].unique().tolist() == ["reward=many_rewards"]
    assert frame["at"].tolist() == ["exploration.k=0.02", "exploration.k=0.1"]
    assert frame["difference"].tolist() == pytest.approx(by_k)
    assert frame["interaction"].tolist() == pytest.approx([(by_k[0] - by_k[1]) / 2, (by_k[1] - by_k[0]) / 2])
    assert (frame["low"] <= frame["difference"]).all()
    strongest, text = drawn(Interactions(), runs)
    top = next(e for e in Importance().frames(runs)[MAIN]["effect"] if " × " in e)
    assert set(strongest["pair"].iloc[0].split(" × ")) == set(top.split(" × "))
    assert "## " in text
    with pytest.raises(ConfigError, match="msa: no such choice that differs between these runs"):
        Interactions(choice="msa", other="reward").frames(runs)
    with pytest.raises(ConfigError, match="name two choices"):
        Interactions(choice="reward", other="reward").frames(runs)


def test_profiles_and_probabilities_are_shares_of_layouts(runs: Runs):
    figure = Profile(designs=3)
    frames = figure.frames(runs)
    drawn(figure, runs)
    row = frames["_improvement"].iloc[0]
    values = {}
    for name, k, reward in product(REPRESENTATIONS, SLOPES, REWARDS):
        values[f"exploration.k={k:g} representation={name} reward={reward}"] = y(name, k, reward)
    a, b = values[row["a"]], values[row["b"]]
    assert row["probability"] == pytest.approx(((a < b) + 0.5 * np.isclose(a, b)).mean())
    assert row["low"] <= row["probability"] <= row["high"]
    line = frames[MAIN][frames[MAIN]["design"] == row["a"]]
    assert line["share"].is_monotonic_increasing
    level = line["steps_over_optimum"].iloc[60]
    assert line["share"].iloc[60] == pytest.approx((np.exp(a) <= level).mean())
    assert min(values, key=lambda name: values[name].mean()) == frames[MAIN]["design"].iloc[0]


@pytest.mark.parametrize(
    "words",
    [
        ("importance", "--given", "representation=direction", "--scale", "log_steps"),
        ("best", "--statistic", "median"),
        ("interactions", "reward", "representation"),
        ("profile", "--designs", "2"),
    ],
)
def test_the_words_write_files_of_their_name_and_print_their_numbers(
    outputs: Path, words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
):
    paths = command.main(words[0], [*words[1:], "--study", "mine", f"outputs={outputs}", f"tracking.spool={outputs}/s"])
    assert outputs / "report" / f"{words[0]}.csv" in paths
    printed = capsys.readouterr()
    assert printed.out == ""
    assert [line for line in printed.err.splitlines() if line.startswith("  ")]
    with pytest.raises(ConfigError, match="reward: needs a second choice"):
        command.main("interactions", ["reward"])
