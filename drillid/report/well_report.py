"""What the report tells of one well."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from drillid.arrays import Floats
from drillid.report.content import (
    Comparison,
    Drilled,
    FlaggedInterval,
    Identified,
    drilled,
    identified,
    read_segments,
    without_windows,
)
from drillid.report.verdicts import SetText, VerdictText, read_verdict_texts

if TYPE_CHECKING:
    from drillid.config.listing import Listing
    from drillid.datasets.store import WellFolders

_MANY_REJECTED = 0.2
"""Share of fits that are not accepted from which the report tells it first."""
_SAME_PLACE_M = 1.0


@dataclass(frozen=True)
class StickSlip:
    """Windows in which the string turns more slowly than a bit of the stated torque per weight allows, SI."""

    windows: int
    judged: int
    """Windows whose lowest stable speed is known."""
    speed: float
    """Of the window that is furthest below."""
    lowest: float
    """The lowest stable speed there; infinite where no speed is stable."""
    from_m: float
    to_m: float
    unstable: int = 0
    """Windows in which no speed is stable."""
    fed_by: tuple[str, ...] = ()
    """What feeds vibration in all of these by itself, whatever the weight on bit."""


@dataclass(frozen=True)
class ControlAdvice:
    """Settings of the speed control at one depth, SI."""

    depth_m: float
    present_proportional: float
    present_integral: float
    proportional: float
    integral: float
    vibration: float
    """Largest bit mobility with the advised settings per that with the present ones; 0 where these are unstable."""


@dataclass(frozen=True)
class WellReport:
    """Everything in the report about one well."""

    name: str
    folder: str
    description: str
    rig: str
    drilled: Drilled
    identified: Identified | None
    """None where the well has no results."""
    unused: pd.DataFrame
    problems: pd.DataFrame
    verdicts: tuple[VerdictText, ...] = ()
    sets: tuple[SetText, ...] = ()
    stick_slip: StickSlip | None = None
    control: tuple[ControlAdvice, ...] = ()

    @property
    def status(self) -> str:
        """One of 'failed', 'flagged', 'clear'."""
        if self.identified is None:
            return "failed"
        return "flagged" if self.identified.intervals or self.wrong else "clear"

    @property
    def wrong(self) -> list[VerdictText]:
        """Verdicts that something is wrong."""
        return [verdict for verdict in self.verdicts if verdict.wrong]

    def titles(self, number: int) -> str:
        """What the verdicts of a set of windows name; one verdict may tell of several sets that are clear."""
        each = self.sets[number]
        inside = [verdict for verdict in self.verdicts if _within(verdict, each)]
        around = [verdict for verdict in self.verdicts if _within(each, verdict)]
        return ", ".join(dict.fromkeys(verdict.title for verdict in inside or around))

    def between_windows(self, number: int) -> list[VerdictText]:
        """Verdicts in a set that are on an interval that stands out of its run."""
        each = self.sets[number]
        inside = [verdict for verdict in self.wrong if each.from_m <= verdict.to_m and verdict.from_m <= each.to_m]
        return [verdict for verdict in inside if self.interval_of(verdict)]

    @property
    def told(self) -> list[int]:
        """Numbers of the sets whose evidence is told: of those that name the same, the last."""
        return sorted({self.titles(number): number for number in range(len(self.sets))}.values())

    @property
    def alike(self) -> list[int]:
        """Numbers of the other sets."""
        return [number for number in range(len(self.sets)) if number not in self.told]

    @property
    def deviations(self) -> list[Comparison]:
        """Parameters that deviate from the rig's data sheets."""
        return [each for each in self.identified.comparisons if each.deviates] if self.identified else []

    @property
    def rejected(self) -> int:
        """Windows without an accepted fit."""
        return self.identified.windows - self.identified.accepted if self.identified else 0

    @property
    def many_rejected(self) -> bool:
        """Whether so many fits are not accepted that the report tells it first."""
        return bool(self.identified and self.rejected > _MANY_REJECTED * self.identified.windows)

    def interval_of(self, verdict: VerdictText) -> FlaggedInterval | None:
        """The flagged interval that a verdict names, so that both are told once."""
        intervals = self.identified.intervals if self.identified else ()
        return next((each for each in intervals if _same(each, verdict)), None)

    @property
    def unnamed_intervals(self) -> list[FlaggedInterval]:
        """Flagged intervals without a verdict of their own."""
        intervals = self.identified.intervals if self.identified else ()
        return [each for each in intervals if not any(_same(each, verdict) for verdict in self.wrong)]


def _within(one: SetText | VerdictText, other: SetText | VerdictText) -> bool:
    return other.from_m <= one.from_m and one.to_m <= other.to_m


def _same(interval: FlaggedInterval, verdict: VerdictText) -> bool:
    ends = (interval.from_m - verdict.from_m, interval.to_m - verdict.to_m)
    return verdict.wrong and max(map(abs, ends)) < _SAME_PLACE_M


def well_report(folders: WellFolders, listing: Listing, problems: pd.DataFrame) -> WellReport:
    """Read a well.

    Raises
    ------
    SettingsError
        If the rig description of a well with results cannot be read.
    """
    segments = read_segments(folders)
    has_results = folders.has("depth", "depth") and bool(folders.read("depth", "depth").sizes["depth"])
    common: dict[str, Any] = {
        "name": listing.name,
        "folder": listing.folder,
        "description": listing.description,
        "drilled": drilled(segments),
        "unused": without_windows(segments),
        "problems": problems[problems["well"] == listing.name],
    }
    if not has_results:
        return WellReport(rig="", identified=None, **common)
    rig = listing.load().rig
    verdicts, sets = read_verdict_texts(folders)
    depth = folders.read("depth", "depth").drop_dims(["frequency", "lag"]).load()
    speed = folders.read("windows", "windows")["speed"].values
    return WellReport(
        rig=rig.name,
        identified=identified(folders, rig),
        verdicts=verdicts,
        sets=sets,
        stick_slip=stick_slip(depth, speed),
        control=control_advice(depth),
        **common,
    )


def stick_slip(depth: xr.Dataset, speed: Floats) -> StickSlip | None:
    """Windows below their lowest stable speed; None without any."""
    lowest = depth["lowest_stable_speed"].values
    below = speed < lowest
    if not below.any():
        return None
    worst = int(np.argmax(np.where(below, lowest - speed, -np.inf)))
    place, never = depth["depth"].values[below], np.isposinf(lowest)
    slope = depth["critical_slope"].values[never]
    # without the rock the speed control alone has no critical slope
    feeding = {"bit": slope < 0, "speed control": np.isnan(slope)}
    fed_by = tuple(name for name, there in feeding.items() if there.any())
    return StickSlip(
        int(below.sum()),
        int((~np.isnan(lowest)).sum()),
        float(speed[worst]),
        float(lowest[worst]),
        float(place.min()),
        float(place.max()),
        int(never.sum()),
        () if np.any(slope >= 0) else fed_by,
    )


def control_advice(depth: xr.Dataset) -> tuple[ControlAdvice, ...]:
    """Settings at the depths at which they were sought."""
    rows = np.flatnonzero(np.isfinite(depth["tuned_proportional"].values))
    rows = rows[np.argsort(depth["depth"].values[rows], kind="stable")]
    present, tuned = ("present_proportional", "present_integral"), ("tuned_proportional", "tuned_integral")
    columns = (depth[name].values[rows] for name in ("depth", *present, *tuned, "tuned_vibration"))
    return tuple(ControlAdvice(*map(float, row)) for row in zip(*columns, strict=True))
