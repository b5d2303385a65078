"""Reports: tables and figures of tracked runs. Nothing here starts to learn."""

from rl_design_space.report.audit import ReadingsAudit
from rl_design_space.report.curves import CurvesFigure
from rl_design_space.report.ledger import ClaimsLedger
from rl_design_space.report.page import Page
from rl_design_space.report.property_map import PropertyMap
from rl_design_space.report.published_table import PublishedTable
from rl_design_space.report.quality_map import QualityMap
from rl_design_space.report.scenario import Scenario
from rl_design_space.report.state_space import StateSpace

__all__ = [
    "ClaimsLedger",
    "CurvesFigure",
    "Page",
    "PropertyMap",
    "PublishedTable",
    "QualityMap",
    "ReadingsAudit",
    "Scenario",
    "StateSpace",
]
