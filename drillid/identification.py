"""From logs to fitted parameters in memory: the stages of the workflow, one after the other, without its folders."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from drillid.config.listing import Well
from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.datasets.memory import WellInMemory
from drillid.datasets.registry import PROBLEM_COLUMNS
from drillid.datasets.store import Problem, problems_table
from drillid.errors import EstimationError, LogError, SettingsError
from drillid.physics.parameters import PARAMETERS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drillid.control.tuning import Family, Tuning
    from drillid.figures.data import WellResults

_TO_THE_FITS = ("records", "windows", "spectra", "mobility", "fits")
_BEHIND = ("discrepancy", "depth")


def identify(
    logs: str | Path | Sequence[str | Path], rig: str | Path | Rig, settings: Settings | None = None
) -> Identification:
    """Identify the drilling system from the raw logs of one well.

    Parameters
    ----------
    logs : one raw log file or several, in any order and any format that `drillid.formats` reads
    rig : description of the rig, or the path of its YAML file
    settings : settings of the stages; the defaults where None

    Raises
    ------
    SettingsError
        If the rig description cannot be used.
    LogError
        If no log can be used; the message is that of the first.
    EstimationError
        If no window of steady drilling with the sweep on was found, or none long enough; the message says why not.
    """
    paths = [Path(logs)] if isinstance(logs, str | Path) else [Path(log) for log in logs]
    if not paths:
        raise SettingsError("logs", "no log is given", "Name one log file or several")
    described = rig if isinstance(rig, Rig) else Rig.from_yaml(Path(rig))
    well = Well(described.name, described, tuple(paths))
    identification = Identification(well, settings or Settings(), WellInMemory(name=described.name), {})
    for stage in _TO_THE_FITS:
        identification._pass(stage)
        if stage == "records" and not identification.folders.has("records", "records"):
            raise LogError(*_first(identification.found["records"]))
        if stage == "windows" and not identification.windows.sizes["window"]:
            raise _without_windows(identification)
        if stage == "spectra" and not identification.spectra["cross_speed"].notnull().any():
            raise EstimationError(*_first(identification.found["spectra"]))
    return identification


@dataclass(frozen=True, eq=False)
class Identification:
    """One well's datasets as the workflow would write them, in memory; docs/datasets.md lists their variables.

    The causes of the fits' misfit, and what the figures need of them, are examined when first asked for.
    """

    well: Well
    settings: Settings
    folders: WellInMemory
    found: dict[str, tuple[Problem, ...]]
    """What each stage rejected."""

    def _pass(self, stage: str) -> None:
        process = importlib.import_module(f"drillid.{stage}.stage").process
        self.found[stage] = tuple(process(self.well, self.folders, self.settings))

    @property
    def records(self) -> xr.Dataset:
        """Regular series in SI units, with a flag for every sample that was mended."""
        return self.folders.read("records", "records")

    @property
    def windows(self) -> xr.Dataset:
        """Windows of steady drilling with the sweep on."""
        return self.folders.read("windows", "windows")

    @property
    def spectra(self) -> xr.Dataset:
        """Cross spectra and spectrograms of every window."""
        return self.folders.read("spectra", "spectra")

    @property
    def mobility(self) -> xr.Dataset:
        """Command mobility with its variance, coherence and gate."""
        return self.folders.read("mobility", "mobility")

    @property
    def fits(self) -> xr.Dataset:
        """The eight parameters of every window with intervals and correlations."""
        return self.folders.read("fits", "fits")

    @property
    def joint(self) -> xr.Dataset:
        """The same from all windows together."""
        return self.folders.read("fits", "joint")

    @cached_property
    def parameters(self) -> pd.DataFrame:
        """One row per window and parameter, SI units: value, standard error, 95 % interval, whether it is accepted."""
        fits = self.fits
        names = ["value", "standard_error", "interval_lower", "interval_upper"]
        table = fits[[*names, "accepted", "chi2_per_dof"]].to_dataframe().reset_index()
        table["unit"] = table["parameter"].map({name: unit for name, (unit, _) in PARAMETERS.items()})
        order = ["window", "start", "hole_depth", "parameter", *names, "unit", "accepted", "chi2_per_dof"]
        return table[order]

    @property
    def problems(self) -> pd.DataFrame:
        """One row for each item that was rejected or mended: where, what, remedy."""
        tables = [problems_table(self.well.name, stage, found) for stage, found in self.found.items() if found]
        return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=list(PROBLEM_COLUMNS))

    @cached_property
    def results(self) -> WellResults:
        """All datasets, the examination of what the fits leave unexplained and its verdicts among them."""
        from drillid.figures.data import WellResults

        for stage in _BEHIND:
            self._pass(stage)
        return WellResults.load(self.well, self.folders, self.settings.discrepancy.error_rate)

    @property
    def verdicts(self) -> pd.DataFrame:
        """What the model gets wrong: cause, probability, size, gain; see `drillid.discrepancy.sets.COLUMNS`."""
        return self.results.verdicts

    def draw(self, figure: str = "command_mobility_fitted") -> Figure:
        """One of the report's figures; `drillid.figures.captions.FIGURES` lists them.

        Raises
        ------
        SettingsError
            If there is no such figure.
        """
        from drillid.figures.stage import draw

        return draw(self.results, figure)

    def tuned(self, family: Family = "proportional integral") -> Tuning:
        """Speed control tuned to the last accepted window and to how well its parameters are known.

        Raises
        ------
        EstimationError
            If no window's fit is accepted, or no settings of the family keep the margins.
        """
        from drillid.control.tuning import sampled_systems, tune
        from drillid.fits.datasheet import data_sheet, stored_controller

        fits = self.fits.assign(bit_depth=("window", self.windows["bit_depth"].values))
        accepted = fits.isel(window=fits["accepted"].values)
        if not accepted.sizes["window"]:
            remedy = "See the column reason of the fits, and the problems"
            raise EstimationError(self.well.name, "the fit of no window is accepted", remedy)
        last = accepted.isel(window=-1)
        sheet = data_sheet(self.well.rig, stored_controller(last), float(last["bit_depth"]))
        error = last["standard_error"].values
        covariance = last["correlation"].values * np.outer(error, error)
        return tune(sampled_systems(last["value"].values, covariance, sheet.equipment), family)


def _first(problems: Sequence[Problem]) -> tuple[str, str, str]:
    problem = problems[0]
    return problem.where, problem.what, problem.remedy


def _without_windows(identification: Identification) -> EstimationError:
    """The reasons why no part of the logs is a window, the longest part first."""
    segments = identification.folders.read_table("windows", "segments")
    total = segments.groupby("reason")["duration_s"].sum().sort_values(ascending=False)
    reasons = "; ".join(f"{seconds:.0f} s {reason}" for reason, seconds in total.items() if reason)
    logs = ", ".join(path.name for path in identification.well.logs)
    what = f"no window of steady drilling with the sweep on was found ({reasons or 'no samples'})"
    chosen = identification.settings.windows
    shortest = chosen.shortest_share * chosen.length_s
    remedy = f"A window is at least {shortest:.0f} s long; see the settings windows.length_s and windows.shortest_share"
    return EstimationError(logs, what, remedy)
