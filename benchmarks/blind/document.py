"""docs/discovery.md: how the engine is proved, and what it reaches."""

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
    "signs_of",
    "located_of",
)
_TEXT = """# The discovery engine's proof

Written by `make blind` (`python -m benchmarks.blind --cases {cases} --document`); do not edit.

Each case is drawn from a seed: a rig, a string of 1000 to 5000 m, 1 to 24 windows of 600 s, data sheets that are right
within their tolerances as normal variables, and in about half of the cases a hidden cause, in a tenth of these a pair
of causes, and in a quarter a cause that the engine's catalogue does not hold. The causes take turns, but for a
twentieth that are zones of local damping, for enough of them to be located. The data come from the non-linear
time-domain simulator (`drillid.simulation.simulate`) with coloured bit noise whose level wanders, a sampled speed
control, noise and rounding of the recorded speed. The engine is given the logs and the data sheets and
nothing else; the lines of its calibration come from other seeds.

## The ideal test

A likelihood ratio that knows the cause, its shape and all but the nuisance figures has the noncentrality λ: the least
squared distance, with the noise and the data sheets' tolerances as units, between the rig with the cause and any rig
without it. It is computed from the equipment that is simulated, not from the engine's model. A cause is *detectable*
with the power Φ(√λ − z), where z holds 5 % for one known cause, or 5 % over the family of candidates: about
{candidates} are effectively distinct (Li and Ji 2005). `power_ratio` and "twice the size" refer to the latter: at half
the size, and at the size itself, the ideal test over the family has 50 % power or more. Sizes are drawn so that √λ is
even in its logarithm over 1 … 30, or over 10 … 30 where the catalogue lacks the cause, as far as physical sizes allow.
{without_ideal} cases hide what is not linear (limits, play, steps, regimes); they have no such test and are left out of
`power_ratio`. Of limits and play it is known what they leave in the records, as the same rig is simulated under the
same noise without them: a limit that is never reached leaves nothing, nor does a play that never opens. They show where
a test over the family that knows what they leave, sample by sample, would see half of it.

An answer is right where every verdict is the hidden cause, or a class of causes that cannot be told from it: the ideal
test between two of them would be right in less than 95 % of sets, as they are closer than 3.29 standard deviations.
Of two causes each is weighed beside the other, which the ideal test lets take any size.
Where the bit stands for some of the time, whatever makes it stand, regimes of sticking and slipping are a right answer.

A cause that is taken out of the catalogue has no test that knows it. The best that does not is a χ² of 24 degrees of
freedom, as many as a smooth disturbance at a port has, at any of seven ports. In the cases that `unknown_share` counts
it has 50 % power or more at half the size, and it sees in 95 % of sets what the nearest other cause leaves, or the
nearest two together: that is 6.5 standard deviations or more. `unknown_share_any` counts those with a nearer twin as
well, whose name is an answer that no test without the cause can refute. Gains of actuator, control and record are each
exactly the other two together.

A stated probability is true where the verdict is: one of its members is there, or nothing is, or nothing that the
catalogue holds.

## What it reaches

| figure | engine | target | holds | at random |
|---|---|---|---|---|
{rows}

The false-alarm limit is the one-sided 95 % limit of Clopper and Pearson over {nulls} cases that hide nothing;
`accuracy_at_2x` counts {at_2x} cases, of which the ideal test itself would detect `ideal_power_at_2x`, as some effects
stop growing with their size; `unknown_share` {removed_at_2x}, `coverage95` {covered_of},
`detections_named` {signs_of} single causes that are not linear, or tones, and show;
`location_within_5pct` {located_of}, where a zone alone is named and a place is stated: the engine states one where it
is sure of it to 95 %, as it is of `zones_placed` of the zones that it names. `accuracy_at_2x_in_turn` leaves out the
cases that were turned to such zones.

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
    found: dict[str, float],
    guessed: dict[str, float],
    table: pd.DataFrame,
) -> None:
    """Write discovery.md and its pictures into a folder.

    Parameters
    ----------
    folder, pictures : where to write, and where the pictures are
    found, guessed : figures of merit of the engine and of one that answers at random
    table : judgements of the engine
    """
    (folder / "discovery").mkdir(parents=True, exist_ok=True)
    for name in _PICTURES:
        shutil.copyfile(pictures / f"{name}.png", folder / "discovery" / f"{name}.png")
    text = _TEXT.format(
        **{name: int(found[name]) for name in _COUNTS},
        candidates=f"{table['candidates'].median():.0f}",
        rows="\n".join(_row(name, found[name], guessed[name]) for name in found),
        confusion=_markdown(confusion(table)),
    )
    (folder / "discovery.md").write_text(text)


def _row(name: str, value: float, guess: float) -> str:
    sign, target = TARGETS.get(name, ("", ""))
    meets = holds(name, value)
    said = {None: "", True: "yes", False: "no"}[meets]
    wanted = (
        f"{target[0]} … {target[1]}"
        if isinstance(target, tuple)
        else f"{sign} {target}".replace("<=", "≤").replace(">=", "≥")
    )
    return f"| {name} | {value:.4g} | {wanted.strip()} | {said} | {guess:.4g} |"


def _markdown(table: pd.DataFrame) -> str:
    """Rows as lists, as a matrix of all names is too wide to read."""
    lines = ["| hidden | named (cases) |", "|---|---|"]
    for name, row in table.iterrows():
        said = ", ".join(f"{other} {count}" for other, count in row[row > 0].sort_values(ascending=False).items())
        lines.append(f"| {name} | {said} |")
    return "\n".join(lines)
