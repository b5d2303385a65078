"""Deliver the pending records on this disk to their tracking stores."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from rl_design_space.commands.arguments import Parser


def main(arguments: Sequence[str]) -> None:
    """Deliver the pending records under `tracking.spool`; exit with status 1 if some cannot be delivered.

    Records that a store has refused are tried again.

    Raises:
        ConfigError: a store cannot be used, or the records cannot be removed once they are delivered.
    """
    parser = Parser(prog="rl-design-space sync", description=__doc__)
    parser.add_argument(
        "overrides",
        nargs="*",
        help="settings, e.g. outputs=DIR or tracking.patience=SECONDS: where the records are, how long to try",
    )
    overrides = parser.parse_args(arguments).overrides

    from rl_design_space._paths import why_unwritable
    from rl_design_space._secrets import without_secrets
    from rl_design_space.commands.terminal import console, counted
    from rl_design_space.run.settings import store_of
    from rl_design_space.tracking.delivery import deliver_all
    from rl_design_space.tracking.read_only import not_writable
    from rl_design_space.tracking.spool import Spool

    options = store_of(overrides)
    left = 0
    for spool in Spool.all_under(Path(options.spool)):
        if restored := spool.restore_refused():
            console.print(f"{counted(restored, 'record')} tried again that the store had refused")
        pending, quarantined = len(spool.pending()), set(spool.quarantined())
        if not pending:
            continue
        if reason := why_unwritable(spool.folder):
            raise not_writable(spool.folder, reason)
        console.print(
            f"{counted(pending, 'record')} for {without_secrets(spool.address.uri)} …", markup=False, soft_wrap=True
        )
        reason = deliver_all(spool, options.patience)
        still = len(spool.pending())
        newly_quarantined = sorted(set(spool.quarantined()) - quarantined)
        console.print(f"{counted(pending - still - len(newly_quarantined), 'record')} delivered")
        for path in newly_quarantined:
            console.print(f"quarantined, because it cannot be delivered: {path}", markup=False, soft_wrap=True)
        if still:
            console.print(f"{counted(still, 'record')} still pending: {reason}", markup=False, soft_wrap=True)
        left += still + len(newly_quarantined)
    if left:
        sys.exit(1)
    console.print(f"no pending records in {options.spool}", markup=False, soft_wrap=True)
