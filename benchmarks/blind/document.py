"""docs/discovery.md: how the engine is tested on sealed cases, all blocks ever run, and the scores in each world."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.blind import blocks
from benchmarks.blind.at_best import at_best
from benchmarks.blind.scores import TARGETS, confusion, holds, right_by_cause
from benchmarks.blind.world import OFF_DOCUMENTS

_PICTURES = ("efficiency", "calibration", "confusion")
_COUNTS = ("cases", "nulls", "without_ideal", "at_2x", "removed_at_2x", "covered_of", "detections_of", "located_of")
_TITLES = {"own": "the first world", "other": "the second world"}
_TEXT = """# The discovery engine's proof

Written by `make blind`, part by part; do not edit.

Each case is drawn from a seed: a rig, a string of 1000 to 5000 m, 1 to 24 windows of 600 s, a data sheet in error, and
in about half of the cases a hidden cause. A tenth of these hide a pair of causes, and a quarter a cause that the
engine's catalogue lacks. The causes take turns, except for a twentieth that are zones of local damping, so that enough
of them can be located. From seed {stratified} on, the kinds of each cause's cases follow a plan: half of the single
causes are drawn large on purpose, on a rig on which they can be, and a block of the registered size holds {large} of
each. The engine is given the logs and the data sheet and nothing else. The judge imports nothing from it.

## Two worlds

In the *first world* (`benchmarks/blind/generator`) data come from the library's non-linear time-domain simulator, with
coloured bit noise of slowly varying level, noise and rounding of the recorded speed, and data sheets with normally
distributed errors set by their tolerances.

The *second world* (`benchmarks/blind/other_world`) imports nothing of the library's physics, simulation or discovery,
as an import contract enforces. Its string is divided into finite elements whose damped modes are advanced exactly, with
boundary-layer drag and causal losses of the steel as relaxations; its convergence to closed forms is tested
(`tests/truth/blind/test_other_world.py`). Its rigs have tool joints, collars of two sizes with stabilisers, some joints
of heavier pipe, casing and open hole, stiff mud motors, and dry friction after Karnopp, Dahl or LuGre; control that
samples and holds at 5 to 50 ms with its own anti-windup; recorders, not synchronised with the control, that hold or
interpolate its samples; bit noise with bursts, heavy tails and narrow lines; set points and weights that wander; and
data sheets with heavy-tailed errors, one in twenty with a value that is wrong outright. What is hidden has shapes that
the engine's models lack: zones over 1 to 30 % of the pipe with smooth ends, motors anywhere within the lumped inertia,
3 to 8 blades, other laws of falling friction. Of effects that no catalogue holds it hides a rippled pipe, a soft joint
in the string, a notch in the control and a resonant drive, for which `unknown` is right. Where the control reads the
speed every 20 ms or less often, `sample_and_hold` is a true verdict whatever else is hidden; so are `clock_offset` and
`wave_speed` where the clock or the waves' travel time is off by more than {off:.0f} times the tolerance that its
documents state, as the heavy tails occasionally make it. Up to block 380000 a drifting damping at the bit changed in 60
steps there, whose torques coincided with the sweep's harmonics: drifts came out at 0.88 of their size.

## The ideal test

A likelihood ratio test that knows the cause, its shape and all but the nuisance parameters has the noncentrality λ: the
smallest squared distance, in units of the noise and of the data sheet's tolerances, between the rig with the cause and
any rig without it. The interval at which a control reads is also a nuisance parameter where the rows do not show it.
The test knows that one data sheet in twenty has a value that is wrong outright, which it may assume at the odds against
it. Where a control samples and holds, the distance has several minima, for delays that are off by parts of its interval
and for intervals that no row shows; the search starts from all of them. Up to block 310000 of the second world it
started from the truth alone, which made √λ of a lag 15.5 and 15.8 in the cases 310002 and 310101, where it is 4.6 and
3.0. So in those blocks λ, and what is said of twice the size and of the ideal test, is too large for what a held
control can hide. Up to block 360000 a motor that was hidden in the second world also doubled the damping at the bit,
which the ideal test saw and no test of the logs can see, and the ideal test knew which value of the data sheet was
wrong outright. Up to block 500000 the ideal test tried an extra section at three polar moments, so that a taper that is
the same string counted as distinct. Up to block 710000 another interval of the control changed the delay that the
documents state at no cost, the noise lacked what a recorder folds into the band and what wandering weights and set
points add, and the strength of a notch and of a resonant drive was a frequency, so that both were drawn far larger than
said. Up to block 720000 searches from other intervals stopped where linear theory at their beginning saw no lower
distance.

The distance is computed from the simulated equipment, in the second world from that world's own closed forms, not from
the engine's model. A cause is *detectable* with the power Φ(√λ − z), where z sets the rate of false alarms to 5 % for
one known cause, or to 5 % over the family of candidates that are effectively distinct (Li and Ji 2005). "Twice the
size" refers to the latter: at half the size, and at the size itself, the ideal test over the family has 50 % power or
more. `power_ratio` compares the engine with the ideal test at the engine's own rate of false alarms, the posterior mean
by Jeffreys; its limits are over that posterior too. Up to block 710000 it was the share of alarms itself. Sizes are
drawn so that √λ is log-uniform over 1 … 30, or over 10 … 30 where the catalogue lacks the cause or it is drawn large,
as far as physical sizes allow. What is not linear (limits, play, regimes) has no such test and is left out of
`power_ratio`. The trace of limits and play in the records is known, as the same rig is simulated under the same noise
without them: a limit that is never reached leaves none, nor does a play that never opens. They count where a test over
the family that knows the trace, sample by sample, but not the drive's delay, would detect half of it; up to block
560000 it knew the delay too, although a limit that acts at every slew mostly delays the torque.

An answer is right where every verdict is the hidden cause, or a class of causes that cannot be distinguished from it:
the ideal test between two of them would be right in less than 95 % of sets, as they are closer than 3.29 standard
deviations. Every rival that explains half of the hidden cause to first order is tried from all the rival's shapes and
sizes, whoever names it; those that no engine names are not tried, as no judgement depends on them. Each of two causes
is tested given the other, whose size is free in the ideal test. Where the bit stands still for some of the time, for
whatever reason, stick-slip is a right answer, and beside what makes it stand it is no second cause, as which it counted
up to block 530000. Where a torque that falls with speed was meant to make it stand and never did, that torque is the
right answer, and the ideal test is that of the torque. Up to block 510000 there was no ideal test for it, so that it
counted as showing where nothing can be seen (√λ 0.15 and 0.21 in the cases 510011 and 510044). Up to block 530000
rivals were not searched for from all sizes where half of a cause is far less visible than a quarter of it, so that
filters of speed and torque closer than one standard deviation counted as distinct (case 530448).

For a cause that is removed from the catalogue, the best test is unaware of it: a χ² of 24 degrees of freedom, as many
as a smooth disturbance at a port has, at any of seven ports. In the cases that `unknown_share` counts it has 50 % power
or more at half the size, and 95 % power for what the nearest other cause, or the nearest two together, leave: that is
6.5 standard deviations or more. `unknown_share_any` also counts those with a nearer stand-in, a name that no test
without the cause can refute. The gains of actuator, control and record are each exactly equivalent to the other two
together.

A verdict is true if one of its members is present; `none` is true if nothing is wrong, and `unknown` if the cause is
not in the catalogue.

## Other engines

Three others answer on the same evidence: one at random; one that names the cause that lowers χ² most, with BIC; and a
lasso over the directions of all causes, with its penalty chosen by BIC. Their thresholds are set so that they give as
many false alarms as the engine.

## Blocks

A proof is registered before its first case is drawn (`make blind REGISTER=1`), with the commit and the hashes of engine
and judge, the seeds, and a size. So many cases are needed for each limit to hold with a chance of 90 % if the true
rates are as assumed (`benchmarks/blind/blocks.py`):

| limit | cases |
|---|---|
{needed}

A smaller block, run when time is short, cannot hold all of them; the best that it could reach is given beside its
scores. A block may take several runs (`MINUTES=…`): judgements are kept, and the next run continues where the last one
ended. Blocks before seed {first_free} were frozen by hand or not at all, and were held to point values.

{blocks}
"""
_PART = """## Scores in {title}

| score | engine | target | holds | at best | at random |
|---|---|---|---|---|---|
{rows}

Limits are one-sided 95 % ones: of Clopper and Pearson for shares, over {nulls} cases without a hidden cause, {at_2x} at
twice the size, {removed_at_2x} that the catalogue lacks, {covered_of} intervals, {located_of} places; of resampled
cases for the others. *At best* is what an engine without fault would reach on as many cases: each of its answers is
right, its intervals hold the truth in 95 % of cases, and its verdicts are true as often as their probabilities say.

| engine | false alarms | power ratio | right at twice the size |
|---|---|---|---|
{beside}

![Detection efficiency](discovery/{world}-efficiency.png)

![Calibration](discovery/{world}-calibration.png)

![Confusion](discovery/{world}-confusion.png)

### By cause, in {title}

Single causes at twice the size, or without an ideal test where they show.

| cause | cases | right |
|---|---|---|
{causes}

### Confusion, in {title}

{confusion}
"""


def write_part(
    folder: Path,
    pictures: Path,
    world: str,
    reached: dict[str, float],
    guessed: dict[str, float],
    table: pd.DataFrame,
    beside: dict[str, dict[str, float]],
) -> None:
    """Write a world's part of the page and its pictures into a folder.

    Parameters
    ----------
    folder, pictures : where to write, and where the pictures are
    reached, guessed : scores of the engine and of one that answers at random
    table : judgements of the engine
    beside : scores of the other engines at the engine's rate of false alarms
    """
    causes, best = right_by_cause(table), at_best(table)
    parts = folder / "discovery"
    parts.mkdir(parents=True, exist_ok=True)
    for name in _PICTURES:
        shutil.copyfile(pictures / f"{name}.png", parts / f"{world}-{name}.png")
    text = _PART.format(
        **{name: int(reached[name]) for name in _COUNTS},
        title=_TITLES[world],
        world=world,
        rows="\n".join(_row(name, reached[name], guessed[name], best.get(name, np.nan)) for name in reached),
        beside="\n".join(_of_engine(name, values) for name, values in beside.items()),
        causes="\n".join(f"| {name} | {row.cases:.0f} | {row.share:.2f} |" for name, row in causes.iterrows()),
        confusion=_markdown(confusion(table)),
    )
    (parts / f"{world}.txt").write_text(text)


def write_page(folder: Path) -> None:
    """Write discovery.md from its text, the list of blocks and the parts of the worlds that have one."""
    from benchmarks.blind.draw import STRATIFIED

    parts = [folder / "discovery" / f"{world}.txt" for world in _TITLES]
    page = _TEXT.format(
        stratified=STRATIFIED,
        large=blocks.LEAST_PER_CAUSE,
        off=OFF_DOCUMENTS,
        first_free=blocks.FIRST_FREE,
        needed=_needed(),
        blocks=blocks.markdown(),
    )
    (folder / "discovery.md").write_text("\n".join([page, *(part.read_text() for part in parts if part.is_file())]))


def _needed() -> str:
    """Rows of the cases that the limits need, the fewest first."""
    _, needed = blocks.size()
    counts = sorted(needed.items(), key=lambda item: item[1])
    return "\n".join(f"| {name} | {count} |" for name, count in counts)


def _of_engine(name: str, values: dict[str, float]) -> str:
    return f"| {name} | {values['false_alarm']:.3g} | {values['power_ratio']:.3g} | {values['right_at_2x']:.3g} |"


def _row(name: str, value: float, guess: float, best: float) -> str:
    relation, target = TARGETS.get(name, ("", ""))
    verdict = {None: "", True: "yes", False: "no"}[holds(name, value)]
    wanted = f"{relation} {target}".replace("<=", "≤").replace(">=", "≥").strip()
    bound = f"{best:.4g}" if np.isfinite(best) else ""
    return f"| {name} | {value:.4g} | {wanted} | {verdict} | {bound} | {guess:.4g} |"


def _markdown(table: pd.DataFrame) -> str:
    """Rows as lists, as a matrix of all names is too wide to read."""
    lines = ["| hidden | named (cases) |", "|---|---|"]
    for name, row in table.iterrows():
        named = ", ".join(f"{other} {count}" for other, count in row[row > 0].sort_values(ascending=False).items())
        lines.append(f"| {name} | {named} |")
    return "\n".join(lines)
