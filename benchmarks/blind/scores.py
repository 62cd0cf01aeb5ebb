"""Scores over all cases."""

import numpy as np
import pandas as pd
from scipy.stats import binomtest

from drillid.discrepancy.verdicts.verdict import NONE, UNKNOWN

_BINS = 10
_CONFIDENCE = 0.95
_NO_CAUSE = ("class with it", "class without it", "several", UNKNOWN, NONE)
"""Verdicts other than a single cause."""

TARGETS: dict[str, tuple[str, float | tuple[float, float]]] = {
    "false_alarm": ("<=", 0.05),
    "false_alarm_upper": ("<=", 0.08),
    "accuracy_at_2x": (">=", 0.95),
    "power_ratio": (">=", 0.9),
    "unknown_share": (">=", 0.8),
    "wrong_family_confident": ("<=", 0.03),
    "coverage95": ("in", (0.90, 0.98)),
    "calibration_error": ("<=", 0.05),
    "location_within_5pct": (">=", 0.95),
    "gain_positive": (">=", 0.95),
    "second_pass_none": (">=", 0.95),
}


def scores(table: pd.DataFrame) -> dict[str, float]:
    """Scores of a table of judgements; NaN where no case applies.

    - false_alarm: nulls with another verdict than none; false_alarm_upper: one-sided 95 % limit of Clopper and Pearson
    - accuracy_at_2x: cause or exact class named, of single causes and pairs at twice the size where the ideal test over
      the whole family of candidates has 50 % power
    - accuracy_at_2x_in_turn: the same without the cases that have a zone of local damping in the place of their turn
    - ideal_power_at_2x: share of these that the ideal test detects, less than all where an effect stops growing
    - power_ratio: cases detected per case that the ideal test over the family would detect, single linear causes
    - unknown_share: removed causes, at twice the size where the ideal test unaware of them has 50 % power, without a
      stand-in in the catalogue, with the verdict unknown; unknown_share_any: those with a stand-in as well
    - wrong_family_confident: removed causes without a stand-in with a name of another family at a probability above 0.9
    - coverage95, gain_positive, second_pass_none: over rightly named single causes
    - location_within_5pct: over zones named alone with a stated place; zones_placed: share of named zones with one
    - detections_named: single causes that are not linear, or tones, and show, with the right name
    """
    nulls, with_cause = table[table["hidden"] == NONE], table[table["hidden"] != NONE]
    kept, removed = with_cause[~with_cause["removed"]], with_cause[with_cause["removed"]]
    alone = kept[~kept["hidden"].str.contains("+", regex=False)]
    single, nonlinear = alone[alone["linear"]], alone[~alone["linear"] & alone["shows"]]
    large, gone = kept[kept["large"]], removed[removed["large"] & ~removed["still_there"]]
    zones = kept[(kept["hidden"] == "local_damping_zone") & (kept["named"] == "local_damping_zone")]
    alarms = int(nulls["detected"].sum())
    return {
        "cases": len(table),
        "false_alarm": _share(nulls["detected"]),
        "false_alarm_upper": upper_limit(alarms, len(nulls)),
        "accuracy_at_2x": _share(large["right"]),
        "power_ratio": float(single["detected"].sum() / single["family_power"].sum()) if len(single) else np.nan,
        "unknown_share": _share(gone["named"] == UNKNOWN),
        "wrong_family_confident": _share(removed[~removed["still_there"]]["sure_of_wrong_family"]),
        "coverage95": _share(kept["covered"]),
        "calibration_error": calibration_error(table),
        "location_within_5pct": _share(kept["location_error"].dropna().astype(float) <= 0.05),
        "gain_positive": _share(kept["gain_positive"]),
        "second_pass_none": _share(kept["second_none"]),
        "accuracy_at_2x_in_turn": _share(large[large["in_turn"]]["right"]),
        "contains_at_2x": _share(large["contains"]),
        "ideal_power_at_2x": float(large["family_power"].mean()) if len(large) else np.nan,
        "unknown_share_any": _share(removed[removed["large"]]["named"] == UNKNOWN),
        "power_ratio_known_cause": float(single["detected"].sum() / single["power"].sum()) if len(single) else np.nan,
        "zones_placed": _share(zones["location_error"].notna()),
        "detections_named": _share(nonlinear["right"]),
        "failures": int((table["failure"] != "").sum()),
        "single_linear": len(single),
        "nulls": len(nulls),
        "removed": len(removed),
        "at_2x": len(large),
        "removed_at_2x": len(gone),
        "without_ideal": int(with_cause["detectability"].isna().sum()),
        "covered_of": int(kept["covered"].notna().sum()),
        "detections_of": len(nonlinear),
        "located_of": int(kept["location_error"].notna().sum()),
    }


def _share(column: pd.Series) -> float:
    """Mean over the cases with a value; NaN without any."""
    return float(column.astype(float).mean())


def upper_limit(count: int, cases: int) -> float:
    """Upper limit of a share by Clopper and Pearson (1934), Biometrika 26, 404–413, one-sided."""
    if cases == 0:
        return 1.0
    return float(binomtest(count, cases, alternative="less").proportion_ci(_CONFIDENCE, method="exact").high)


def claims(table: pd.DataFrame) -> pd.DataFrame:
    """All verdicts: kind, stated probability, and whether they are true."""
    rows = [claim for row in table["claims"] for claim in row]
    return pd.DataFrame(rows, columns=["kind", "stated", "right"]).astype({"stated": float, "right": float})


def calibration(table: pd.DataFrame) -> pd.DataFrame:
    """Mean stated probability and share of true verdicts in bins of probability."""
    verdicts = claims(table)
    grouped = verdicts.groupby(np.minimum((verdicts["stated"].to_numpy() * _BINS).astype(int), _BINS - 1))
    return pd.DataFrame(
        {"stated": grouped["stated"].mean(), "right": grouped["right"].mean(), "verdicts": grouped.size()}
    )


def calibration_error(table: pd.DataFrame) -> float:
    """Expected calibration error: mean distance of stated probability and share of true verdicts, by verdicts."""
    bins = calibration(table)
    weight = bins["verdicts"] / bins["verdicts"].sum()
    return float((weight * (bins["stated"] - bins["right"]).abs()).sum())


def confusion(table: pd.DataFrame) -> pd.DataFrame:
    """Confusion matrix of detectable single causes that are in the catalogue, and of nulls.

    Causes come first, in the same order in rows and columns, then the other verdicts.
    """
    kept = table[(table["hidden"] == NONE) | (~table["removed"] & table["shows"])]
    kept = kept[~kept["hidden"].str.contains("+", regex=False)]
    named = kept["named"].where(~kept["named"].str.contains("+", regex=False), "several")
    short = named.where(~named.str.contains("|", regex=False), "class with it").where(
        ~named.str.contains("|", regex=False) | (kept["contains"] & (kept["hidden"] != NONE)), "class without it"
    )
    counts = pd.crosstab(kept["hidden"], short, rownames=["hidden"], colnames=["named"])
    causes = sorted((set(counts.index) | set(counts.columns)) - set(_NO_CAUSE))
    rows, columns = (
        [name for name in (*causes, *_NO_CAUSE) if name in axis] for axis in (counts.index, counts.columns)
    )
    return counts.loc[rows, columns]


def holds(name: str, value: float) -> bool | None:
    """Whether a score meets its target; None without a target or a value."""
    if name not in TARGETS or np.isnan(value):
        return None
    relation, target = TARGETS[name]
    if isinstance(target, tuple):
        return bool(target[0] <= value <= target[1])
    return bool(value <= target if relation == "<=" else value >= target)
