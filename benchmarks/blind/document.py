"""docs/discovery.md: how the engine is tested on sealed cases, and its scores."""

import shutil
from pathlib import Path

import pandas as pd

from benchmarks.blind.scores import TARGETS, confusion, holds

_PICTURES = ("efficiency", "calibration", "confusion")
_COUNTS = (
    "cases",
    "nulls",
    "without_ideal",
    "at_2x",
    "removed_at_2x",
    "covered_of",
    "detections_of",
    "located_of",
)
_TEXT = """# The discovery engine's proof

Written by `make blind` (`python -m benchmarks.blind --cases {cases} --document`); do not edit.

Each case is drawn from a seed: a rig, a string of 1000 to 5000 m, 1 to 24 windows of 600 s, a data sheet in error by
normal variables of its tolerances, and in about half of the cases a hidden cause, in a tenth of these a pair of causes,
and in a quarter a cause that is removed from the engine's catalogue. The causes follow each other in turn, except for
a twentieth that are zones of local damping, so that enough of them can be located. The data come from the non-linear
time-domain simulator (`drillid.simulation.simulate`) with coloured bit noise of slowly varying level, a sampled speed
control, noise and rounding of the recorded speed. The engine is given the logs and the data sheet and nothing else;
the lines of its calibration come from other seeds.

## The ideal test

A likelihood ratio test that knows the cause, its shape and all but the nuisance parameters has the noncentrality λ: the
least squared distance, in units of the noise and of the data sheet's tolerances, between the rig with the cause and any
rig without it. It is computed from the simulated equipment, not from the engine's model. A cause is *detectable*
with the power Φ(√λ − z), where z holds 5 % for one known cause, or 5 % over the family of candidates: about
{candidates} are effectively distinct (Li and Ji 2005). `power_ratio` and "twice the size" refer to the latter: at half
the size, and at the size itself, the ideal test over the family has 50 % power or more. Sizes are drawn so that √λ is
log-uniform over 1 … 30, or over 10 … 30 where the catalogue lacks the cause, as far as physical sizes allow.
{without_ideal} cases hide what is not linear (limits, play, steps, regimes); they have no such test and are left out of
`power_ratio`. The trace of limits and play in the records is known, as the same rig is simulated under the same noise
without them: a limit that is never reached leaves none, nor does a play that never opens. They count where a test over
the family that knows the trace, sample by sample, would detect half of it.

An answer is right where every verdict is the hidden cause, or a class of causes that cannot be distinguished from it:
the ideal test between two of them would be right in less than 95 % of sets, as they are closer than 3.29 standard
deviations. Of two causes each is tested given the other, whose size is free in the ideal test.
Where the bit stands for some of the time, for whatever reason, stick-slip is a right answer.

For a cause that is removed from the catalogue, the best test is unaware of it: a χ² of 24 degrees of freedom, as many
as a smooth disturbance at a port has, at any of seven ports. In the cases that `unknown_share` counts it has 50 % power
or more at half the size, and 95 % power for what the nearest other cause leaves, or the nearest two together: that is
6.5 standard deviations or more. `unknown_share_any` counts those with a nearer stand-in as well, a name that no test
without the cause can refute. Gains of actuator, control and record are each exactly the other two together.

A verdict is true where one of its members is present, where nothing is wrong if it is `none`, or where the cause is not
in the catalogue if it is `unknown`.

## Scores

| score | engine | target | holds | at random |
|---|---|---|---|---|
{rows}

The false-alarm limit is the one-sided 95 % limit of Clopper and Pearson over {nulls} cases without a hidden cause;
`accuracy_at_2x` counts {at_2x} cases, of which the ideal test itself would detect `ideal_power_at_2x`, as some effects
saturate with size; `unknown_share` {removed_at_2x}, `coverage95` {covered_of},
`detections_named` {detections_of} single causes that are not linear, or tones, and show;
`location_within_5pct` {located_of}, where a zone alone is named and a place is stated: the engine states one where it
has 95 % confidence in it, as for a share `zones_placed` of the zones that it names. `accuracy_at_2x_in_turn` omits the
cases that have such a zone in the place of their turn.

![Detection efficiency](discovery/efficiency.png)

![Calibration](discovery/calibration.png)

![Confusion](discovery/confusion.png)

## Confusion matrix

Single causes at twice the size, or without an ideal test where they show, and nulls.

{confusion}
"""


def write_document(
    folder: Path,
    pictures: Path,
    reached: dict[str, float],
    guessed: dict[str, float],
    table: pd.DataFrame,
) -> None:
    """Write discovery.md and its pictures into a folder.

    Parameters
    ----------
    folder, pictures : where to write, and where the pictures are
    reached, guessed : scores of the engine and of one that answers at random
    table : judgements of the engine
    """
    (folder / "discovery").mkdir(parents=True, exist_ok=True)
    for name in _PICTURES:
        shutil.copyfile(pictures / f"{name}.png", folder / "discovery" / f"{name}.png")
    text = _TEXT.format(
        **{name: int(reached[name]) for name in _COUNTS},
        candidates=f"{table['candidates'].median():.0f}",
        rows="\n".join(_row(name, reached[name], guessed[name]) for name in reached),
        confusion=_markdown(confusion(table)),
    )
    (folder / "discovery.md").write_text(text)


def _row(name: str, value: float, guess: float) -> str:
    relation, target = TARGETS.get(name, ("", ""))
    meets = holds(name, value)
    verdict = {None: "", True: "yes", False: "no"}[meets]
    wanted = (
        f"{target[0]} … {target[1]}"
        if isinstance(target, tuple)
        else f"{relation} {target}".replace("<=", "≤").replace(">=", "≥")
    )
    return f"| {name} | {value:.4g} | {wanted.strip()} | {verdict} | {guess:.4g} |"


def _markdown(table: pd.DataFrame) -> str:
    """Rows as lists, as a matrix of all names is too wide to read."""
    lines = ["| hidden | named (cases) |", "|---|---|"]
    for name, row in table.iterrows():
        named = ", ".join(f"{other} {count}" for other, count in row[row > 0].sort_values(ascending=False).items())
        lines.append(f"| {name} | {named} |")
    return "\n".join(lines)
