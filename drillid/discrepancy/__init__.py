"""The discovery engine: what the model leaves unexplained, its cause, the extended model, the gain."""

from drillid.discrepancy.anomalies import EVIDENCE, flag, intervals, run_pulls, runs
from drillid.discrepancy.causes import CATALOGUE
from drillid.discrepancy.evidence import Conditions, Evidence, Knowledge, Sign
from drillid.discrepancy.examination import Examination
from drillid.discrepancy.examine import examine
from drillid.discrepancy.residuals import normality_probability, whitened_residuals, whiteness_probability
from drillid.discrepancy.stage import process
from drillid.discrepancy.verdict import Verdict

__all__ = [
    "CATALOGUE",
    "EVIDENCE",
    "Conditions",
    "Evidence",
    "Examination",
    "Knowledge",
    "Sign",
    "Verdict",
    "examine",
    "flag",
    "intervals",
    "normality_probability",
    "process",
    "run_pulls",
    "runs",
    "whitened_residuals",
    "whiteness_probability",
]
