"""Reports: tables and figures of tracked runs. Only what looks inside learns, single periods again."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rl_design_space.report.attributes import Attributes as Attributes
    from rl_design_space.report.best import Best as Best
    from rl_design_space.report.claims_ledger import ClaimsLedger as ClaimsLedger
    from rl_design_space.report.compare import Compare as Compare
    from rl_design_space.report.curves import Curves as Curves
    from rl_design_space.report.curves_figure import CurvesFigure as CurvesFigure
    from rl_design_space.report.failures import Failures as Failures
    from rl_design_space.report.figures import Figures as Figures
    from rl_design_space.report.heatmap import Heatmap as Heatmap
    from rl_design_space.report.importance import Importance as Importance
    from rl_design_space.report.interactions import Interactions as Interactions
    from rl_design_space.report.multiverse import Multiverse as Multiverse
    from rl_design_space.report.page import Page as Page
    from rl_design_space.report.profile import Profile as Profile
    from rl_design_space.report.property_map import PropertyMap as PropertyMap
    from rl_design_space.report.published_table import PublishedTable as PublishedTable
    from rl_design_space.report.quality_map import QualityMap as QualityMap
    from rl_design_space.report.readings_audit import ReadingsAudit as ReadingsAudit
    from rl_design_space.report.resolution import Resolution as Resolution
    from rl_design_space.report.scenario import Scenario as Scenario
    from rl_design_space.report.sensitivity import Sensitivity as Sensitivity
    from rl_design_space.report.stage_costs import StageCosts as StageCosts
    from rl_design_space.report.state_space import StateSpace as StateSpace
    from rl_design_space.report.transfer_curve import TransferCurve as TransferCurve
    from rl_design_space.report.transfer_map import TransferMap as TransferMap

__all__ = [
    "Attributes",
    "Best",
    "ClaimsLedger",
    "Compare",
    "Curves",
    "CurvesFigure",
    "Failures",
    "Figures",
    "Heatmap",
    "Importance",
    "Interactions",
    "Multiverse",
    "Page",
    "Profile",
    "PropertyMap",
    "PublishedTable",
    "QualityMap",
    "ReadingsAudit",
    "Resolution",
    "Scenario",
    "Sensitivity",
    "StageCosts",
    "StateSpace",
    "TransferCurve",
    "TransferMap",
]

if not TYPE_CHECKING:  # otherwise every misspelt name would pass as Any

    def __getattr__(name: str) -> Any:
        """Import a report when it is first used: a study has one, and to import all of them takes a second."""
        if name in __all__:
            module = "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name).lstrip("_")
            return getattr(import_module(f"{__name__}.{module}"), name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}", name=name, obj=import_module(__name__))
