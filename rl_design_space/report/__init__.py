"""Reports: tables and figures of tracked runs. Only what looks inside learns, single periods again."""

from rl_design_space.report.attributes import Attributes
from rl_design_space.report.best import Best
from rl_design_space.report.claims_ledger import ClaimsLedger
from rl_design_space.report.compare import Compare
from rl_design_space.report.curves import Curves
from rl_design_space.report.curves_figure import CurvesFigure
from rl_design_space.report.failures import Failures
from rl_design_space.report.figures import Figures
from rl_design_space.report.heatmap import Heatmap
from rl_design_space.report.importance import Importance
from rl_design_space.report.interactions import Interactions
from rl_design_space.report.multiverse import Multiverse
from rl_design_space.report.page import Page
from rl_design_space.report.profile import Profile
from rl_design_space.report.property_map import PropertyMap
from rl_design_space.report.published_table import PublishedTable
from rl_design_space.report.quality_map import QualityMap
from rl_design_space.report.readings_audit import ReadingsAudit
from rl_design_space.report.resolution import Resolution
from rl_design_space.report.scenario import Scenario
from rl_design_space.report.sensitivity import Sensitivity
from rl_design_space.report.stage_costs import StageCosts
from rl_design_space.report.state_space import StateSpace
from rl_design_space.report.transfer_curve import TransferCurve
from rl_design_space.report.transfer_map import TransferMap

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
