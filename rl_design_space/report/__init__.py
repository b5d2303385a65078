"""Reports: tables and figures of tracked runs. Nothing here starts to learn."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rl_design_space.report.audit import ReadingsAudit
    from rl_design_space.report.curves import CurvesFigure
    from rl_design_space.report.generic.compare import Compare
    from rl_design_space.report.generic.curves import Curves
    from rl_design_space.report.generic.figures import Figures
    from rl_design_space.report.generic.heatmap import Heatmap
    from rl_design_space.report.generic.sensitivity import Sensitivity
    from rl_design_space.report.ledger import ClaimsLedger
    from rl_design_space.report.page import Page
    from rl_design_space.report.property_map import PropertyMap
    from rl_design_space.report.published_table import PublishedTable
    from rl_design_space.report.quality_map import QualityMap
    from rl_design_space.report.scenario import Scenario
    from rl_design_space.report.state_space import StateSpace

__all__ = [
    "ClaimsLedger",
    "Compare",
    "Curves",
    "CurvesFigure",
    "Figures",
    "Heatmap",
    "Page",
    "PropertyMap",
    "PublishedTable",
    "QualityMap",
    "ReadingsAudit",
    "Scenario",
    "Sensitivity",
    "StateSpace",
]

_HOME = {
    "Compare": "generic.compare",
    "Curves": "generic.curves",
    "Figures": "generic.figures",
    "Heatmap": "generic.heatmap",
    "Sensitivity": "generic.sensitivity",
    "ClaimsLedger": "ledger",
    "CurvesFigure": "curves",
    "Page": "page",
    "PropertyMap": "property_map",
    "PublishedTable": "published_table",
    "QualityMap": "quality_map",
    "ReadingsAudit": "audit",
    "Scenario": "scenario",
    "StateSpace": "state_space",
}


def __getattr__(name: str) -> Any:
    """Import a report when it is first used: one needs little of what the others need."""
    if name in _HOME:
        return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
