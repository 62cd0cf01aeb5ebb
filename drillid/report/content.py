"""The results of a well in its report: how much was identified, what stands out, agreement with the data sheets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup
from numpy.typing import NDArray

from drillid.arrays import Booleans, Floats, Integers
from drillid.discrepancy import EVIDENCE, runs
from drillid.discrepancy.products.interval_prediction import PREDICTION_COLUMNS
from drillid.figures.data import drilled_length
from drillid.physics.parameters import PARAMETERS
from drillid.report.quantities import QUANTITIES
from drillid.statistics import TWO_SIDED
from drillid.units import RPM

if TYPE_CHECKING:
    from drillid.config.rig import Rig
    from drillid.datasets.store import WellFolders


_LEAST_SHARE_FROM_DATA = 0.01
"""Share of an estimate's information that must come from the data for a comparison with the data sheets."""
_AGREES, _DIFFERS = 2.0, 3.0
"""Standard deviations from the data sheets up to which a value agrees, and above which it disagrees."""
_EVIDENT = 2.0
"""Pull from which a parameter counts as raised in an interval."""
_ROWS_APART = 3
"""Largest number of problems of one kind that each have a row of their own."""
_TRACKS = dict(zip(EVIDENCE, ("damping_bha", "inertia_bha"), strict=True))

_BOTH = frozenset({"damping_bha", "inertia_bha"})
EXPLANATIONS = {
    _BOTH: "A washed-out or enlarged hole would do this, as more mud then moves with the assembly and drags on it; so "
    "would cuttings packed around it, or whirl.",
    frozenset({"damping_bha"}): "More friction that grows with speed at the lower end: an enlarged hole or cuttings "
    "around the assembly, whirl or wall contact, or a change of formation or bit wear.",
    frozenset({"inertia_bha"}): "More mass rotates with the assembly: mud or cuttings that move with it, or an "
    "assembly other than that in the tally.",
}
"""Possible explanations of an interval, by the parameters that rose in it; the data alone do not decide."""


@dataclass(frozen=True)
class Estimate:
    """A value with its standard error, SI."""

    value: float
    error: float


@dataclass(frozen=True)
class Rise:
    """A parameter that rose in an interval: its value there, the usual one, and the least ratio of the two."""

    parameter: str
    there: Estimate
    usual: Estimate
    pull: float

    @property
    def least_ratio(self) -> float:
        """Least ratio of the two within their 95 % intervals."""
        usual = max(self.usual.value + TWO_SIDED * self.usual.error, np.finfo(float).tiny)
        return (self.there.value - TWO_SIDED * self.there.error) / usual


@dataclass(frozen=True)
class FlaggedInterval:
    """A flagged interval, m, with the parameters that rose in it."""

    from_m: float
    to_m: float
    windows: int
    rises: tuple[Rise, ...]
    prediction: tuple[float, float, float] | None = None
    """Errors of the predicted speed in one of its windows by what is usual and by its other windows, and the noise, rpm
    rms."""


@dataclass(frozen=True)
class Comparison:
    """A parameter from all accepted windows compared with the rig's data sheets, SI.

    `measured` is None where the data do not determine it.
    """

    parameter: str
    data_sheet: Estimate
    measured: Estimate | None

    @property
    def pull(self) -> float:
        """Difference in standard deviations of both."""
        if self.measured is None:
            return float("nan")
        return (self.measured.value - self.data_sheet.value) / float(
            np.hypot(self.measured.error, self.data_sheet.error)
        )

    @property
    def verdict(self) -> str:
        """In words."""
        if self.measured is None:
            return "not determined by the data"
        return "agrees" if abs(self.pull) <= _AGREES else "doubtful" if abs(self.pull) <= _DIFFERS else "disagrees"

    @property
    def deviates(self) -> bool:
        """The data contradict the data sheets, or may do so."""
        return self.verdict in ("doubtful", "disagrees")


@dataclass(frozen=True)
class ParameterSpread:
    """A parameter over the windows of one run, SI."""

    usual: float
    """Mean, each window weighted by its information."""
    low: float
    """16th percentile."""
    high: float
    """84th percentile."""
    error: float
    """Typical standard error of one window."""
    at_bound: int
    """Windows whose value lies at its physical bound."""


@dataclass(frozen=True)
class AssemblyRun:
    """One assembly run: depths of its windows (m), their number, and each parameter over the windows used."""

    from_m: float
    to_m: float
    windows: int
    used: int
    """Windows with an accepted fit that are not flagged."""
    collars: Markup
    spreads: dict[str, ParameterSpread]


@dataclass(frozen=True)
class Identified:
    """What was identified in a well."""

    windows: int
    hours: float
    accepted: int
    rejections: Counter[str]
    """Reasons why fits are not accepted, with their windows."""
    chi2: tuple[float, float, float]
    """Median, least and largest chi-squared per degree of freedom of the accepted windows."""
    judged: bool
    """Whether some run has enough windows for a usual level."""
    intervals: tuple[FlaggedInterval, ...]
    comparisons: tuple[Comparison, ...]
    runs: tuple[AssemblyRun, ...]

    def window_error(self, parameter: str) -> float:
        """Typical standard error of one window, SI: mean over the runs with windows that tell it; NaN without any."""
        errors = [run.spreads[parameter].error for run in self.runs if run.used]
        return float(np.mean(errors)) if errors else float("nan")


def identified(folders: WellFolders, rig: Rig) -> Identified:
    """Read what the report needs of a well that has its depth dataset."""
    fits, windows = folders.read("fits", "fits").load(), folders.read("windows", "windows").load()
    discrepancy = folders.read("discrepancy", "discrepancy").load()
    table = folders.read_table("discrepancy", "intervals")
    run = runs(rig, windows["bit_depth"].values)
    accepted, flagged = fits["accepted"].values.astype(bool), discrepancy["flagged"].values.astype(bool)
    chi2 = fits["chi2_per_dof"].values[accepted]
    quiet = accepted & ~flagged
    return Identified(
        windows=windows.sizes["window"],
        hours=covered_hours(windows["start"].values, windows["end"].values),
        accepted=int(accepted.sum()),
        rejections=Counter(kinds(pd.Series(fits["reason"].values[~accepted], dtype=str))),
        chi2=(float(np.median(chi2)), float(chi2.min()), float(chi2.max())) if chi2.size else (np.nan,) * 3,
        judged=bool(np.isfinite(discrepancy["damping_pull"].values).any()),
        intervals=tuple(_interval(row, windows, fits, discrepancy, run, quiet) for row in table.to_dict("records")),
        comparisons=comparisons(fits, quiet),
        runs=tuple(_run(number, rig, windows, fits, run, quiet) for number in np.unique(run)),
    )


def covered_hours(start: NDArray[np.datetime64], end: NDArray[np.datetime64]) -> float:
    """Time in windows in order of their start, h; overlaps count once."""
    until = np.minimum(end, np.append(start[1:], end[-1:]))
    return float(np.sum((until - start) / np.timedelta64(1, "h")))


def _stated(fits: xr.Dataset, name: str, member: Booleans) -> bool:
    stated = np.isfinite(fits["prior"].sel(parameter=name).values)
    return bool((stated[member] if member.any() else stated).any())


def _interval(
    row: Mapping[Hashable, Any],
    windows: xr.Dataset,
    fits: xr.Dataset,
    discrepancy: xr.Dataset,
    run: Integers,
    quiet: Booleans,
) -> FlaggedInterval:
    inside = (windows["depth_from"].values >= row["from_m"]) & (windows["depth_to"].values <= row["to_m"])
    inside &= discrepancy["flagged"].values & fits["accepted"].values
    usual = quiet & np.isin(run, run[inside])
    rises = []
    for track, parameter in _TRACKS.items():
        if row[track] > _EVIDENT:
            values = fits.sel(parameter=parameter)
            there, level = (_mean(values, member) for member in (inside, usual))
            rises.append(Rise(parameter, there, level, float(row[track])))
    errors = tuple(float(row.get(name, np.nan)) / RPM for name in PREDICTION_COLUMNS)
    prediction = (errors[0], errors[1], errors[2]) if np.isfinite(errors).all() else None
    return FlaggedInterval(row["from_m"], row["to_m"], int(row["windows"]), tuple(rises), prediction)


def _mean(fit: xr.Dataset, member: Booleans) -> Estimate:
    """Mean of one parameter over windows, each weighted by its information."""
    return weighted_mean(fit["value"].values[member], fit["standard_error"].values[member])


def weighted_mean(value: Floats, error: Floats) -> Estimate:
    """Mean of independent values weighted by 1/error², with its standard error; NaN of nothing."""
    if not value.size:
        return Estimate(float("nan"), float("nan"))
    weight = 1 / error**2
    return Estimate(float(np.sum(weight * value) / np.sum(weight)), float(np.sum(weight) ** -0.5))


def comparisons(fits: xr.Dataset, member: Booleans) -> tuple[Comparison, ...]:
    """Every parameter that the data sheets state in the windows that are compared, or in any where these are none."""
    names = fits["parameter"].values.tolist()
    return tuple(comparison(fits, name, member) for name in names if _stated(fits, name, member))


def comparison(fits: xr.Dataset, name: str, member: Booleans) -> Comparison:
    """A parameter from the data alone, and from the data sheets; both as means over the windows.

    Every fit had the data sheets as its prior, whose information is subtracted from each window's
    estimate first: the information of independent sources adds. The error of the data sheets is
    the same in all windows, so that it does not average out.
    """
    fit = fits.sel(parameter=name)
    value, error, prior, prior_error = (
        fit[name].values[member] for name in ("value", "standard_error", "prior", "prior_error")
    )
    stated = fit["prior"].values, fit["prior_error"].values
    data_sheet = Estimate(*(float(np.nanmean(values)) for values in ((prior, prior_error) if prior.size else stated)))
    information = 1 / error**2 - 1 / prior_error**2
    informed = information > _LEAST_SHARE_FROM_DATA / error**2
    if not informed.any():
        return Comparison(name, data_sheet, None)
    own = information[informed]
    difference = weighted_mean((value - prior)[informed] / error[informed] ** 2 / own, own**-0.5)
    return Comparison(name, data_sheet, Estimate(data_sheet.value + difference.value, difference.error))


def _run(number: int, rig: Rig, windows: xr.Dataset, fits: xr.Dataset, run: Integers, quiet: Booleans) -> AssemblyRun:
    of_run = run == number
    used = of_run & quiet
    collars = rig.collars_at(float(windows["bit_depth"].values[of_run].mean()))
    shift = drilled_length(rig, windows["bit_depth"].values)
    spreads = {}
    for name in PARAMETERS:
        fit = fits.sel(parameter=name)
        value = (fit["value"].values - (shift if name == "length" else 0.0))[used]
        low, high = np.percentile(value, [16, 84]) if value.size else (np.nan,) * 2
        usual = weighted_mean(value, fit["standard_error"].values[used])
        error = np.median(fit["standard_error"].values[used]) if value.size else np.nan
        spreads[name] = ParameterSpread(
            usual.value, float(low), float(high), float(error), int(np.sum(fit["at_bound"].values[used]))
        )
    return AssemblyRun(
        from_m=float(windows["depth_from"].values[of_run].min()),
        to_m=float(windows["depth_to"].values[of_run].max()),
        windows=int(of_run.sum()),
        used=int(used.sum()),
        collars=Markup("{} collars, OD {}").format(
            QUANTITIES["depth"].text(collars.length), QUANTITIES["diameter"].text(collars.outer_diameter)
        )
        if collars
        else Markup("no collars listed"),
        spreads=spreads,
    )


@dataclass(frozen=True)
class Drilled:
    """Contents of the logs: drilled depths (m) and time (h), and the newest time; NaN and None without any."""

    from_m: float
    to_m: float
    hours: float
    recorded_hours: float
    newest: pd.Timestamp | None
    metres: float = 0.0
    """Drilled in the segments, without what lies between them."""


def drilled(segments: pd.DataFrame) -> Drilled:
    """Sum over the segments of a well."""
    drilling = segments[segments["state"] == "drilling"]
    newest = pd.Timestamp(segments["end"].max()) if len(segments) else None
    return Drilled(
        float(drilling["from_m"].min()),
        float(drilling["to_m"].max()),
        float(drilling["duration_s"].sum() / 3600),
        float(segments["duration_s"].sum() / 3600),
        newest,
        float((drilling["to_m"] - drilling["from_m"]).sum()),
    )


def without_windows(segments: pd.DataFrame) -> pd.DataFrame:
    """Time outside of windows: columns state, reason, segments, minutes; longest first.

    Reasons that differ in their numbers only are counted together.
    """
    empty = segments[segments["windows"] == 0]
    reason = kinds(empty["reason"].fillna("").astype(str))
    grouped = empty.assign(reason=reason).groupby(["state", "reason"])["duration_s"]
    table = grouped.agg(segments="size", minutes="sum").reset_index()
    return table.assign(minutes=table["minutes"] / 60).sort_values("minutes", ascending=False, ignore_index=True)


def kinds(reasons: pd.Series[str]) -> pd.Series[str]:
    """Reasons with … in place of numbers in which several of one kind differ."""
    pattern = _without_numbers(reasons)
    different = reasons.groupby(pattern).transform("nunique") > 1
    return reasons.mask(different, pattern)


def _without_numbers(texts: pd.Series[str]) -> pd.Series[str]:
    return texts.str.replace(r"\d[\d.]*(e[+-]?\d+)?", "…", regex=True)


def joined(problems: pd.DataFrame) -> pd.DataFrame:
    """Problems of one well for readers: columns stage, where, what, remedy, rows.

    Rows of a stage whose `what` is equal except for its numbers become one, at the place of the
    first, as soon as there are more than a few of them; `rows` counts them.
    """
    texts = problems.astype(str)
    kind = [texts["stage"], _without_numbers(texts["what"])]
    rows = texts.groupby(kind)["what"].transform("size").astype(int)
    many = rows > _ROWS_APART
    kept = ~many | ~pd.concat(kind, axis=1).duplicated()
    what = texts["what"].mask(many, kinds(texts["what"].where(many, "")))
    return texts.assign(what=what, rows=rows.where(many, 1))[kept]


def read_segments(folders: WellFolders) -> pd.DataFrame:
    """The well's segments; none where it failed before."""
    path = folders.stage("windows") / "segments.csv"
    columns = ["well", "state", "start", "end", "from_m", "to_m", "duration_s", "windows", "reason"]
    return folders.read_table("windows", "segments") if path.exists() else pd.DataFrame(columns=columns)
