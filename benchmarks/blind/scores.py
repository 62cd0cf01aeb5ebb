"""Scores over all cases, with one-sided 95 % limits, and the limits that they are to hold."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import ndtr
from scipy.stats import beta

from benchmarks.blind.ideal.ideal import threshold
from benchmarks.blind.limits import lower_limit, resampled, upper_limit
from benchmarks.blind.vocabulary import CAUSES, NONE, UNKNOWN

_BINS = 10
_NO_CAUSE = ("class with it", "class without it", "several", UNKNOWN, NONE)
"""Verdicts other than a single cause."""
RIGHT_SHARE = 0.8
"""Share of a cause's cases at twice the size that must be right for the cause to count as known."""
_LEAST_FALSE_ALARM = 1e-4
"""Least rate of false alarms at which engines are compared."""
_FEWEST_CLAIMS = 5
"""Verdicts of a family from which its calibration is judged."""

TARGETS: dict[str, tuple[str, float]] = {
    "false_alarm_high": ("<=", 0.06),
    "accuracy_at_2x_low": (">=", 0.95),
    "accuracy_at_2x_in_turn_low": (">=", 0.95),
    "unknown_share_low": (">=", 0.80),
    "wrong_family_confident_high": ("<=", 0.02),
    "coverage95_low": (">=", 0.92),
    "coverage95_high": ("<=", 0.98),
    "calibration_error_high": ("<=", 0.04),
    "calibration_error_family_high": ("<=", 0.08),
    "location_within_5pct_low": (">=", 0.90),
    "zones_placed_low": (">=", 0.85),
    "power_ratio_low": (">=", 0.92),
    "causes_right": (">=", float(len(CAUSES))),
}
"""What a proof is to hold."""
SHARES = (
    *("false_alarm", "accuracy_at_2x", "accuracy_at_2x_in_turn", "unknown_share", "wrong_family_confident"),
    *("coverage95", "location_within_5pct", "zones_placed", "gain_positive", "second_pass_none", "detections_named"),
)
"""Scores that are shares of cases."""


def scores(table: pd.DataFrame) -> dict[str, float]:
    """Scores of a table of judgements; NaN where no case applies.

    Limits are one-sided 95 % ones: `<score>_low`, `<score>_high`, by Clopper and Pearson for shares, by resampling of
    the cases for others.

    - false_alarm: nulls with another verdict than none; false_alarm_upper is its limit under an older name
    - accuracy_at_2x: cause or exact class named, of single causes and pairs at twice the size where the ideal test over
      the whole family of candidates has 50 % power
    - accuracy_at_2x_in_turn: the same without the cases that have a zone of local damping in the place of their turn
    - ideal_power_at_2x: share of these that the ideal test detects, less than all where an effect stops growing
    - power_ratio: cases detected per case that the ideal test over the family would detect at the engine's own rate of
      false alarms, single linear causes
    - unknown_share: removed causes, at twice the size where the ideal test unaware of them has 50 % power, without a
      stand-in in the catalogue, with the verdict unknown; unknown_share_any: those with a stand-in as well
    - wrong_family_confident: removed causes without a stand-in with a name of another family at a probability above 0.9
    - coverage95, gain_positive, second_pass_none: over rightly named single causes
    - calibration_error_family: the largest of the verdicts' families
    - location_within_5pct: over zones named alone with a stated place; zones_placed: share of named zones with one
    - detections_named: single causes that are not linear, or tones, and show, with the right name
    - causes_right: causes of which at least RIGHT_SHARE of the cases at twice the size, or that show, are right;
      causes_seen: those that have any, causes_least: cases of the rarest
    """
    of_shares = columns(table)
    found: dict[str, float] = {"cases": len(table)}
    for name in SHARES:
        values = of_shares[name].dropna().astype(float)
        count, cases = round(float(values.sum())), len(values)
        found[name] = float(values.mean())
        found[f"{name}_low"], found[f"{name}_high"] = lower_limit(count, cases), upper_limit(count, cases)
    found["false_alarm_upper"] = found["false_alarm_high"]
    for name, score in _RESAMPLED.items():
        found[name] = score(table)
        of_resampled = _at_drawn_rates(table) if score is power_ratio else score
        found[f"{name}_low"], found[f"{name}_high"] = resampled(table, of_resampled)
    hidden = table["hidden"] != NONE
    kept, removed = table[hidden & ~table["removed"]], table[hidden & table["removed"]]
    large, single = kept[kept["large"]], _single_linear(table)
    by_cause = right_by_cause(table)
    return found | {
        "contains_at_2x": _share(large["contains"]),
        "ideal_power_at_2x": float(large["family_power"].mean()) if len(large) else np.nan,
        "unknown_share_any": _share(removed[removed["large"]]["named"] == UNKNOWN),
        "power_ratio_known_cause": float(single["detected"].sum() / single["power"].sum()) if len(single) else np.nan,
        "causes_right": float((by_cause["share"] >= RIGHT_SHARE).sum()),
        "causes_seen": len(by_cause),
        "causes_least": float(by_cause["cases"].min()) if len(by_cause) == len(CAUSES) else 0.0,
        "examine_s_median_wrong": float(table[hidden]["seconds"].median()),
        "examine_s_median_null": float(table[~hidden]["seconds"].median()),
        "failures": int((table["failure"] != "").sum()),
        "single_linear": len(single),
        "nulls": int((~hidden).sum()),
        "removed": len(removed),
        "at_2x": len(large),
        "removed_at_2x": len(of_shares["unknown_share"]),
        "without_ideal": int(table[hidden]["detectability"].isna().sum()),
        "covered_of": int(kept["covered"].notna().sum()),
        "detections_of": len(of_shares["detections_named"]),
        "located_of": int(kept["location_error"].notna().sum()),
    }


def columns(table: pd.DataFrame) -> dict[str, pd.Series]:
    """For every score that is a share, its cases."""
    nulls, with_cause = table[table["hidden"] == NONE], table[table["hidden"] != NONE]
    kept, removed = with_cause[~with_cause["removed"]], with_cause[with_cause["removed"]]
    alone = kept[~kept["hidden"].str.contains("+", regex=False)]
    nonlinear = alone[~alone["linear"] & alone["shows"]]
    large, gone = kept[kept["large"]], removed[removed["large"] & ~removed["still_there"]]
    zones = kept[(kept["hidden"] == "local_damping_zone") & (kept["named"] == "local_damping_zone")]
    return {
        "false_alarm": nulls["detected"],
        "accuracy_at_2x": large["right"],
        "accuracy_at_2x_in_turn": large[large["in_turn"]]["right"],
        "unknown_share": gone["named"] == UNKNOWN,
        "wrong_family_confident": removed[~removed["still_there"]]["sure_of_wrong_family"],
        "coverage95": kept["covered"],
        "location_within_5pct": kept["location_error"].dropna().astype(float) <= 0.05,
        "zones_placed": zones["location_error"].notna(),
        "gain_positive": kept["gain_positive"],
        "second_pass_none": kept["second_none"],
        "detections_named": nonlinear["right"],
    }


def _single_linear(table: pd.DataFrame) -> pd.DataFrame:
    single = table[(table["hidden"] != NONE) & ~table["removed"] & table["linear"]]
    return single[~single["hidden"].str.contains("+", regex=False)]


def power_ratio(table: pd.DataFrame, rate: float | None = None) -> float:
    """Single linear causes detected per one that the ideal test would detect at the same rate of false alarms.

    Parameters
    ----------
    rate : of false alarms; by default the mean of its posterior
    """
    single, nulls = _single_linear(table), table[table["hidden"] == NONE]
    if not len(single) or not len(nulls):
        return float("nan")
    rate = max(_alarm_rate(table).mean() if rate is None else rate, _LEAST_FALSE_ALARM)
    ideal = [
        float(ndtr(row.detectability - threshold(row.candidates, min(rate, 1 - _LEAST_FALSE_ALARM))))
        for row in single.itertuples()
    ]
    return float(single["detected"].sum() / np.nansum(ideal))


def _alarm_rate(table: pd.DataFrame) -> Any:
    """Posterior of the rate of false alarms from Jeffreys' prior, as few of them hardly tell it."""
    nulls = table[table["hidden"] == NONE]
    alarms = int(nulls["detected"].sum())
    return beta(alarms + 0.5, len(nulls) - alarms + 0.5)


def _at_drawn_rates(table: pd.DataFrame) -> Callable[[pd.DataFrame], float]:
    """The power ratio of further tables at rates drawn from the posterior of this one."""
    rate, generator = _alarm_rate(table), np.random.default_rng(1)
    return lambda drawn: power_ratio(drawn, float(rate.rvs(random_state=generator)))


def right_by_cause(table: pd.DataFrame) -> pd.DataFrame:
    """For every single cause its cases at twice the size, or that show, and the share that is right."""
    seen = table[(table["hidden"] != NONE) & ~table["removed"] & table["shows"]]
    seen = seen[~seen["hidden"].str.contains("+", regex=False)]
    grouped = seen.groupby("hidden")["right"]
    return pd.DataFrame({"cases": grouped.size(), "share": grouped.mean().astype(float)})


def at_equal_alarms(table: pd.DataFrame, rate: float) -> dict[str, float]:
    """Detection of an engine whose threshold is set to give false alarms at a rate, on single linear causes.

    `power_ratio` is against the ideal test at that rate, `right_at_2x` the share named rightly at twice the size.
    """
    nulls, rate = table[table["hidden"] == NONE], max(rate, _LEAST_FALSE_ALARM)
    least = float(np.quantile(nulls["score"], 1 - rate, method="higher")) if len(nulls) else np.inf
    alarmed = table.assign(detected=table["score"] > least)
    large = alarmed[alarmed["large"] & ~alarmed["removed"]]
    return {
        "false_alarm": float(alarmed[alarmed["hidden"] == NONE]["detected"].mean()),
        "power_ratio": power_ratio(alarmed),
        "right_at_2x": _share(large["right"] & large["detected"]),
    }


def _share(column: pd.Series) -> float:
    """Mean over the cases with a value; NaN without any."""
    return float(column.astype(float).mean())


def claims(table: pd.DataFrame) -> pd.DataFrame:
    """All verdicts: kind, family, stated probability, and whether they are true."""
    rows = [claim for row in table["claims"] for claim in row]
    frame = pd.DataFrame(rows, columns=["kind", "family", "stated", "right"])
    return frame.astype({"stated": float, "right": float})


def calibration(verdicts: pd.DataFrame) -> pd.DataFrame:
    """Mean stated probability and share of true verdicts in bins of probability."""
    grouped = verdicts.groupby(np.minimum((verdicts["stated"].to_numpy() * _BINS).astype(int), _BINS - 1))
    return pd.DataFrame(
        {"stated": grouped["stated"].mean(), "right": grouped["right"].mean(), "verdicts": grouped.size()}
    )


def calibration_error(table: pd.DataFrame) -> float:
    """Expected calibration error: mean distance of stated probability and share of true verdicts, by verdicts."""
    return _error(claims(table))


def calibration_error_family(table: pd.DataFrame) -> float:
    """The same, the largest of the families of the causes that are named; NaN where none is named often enough."""
    verdicts = claims(table)
    named = verdicts[verdicts["family"] != ""].groupby("family").filter(lambda group: len(group) >= _FEWEST_CLAIMS)
    # one mean distance for a family: bins of a few verdicts would show their scatter
    errors = [abs(float((group["stated"] - group["right"]).mean())) for _, group in named.groupby("family")]
    return max(errors, default=float("nan"))


def _error(verdicts: pd.DataFrame) -> float:
    bins = calibration(verdicts)
    weight = bins["verdicts"] / bins["verdicts"].sum()
    return float((weight * (bins["stated"] - bins["right"]).abs()).sum())


_RESAMPLED = {
    "power_ratio": power_ratio,
    "calibration_error": calibration_error,
    "calibration_error_family": calibration_error_family,
}


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
    """Whether a score meets its target; None without a target, False without a value."""
    if name not in TARGETS:
        return None
    relation, target = TARGETS[name]
    return bool(value <= target if relation == "<=" else value >= target)
