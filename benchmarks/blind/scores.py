"""Figures of merit over all cases."""

import numpy as np
import pandas as pd
from scipy.stats import binomtest

from drillid.discrepancy.verdicts.verdict import NONE, UNKNOWN

_BINS = 10
_CONFIDENCE = 0.95
_NO_CAUSE = ("class with it", "class without it", "several", UNKNOWN, NONE)
"""What a verdict may be but a single cause."""

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
    """Figures of merit of a table of judgements; NaN where no case asks the question.

    - false_alarm: nulls with another verdict than none; false_alarm_upper: one-sided 95 % limit of Clopper and Pearson
    - accuracy_at_2x: cause or exact class named, of single causes and pairs at twice the size where the ideal test over
      the whole family of candidates has 50 % power
    - accuracy_at_2x_in_turn: the same without the cases that are turned to a zone of local damping to be located
    - ideal_power_at_2x: share of these that the ideal test detects, less than all where an effect stops growing
    - power_ratio: cases detected per case that the ideal test over the family would detect, single linear causes
    - unknown_share: removed causes, at twice the size where the ideal test that does not know them has 50 % power,
      without a stand-in in the catalogue, that are called unknown; unknown_share_any: those with a stand-in as well
    - wrong_family_confident: removed causes without a stand-in with a name of another family at a probability above 0.9
    - coverage95, gain_positive, second_pass_none: of right names of single causes
    - location_within_5pct: of these where a zone alone is named and its place is stated; zones_placed: share that is
    - detections_named: single causes that are not linear, or tones, and show, that are named right
    """
    nulls, found = table[table["hidden"] == NONE], table[table["hidden"] != NONE]
    kept, removed = found[~found["removed"]], found[found["removed"]]
    alone = kept[~kept["hidden"].str.contains("+", regex=False)]
    single, signs = alone[alone["linear"]], alone[~alone["linear"] & alone["shows"]]
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
        "detections_named": _share(signs["right"]),
        "failures": int((table["failure"] != "").sum()),
        "single_linear": len(single),
        "nulls": len(nulls),
        "removed": len(removed),
        "at_2x": len(large),
        "removed_at_2x": len(gone),
        "without_ideal": int(found["detectability"].isna().sum()),
        "covered_of": int(kept["covered"].notna().sum()),
        "signs_of": len(signs),
        "located_of": int(kept["location_error"].notna().sum()),
    }


def _share(column: pd.Series) -> float:
    """Mean of what is known; NaN where nothing is."""
    return float(column.astype(float).mean())


def upper_limit(count: int, cases: int) -> float:
    """Upper limit of a share by Clopper and Pearson (1934), Biometrika 26, 404–413, one-sided."""
    if cases == 0:
        return 1.0
    return float(binomtest(count, cases, alternative="less").proportion_ci(_CONFIDENCE, method="exact").high)


def claims(table: pd.DataFrame) -> pd.DataFrame:
    """All verdicts: their kind, the probability stated, and whether they are true."""
    found = [claim for row in table["claims"] for claim in row]
    return pd.DataFrame(found, columns=["kind", "stated", "right"]).astype({"stated": float, "right": float})


def calibration(table: pd.DataFrame) -> pd.DataFrame:
    """Mean stated probability and share of true verdicts in bins of probability."""
    found = claims(table)
    grouped = found.groupby(np.minimum((found["stated"].to_numpy() * _BINS).astype(int), _BINS - 1))
    return pd.DataFrame(
        {"stated": grouped["stated"].mean(), "right": grouped["right"].mean(), "verdicts": grouped.size()}
    )


def calibration_error(table: pd.DataFrame) -> float:
    """Expected calibration error: mean distance of stated probability and share of true verdicts, by verdicts."""
    found = calibration(table)
    weight = found["verdicts"] / found["verdicts"].sum()
    return float((weight * (found["stated"] - found["right"]).abs()).sum())


def confusion(table: pd.DataFrame) -> pd.DataFrame:
    """How often each single cause, kept in the catalogue and of a size to be seen, is named what.

    Causes come first, in the same order in rows and columns, and then what is no cause.
    """
    kept = table[(table["hidden"] == NONE) | (~table["removed"] & table["shows"])]
    kept = kept[~kept["hidden"].str.contains("+", regex=False)]
    named = kept["named"].where(~kept["named"].str.contains("+", regex=False), "several")
    short = named.where(~named.str.contains("|", regex=False), "class with it").where(
        ~named.str.contains("|", regex=False) | (kept["contains"] & (kept["hidden"] != NONE)), "class without it"
    )
    found = pd.crosstab(kept["hidden"], short, rownames=["hidden"], colnames=["named"])
    causes = sorted((set(found.index) | set(found.columns)) - set(_NO_CAUSE))
    rows, columns = ([name for name in (*causes, *_NO_CAUSE) if name in axis] for axis in (found.index, found.columns))
    return found.loc[rows, columns]


def holds(name: str, value: float) -> bool | None:
    """Whether a figure meets its target; None without one, or where no case asks."""
    if name not in TARGETS or np.isnan(value):
        return None
    sign, target = TARGETS[name]
    if isinstance(target, tuple):
        return bool(target[0] <= value <= target[1])
    return bool(value <= target if sign == "<=" else value >= target)
