"""Choose among recorded runs: by values of parameters, and by the code of their components.

Everything that reads runs by a search, `load_runs` and the figures of `rl-design-report`, follows one rule: of each
component, the runs of its newest recorded code count. Reports of a study look up the points of its plan, which have the
code of the moment.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from rl_design_space.config import unlisted
from rl_design_space.config.overrides import with_absent
from rl_design_space.errors import ConfigError
from rl_design_space.tracking.record import params as params_of
from rl_design_space.tracking.run_frame import typed
from rl_design_space.tracking.tags import FINGERPRINT_TAG
from rl_design_space.tracking.values import param

if TYPE_CHECKING:
    from rl_design_space.plan.plan import PlannedPoint
    from rl_design_space.tracking.found_run import FoundRun

#: Suffix of the param that identifies the code of a user's own component; the rest is the name of the option.
SOURCE = ".source"
#: Maximum number of values that a message lists.
_SHOWN_VALUES = 12
#: What was changed where no component of the user's own was.
LEARNING = "the learning algorithm"
#: Values of parameters by name; a list of values means any of them.
Where = Mapping[str, Any]


def comparable(value: Any) -> Any:
    """Return a value as frames and `Point.parameters` have it: a list as text, e.g. `[3, 5]`."""
    return typed(param(value))


def matches(wanted: Any, value: Any) -> bool:
    """Return whether a value is the wanted one, or one of a list of wanted ones; the list itself may be meant, too."""
    return value in alternatives(wanted)


def alternatives(wanted: Any) -> list[Any]:
    """Return the values, as frames have them, that match a wanted one, see `matches`."""
    values = [wanted, *wanted] if isinstance(wanted, (list, tuple)) else [wanted]
    return list(map(comparable, values))


def chosen(found: Sequence[FoundRun], where: Where) -> list[FoundRun]:
    """Return the runs that have these values; a default that the params of a run leave out counts, too.

    Raises:
        ConfigError: no run has a parameter of such a name, or one with such a value; what there is is named.
    """
    params = [_with_defaults(each, where) for each in with_absent([run.params for run in found])]
    known = {name for each in params for name in each}
    for name, wanted in where.items() if found else ():
        if name not in known:
            raise ConfigError.unknown("parameter of these runs", name, known)
        values = dict.fromkeys(each[name] for each in params if name in each)
        if not any(matches(wanted, typed(value)) for value in values):
            raise no_such_value(name, wanted, list(values))
    return [
        run
        for run, each in zip(found, params, strict=True)
        if all(name in each and matches(wanted, typed(each[name])) for name, wanted in where.items())
    ]


def no_such_value(name: str, wanted: Any, there: Sequence[str]) -> ConfigError:
    """Return the error about a value that no run has, with those that there are."""
    texts = [param(each) for each in wanted] if isinstance(wanted, (list, tuple)) else [param(wanted)]
    shown = ", ".join(there[:_SHOWN_VALUES]) + (", …" if len(there) > _SHOWN_VALUES else "")
    return ConfigError(f"{name}={','.join(texts)}: no run has this value; there is {shown}")


def _with_defaults(params: Mapping[str, str], names: Iterable[str]) -> Mapping[str, str]:
    """Return the params of a run with those of the named values that they leave out."""
    missing = unlisted.left_out(params, names)
    return {**params, **{name: param(value) for name, value in missing.items()}} if missing else params


def named(found: Iterable[FoundRun], run_id: str) -> FoundRun:
    """Return the only run whose id begins with a text.

    Raises:
        ConfigError: there is none, or there are several.
    """
    runs = [run for run in found if run_id and run.run_id.startswith(run_id)]
    if len(runs) != 1:
        how_many = f"{len(runs)} runs have" if runs else "no complete run has"
        raise ConfigError(f"{run_id}: {how_many} an id that begins with this")
    return runs[0]


def outdated(found: Iterable[FoundRun]) -> dict[str, str]:
    """Return what was changed since runs were learned, by run id: `representation=near`, or `the learning algorithm`.

    Of each component, the code of its latest run is the newest. Of runs whose parameters are all equal, only those with
    the fingerprint of the latest one were learned by the newest version of this package.
    """
    runs = sorted(found, key=lambda run: (run.started, run.run_id))
    own = {run.run_id: components for run in runs if (components := _own_components(run))}
    code = {component: run.params[name] for run in runs for name, component in own.get(run.run_id, [])}
    points = _points(runs)
    fingerprints = {points[run.run_id]: run.tags.get(FINGERPRINT_TAG) for run in runs}
    old: dict[str, str] = {}
    for run in runs:
        components = own.get(run.run_id, [])
        changed = [component for name, component in components if code[component] != run.params[name]]
        if changed:
            old[run.run_id] = ", ".join(changed)
        elif fingerprints[points[run.run_id]] != run.tags.get(FINGERPRINT_TAG):
            old[run.run_id] = LEARNING
    return old


def changed_since(missing: Iterable[PlannedPoint], found: Iterable[FoundRun]) -> Counter[str]:
    """Return how many points have a run of equal values, but of other code, by what was changed since.

    Args:
        missing: points without a run of their own.
        found: all complete runs.
    """
    known = {_values(run.params): run.params for run in sorted(found, key=lambda run: run.started)}
    counts: Counter[str] = Counter()
    for planned in missing:
        now = params_of(planned.parameters)
        before = known.get(_values(now))
        if before is not None:
            code = [name for name in now if name.endswith(SOURCE)]
            changed = [_component(name.removesuffix(SOURCE), now) for name in code if before.get(name) != now[name]]
            counts[", ".join(changed) or LEARNING] += 1
    return counts


def left_out(old: Mapping[str, str], selected: int) -> str:
    """Return a note on runs that were left out; empty if none were.

    Args:
        old: what was changed since, by run id, of those left out.
        selected: number of runs before.
    """
    if not old:
        return ""
    changed = ", ".join(sorted(set(old.values())))
    return f"left out: {len(old)} of {selected} runs, recorded with earlier code of {changed}"


def _points(runs: Iterable[FoundRun]) -> dict[str, Hashable]:
    """Return a key of the params of each run, by run id; in order of names, which is quicker than a set of pairs."""
    ordered: dict[tuple[str, ...], tuple[str, ...]] = {}
    points: dict[str, Hashable] = {}
    for run in runs:
        names = tuple(run.params)
        if names not in ordered:
            ordered[names] = tuple(sorted(names))
        points[run.run_id] = (ordered[names], tuple(map(run.params.__getitem__, ordered[names])))
    return points


def _own_components(run: FoundRun) -> list[tuple[str, str]]:
    """Return name of the param with the code, and the component as on the command line, of a user's own components."""
    return [(name, _component(name.removesuffix(SOURCE), run.params)) for name in _sources(tuple(run.params))]


@lru_cache(maxsize=1024)
def _sources(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return those names that are of params with code; thousands of runs have the same names."""
    return tuple(name for name in names if name.endswith(SOURCE))


def _component(key: str, values: Mapping[str, str]) -> str:
    option = key if key in values else key.partition(".")[0]
    return f"{option}={values.get(option, '')}{key.removeprefix(option)}"


def _values(values: Mapping[str, str]) -> frozenset[tuple[str, str]]:
    """Return the params of a point without those that identify code."""
    return frozenset((name, value) for name, value in values.items() if not name.endswith(SOURCE))
