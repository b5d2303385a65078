"""Running a race: learn the points that are in it, stop those that are worse, look again with more periods."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.best import best_means
from rl_design_space.analysis.race import Look, behind, matrix
from rl_design_space.commands.progress import Display
from rl_design_space.commands.race_objective import mean_measure, no_mean
from rl_design_space.commands.race_result import RaceResult
from rl_design_space.commands.terminal import console, counted
from rl_design_space.commands.watching import watched
from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.run.executor import Executor
from rl_design_space.run.outcome import Outcome, summary_run
from rl_design_space.run.runner import add_studies, learn_missing, missing
from rl_design_space.run.settings import Settings
from rl_design_space.tracking.tracker import Beginning, Findings, StoredRun, Tracker


class Race:
    """A race.

    Args:
        plan: the points with the most periods that they can get.
        looks: when they are compared.
        confidence: with which the set holds the best.
        settings: of the command.
        tracker: records results.
        executor: learns the points.
        command: the command line, which the summary run records.

    Raises:
        ConfigError: the objective is no mean over periods.
    """

    def __init__(
        self,
        plan: Plan,
        looks: Sequence[Look],
        confidence: float,
        settings: Settings,
        tracker: Tracker,
        executor: Executor,
        command: str,
    ) -> None:
        self._plan, self._looks, self._confidence = plan, looks, confidence
        self._name, self._on_error = settings.objective, settings.on_error
        self._measure = mean_measure(settings.objective)
        self._tracker, self._executor, self._command = tracker, executor, command
        self._outcome, self._is_open = Outcome(), False
        #: By the number of a point: the point with as many periods as it got, the numbers of its periods that are
        #: compared, its steps, and its result while it goes on.
        self._ended: dict[int, PlannedPoint] = {}
        self._values: dict[int, FloatArray] = {}
        self._steps: dict[int, float] = {}
        self._results: dict[int, LearningCurves] = {}
        #: How the race ended; None if it was stopped by a failure, or all points failed.
        self.result: RaceResult | None = None

    def run(self) -> Outcome:
        """Run the race to its end, and record its summary if anything was learned.

        Raises:
            ConfigError: nothing can be recorded, or a recorded run did not keep its periods.
        """
        outcome = self._outcome
        with ExitStack() as opened:
            going = list(range(len(self._plan)))
            for look in self._looks:
                going = self._after(look, going, opened)
                if len(going) < 2 or self._is_stopped:
                    break
            outcome.findings = Findings(replace(self._plan, points=[*self._ended.values()]))
            if self._values and not self._is_stopped:
                self.result = self._found()
                outcome.findings = replace(self.result.findings, plan=outcome.findings.plan)
            if self._is_open:
                started = time.perf_counter()
                with console.status("recording") as status:
                    delivery = self._tracker.wait_for_delivery(
                        lambda pending, problem: status.update(
                            f"recording: {counted(pending, 'result')} to go{f': {problem}' if problem else ''}"
                        )
                    )
                outcome.count_lost(delivery.lost)
                outcome.seconds["delivery"] = time.perf_counter() - started
        outcome.delivery = self._tracker.wait_for_delivery()
        return outcome

    @property
    def _is_stopped(self) -> bool:
        return bool(self._outcome.failed) and self._on_error == "stop"

    def _after(self, look: Look, going: Sequence[int], opened: ExitStack) -> list[int]:
        """Return the points that go on after a look; those of which the doubt has returned are learned, too.

        Args:
            look: the look.
            going: numbers of the points that went on before.
            opened: holds the summary run.
        """
        learn = going = list(going)
        while learn:
            self._learn(look, learn, opened)
            numbers = sorted(self._values)
            if self._is_stopped or not numbers:
                return []
            worse = behind([self._values[number] for number in numbers], look)
            going = [number for number, each in zip(numbers, worse.tolist(), strict=True) if not each]
            learn = [number for number in going if len(self._values[number]) < look.periods]
        for number in set(self._results) - set(going):
            del self._results[number]
        if look != self._looks[-1]:
            told = f"after {look.periods:,} periods: {len(going):,} of {len(self._plan):,} go on"
            console.print(told, highlight=False)
        return going

    def _learn(self, look: Look, numbers: Sequence[int], opened: ExitStack) -> None:
        """Learn points up to a look."""
        points = {
            number: self._plan[number].with_periods(look.periods, self._results.get(number)) for number in numbers
        }
        part = replace(self._plan, points=[*points.values()], whole=len(points))
        outcome, found = self._outcome, missing(part, self._tracker)
        outcome.points += len(part)
        outcome.already += len(found.stored)
        outcome.stored |= found.stored
        add_studies(part, found.stored, self._tracker)
        learned: dict[str, LearningCurves] = {}
        if found.points:
            if not self._is_open:
                self._is_open = True
                opened.enter_context(summary_run(self._plan, outcome, self._tracker, self._command))
            workers = f"{self._executor.describe()}, up to {counted(look.periods, 'period')}"
            with Display(part, found, workers) as display:
                monitor = _Collecting(display, learned)
                learn_missing(found, self._tracker, self._executor, monitor, outcome, self._on_error)
        self._read([each for each in points.values() if each.fingerprint not in learned], learned)
        for number, planned in points.items():
            self._ended[number] = planned
            self._keep(number, planned, learned.get(planned.fingerprint))

    def _read(self, points: Sequence[PlannedPoint], learned: dict[str, LearningCurves]) -> None:
        """Read the results of points that were not learned now.

        Raises:
            ConfigError: a run did not keep its periods, or cannot be read.
        """
        for planned in watched(points, "reading runs"):
            run = self._outcome.stored.get(planned.fingerprint)
            if run is None:
                continue  # it has failed
            beginning = Beginning(planned.fingerprint, planned.point.task.periods, run)
            result = self._tracker.result(beginning, planned)
            if result is None:
                reason = "did not keep its periods, which a race compares, or they are damaged"
                raise ConfigError(f"run {run.run_id or planned.name} {reason}; needs tracking.artifact=periods")
            learned[planned.fingerprint] = result

    def _keep(self, number: int, planned: PlannedPoint, result: LearningCurves | None) -> None:
        """Keep the result of a point; without one it has failed, and is out of the race."""
        if result is None:
            self._values.pop(number, None)
            self._steps.pop(number, None)
            self._results.pop(number, None)
            return
        result = self._results[number] = replace(result, known_point=planned.point)
        values = self._measure.each(result)
        if values is None:
            raise no_mean(self._name)
        self._values[number] = -values if self._measure.largest_is_best else values
        self._steps[number] = float(result.total_steps.sum())

    def _found(self) -> RaceResult:
        numbers = sorted(self._values)
        each = [self._values[number] for number in numbers]
        sign = -1 if self._measure.largest_is_best else 1
        return RaceResult(
            plan=replace(self._plan, points=[self._ended[number] for number in numbers]),
            name=self._name,
            values=sign * np.array([values.mean() for values in each]),
            errors=np.array([values.std(ddof=1) / np.sqrt(len(values)) for values in each]),
            steps=np.array([self._steps[number] for number in numbers]),
            best=best_means(matrix(each), self._confidence),
            first=self._looks[0].periods,
            most=self._looks[-1].periods,
            confidence=self._confidence,
            largest_is_best=self._measure.largest_is_best,
            failed=len(self._plan) - len(numbers),
        )


class _Collecting:
    """A monitor that keeps results, and passes all events on to a display."""

    def __init__(self, display: Display, learned: dict[str, LearningCurves]) -> None:
        self._display, self._learned = display, learned
        self.point_started, self.point_learned = display.point_started, display.point_learned
        self.waiting, self.delivering = display.waiting, display.delivering

    def point_ended(self, planned: PlannedPoint, result: LearningCurves | StoredRun | Exception) -> None:
        """Keep learning curves."""
        if isinstance(result, LearningCurves):
            self._learned[planned.fingerprint] = result
        self._display.point_ended(planned, result)
