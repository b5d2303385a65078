"""Reports: tables and figures of tracked runs. Nothing here starts to learn."""

from rl_design_space.report.audit import ReadingsAudit
from rl_design_space.report.curves import CurvesFigure
from rl_design_space.report.ledger import ClaimsLedger
from rl_design_space.report.page import Page
from rl_design_space.report.published_table import PublishedTable

__all__ = ["ClaimsLedger", "CurvesFigure", "Page", "PublishedTable", "ReadingsAudit"]
