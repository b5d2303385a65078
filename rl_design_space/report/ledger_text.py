"""The ledger of claims as Markdown."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rl_design_space.analysis.claims import Tested, Verdict
from rl_design_space.report.markdown import made_by

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.report.ledger import Judged


def ledger_text(study: Study, judged: Sequence[Judged], title: str) -> str:
    """The verdicts, how sure they are, and everything that they rest on."""
    counts = Counter(each.finding.verdict for each in judged)
    counted = ", ".join(f"{counts[verdict]} {verdict}" for verdict in Verdict)
    lines = [
        f"# {title}",
        "",
        f"**{len(judged)} claims: {counted}.**",
        "",
        f"![Every part of every claim: its value with the 95 % interval, beside the range that the claim gives]"
        f"({study.name}.png)",
        "",
        made_by(study),
        "",
        "| claim | says | verdict | hangs on | value | 95 % interval | claimed | see |",
        "|---|---|---|---|---|---|---|---|",
        *(_row(each) for each in judged),
        "",
        "## What each claim rests on",
        "",
    ]
    for each in judged:
        lines += [f"**{each.name}** – {each.claim.statement}: *{each.finding.verdict}*", ""]
        lines += [
            f"- {part.what}: {_value(part)}, claimed {claimed(part)}; {part.state}" for part in each.finding.parts
        ]
        lines += [f"- {missing}" for missing in each.missing]
        if not each.finding.parts and not each.missing:
            lines.append("- nothing to measure: the paper announces it")
        lines.append("")
    return "\n".join([*lines, _HOW_TO_READ, ""])


_HOW_TO_READ = (
    "A claim holds if all of its parts do, and fails if one of them does. The unit is the period; intervals are 95 % "
    "bootstrap intervals over periods, paired between points, because all points of one size meet the same layouts. "
    "Where a best value is chosen, it is chosen on one half of the periods and compared on the other. A verdict needs "
    "a chance of error below 5 % after Holm's correction over the claims of a study; otherwise it is undecided. The "
    "claimed ranges stand in `conf/study/claims.yaml`; they were written down before anything was measured, and are "
    "not changed to fit."
)


def claimed(part: Tested) -> str:
    """The range that a claim gives, in words."""
    if math.isinf(part.low):
        return f"at most {part.high:g}"
    if math.isinf(part.high):
        return f"at least {part.low:g}"
    return f"{part.low:g} to {part.high:g}"


def _row(each: Judged) -> str:
    part = each.finding.decisive
    interval = f"{part.ci_low:.3g} – {part.ci_high:.3g}" if part else ""
    numbers = (part.what, f"{part.value:.3g}", interval, claimed(part)) if part else ("", "", "", "")
    verdict = f"**{each.finding.verdict}**" if each.finding.verdict != Verdict.REPRODUCED else each.finding.verdict
    return f"| {' | '.join([each.name, each.claim.statement, verdict, *numbers, each.claim.study])} |"


def _value(part: Tested) -> str:
    return f"{part.value:.3g} ({part.ci_low:.3g} – {part.ci_high:.3g})"
