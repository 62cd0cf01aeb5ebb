"""Pictures of the sealed proof."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.special import ndtr

from benchmarks.blind.scores import calibration, claims, confusion
from benchmarks.blind.vocabulary import NONE

_EDGES = np.geomspace(0.5, 40.0, 10)
_LEAST = 3
"""Cases of which a share is drawn."""


def efficiency(table: pd.DataFrame, path: Path) -> None:
    """Share of cases detected and named rightly against the ideal test's √λ, where a bin has enough of them."""
    single = table[~table["removed"] & table["linear"] & (table["hidden"] != NONE)]
    single = single[~single["hidden"].str.contains("+", regex=False)]
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    single = single[single["detectability"].between(_EDGES[0], _EDGES[-1])]
    binned = single.assign(place=np.digitize(single["detectability"], _EDGES))
    grouped = binned.groupby("place").filter(lambda group: len(group) >= _LEAST).groupby("place")
    middle, cases = grouped["detectability"].median(), grouped.size()
    for column, label, marker in (("detected", "engine, detected", "o"), ("right", "engine, named rightly", "s")):
        share = grouped[column].mean()
        error = np.sqrt(np.maximum(share * (1 - share), 0.25 / cases) / cases)
        axes.errorbar(middle, share, error, marker=marker, capsize=3, label=label)
    axes.plot(middle, grouped["family_power"].mean(), "k-", label="ideal test over all candidates")
    fine = np.geomspace(_EDGES[0], _EDGES[-1], 200)
    axes.plot(fine, ndtr(fine - 1.645), "k:", label="ideal test of one known cause")
    axes.set(xscale="log", xlabel="detectability √λ", ylabel="share of cases", ylim=(-0.03, 1.03))
    axes.set_title(f"Detection efficiency, {len(single)} single linear causes")
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right")
    _save(figure, path)


def calibration_plot(table: pd.DataFrame, path: Path) -> None:
    """Share of true verdicts against the probability stated."""
    bins = calibration(claims(table))
    figure, axes = plt.subplots(figsize=(5, 4.5), layout="constrained")
    count = bins["verdicts"]
    error = np.sqrt(np.maximum(bins["right"] * (1 - bins["right"]), 0.25 / count) / count)
    axes.plot([0, 1], [0, 1], "k:", label="calibrated")
    axes.errorbar(bins["stated"], bins["right"], error, marker="o", capsize=3, label="engine")
    for stated, right, verdicts in bins.itertuples(index=False):
        axes.annotate(str(int(verdicts)), (stated, right), xytext=(5, -12), textcoords="offset points", fontsize=8)
    axes.set(xlabel="stated probability", ylabel="share of true verdicts", xlim=(0, 1.03), ylim=(0, 1.03))
    axes.set_title("Calibration, with numbers of verdicts")
    axes.grid(alpha=0.3)
    axes.legend()
    _save(figure, path)


def confusion_plot(table: pd.DataFrame, path: Path) -> None:
    """The confusion matrix in shares of each row."""
    counts = confusion(table)
    shares = counts.div(counts.sum(axis=1), axis=0)
    figure, axes = plt.subplots(figsize=(4 + 0.36 * shares.shape[1], 2 + 0.3 * shares.shape[0]), layout="constrained")
    image = axes.imshow(shares, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    axes.set_xticks(range(shares.shape[1]), shares.columns, rotation=90, fontsize=8)
    axes.set_yticks(range(shares.shape[0]), [f"{name} ({counts.loc[name].sum()})" for name in shares.index], fontsize=8)
    axes.set(xlabel="named", ylabel="hidden (cases)")
    for row, column in zip(*np.nonzero(counts.to_numpy()), strict=True):
        shade = "white" if shares.iloc[row, column] > 0.6 else "black"
        axes.text(column, row, str(counts.iloc[row, column]), ha="center", va="center", fontsize=7, color=shade)
    figure.colorbar(image, label="share of the row")
    axes.set_title("Causes large enough to be seen, and nulls")
    _save(figure, path)


def _save(figure: Figure, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)
