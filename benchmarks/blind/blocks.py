"""All blocks of seeds that the proof was ever run on, and the registration of a block before it is run."""

import datetime
import json
import subprocess
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.blind.draw import planned_cases
from benchmarks.blind.limits import cases_needed
from benchmarks.blind.scores import TARGETS, holds
from benchmarks.blind.world import WORLDS
from drillid.errors import SettingsError
from drillid.fleet.provenance import digest, source_hash

PATH = Path(__file__).with_name("blocks.json")
FIRST_FREE = 200_000
"""Smallest seed of a block that may still be registered; smaller ones served development, calibration and proofs."""
ASSUMED = {
    "false_alarm": (0.04, 0.06, 0.5),
    "accuracy_at_2x": (0.975, 0.95, 0.17),
    "unknown_share": (0.92, 0.80, 0.04),
    "wrong_family_confident": (0.002, 0.02, 0.06),
    "location_within_5pct": (0.99, 0.90, 0.02),
    "zones_placed": (0.95, 0.85, 0.025),
}
"""Rates assumed of an engine that is to pass, the limits that it is to hold, and the shares of cases that count."""
LEAST_PER_CAUSE = 10
"""Cases that are drawn large of each cause."""


@dataclass(frozen=True)
class Block:
    """A run of the proof over successive seeds."""

    world: str
    first: int
    cases: int
    date: str
    """Of the registration, or of the page of a block that was not registered."""
    commit: str
    """Of engine and judge."""
    engine: str
    """Hash of the engine's code; empty for blocks before registration was introduced."""
    judge: str
    """Hash of generators and judge."""
    registered: bool
    """Whether this entry was written before the first case was drawn."""
    failed: dict[str, float | None] | None = None
    """Targets that it missed and what it reached, None where no case applied; None where it has not been run."""
    note: str = ""

    @property
    def seeds(self) -> range:
        """Its seeds."""
        return range(self.first, self.first + self.cases)


def engine_hash() -> str:
    """Hash of the code of the engine and of what gathers its evidence."""
    return digest([source_hash("drillid.discrepancy.verdicts.engine", "drillid.discrepancy.gather")])[:16]


def judge_hash() -> str:
    """Hash of the code of generators, simulators, ideal tests, judge and baselines."""
    parts = ("drillid.simulation.simulate", "drillid.simulation.recorder", "drillid.physics.responses")
    return digest([source_hash("benchmarks.blind.run"), source_hash(*parts)])[:16]


def blocks() -> list[Block]:
    """All blocks, the oldest first."""
    return [Block(**entry) for entry in json.loads(PATH.read_text())]


def size() -> tuple[int, dict[str, int]]:
    """Number of cases for which all limits hold at the assumed rates, and what each of them needs."""
    needed = {name: int(np.ceil(cases_needed(rate, limit) / share)) for name, (rate, limit, share) in ASSUMED.items()}
    needed["cases_of_a_cause"] = max(planned_cases(LEAST_PER_CAUSE, world) for world in WORLDS.values())
    return max(needed.values()), needed


def register(world: str, first: int, cases: int) -> Block:
    """Write down a block before it is run.

    Raises
    ------
    SettingsError
        If its seeds are used, or the checkout has changes that no commit names.
    """
    block = Block(
        world, first, cases, f"{datetime.date.today()}", _git("rev-parse", "HEAD"), engine_hash(), judge_hash(), True
    )
    used = [other for other in blocks() if other.world == world and set(other.seeds) & set(block.seeds)]
    if first < FIRST_FREE or used:
        raise SettingsError("registration", f"seeds from {first} are used", f"Begin at {_next_free(world)} or later")
    if _git("status", "--porcelain", "--untracked-files=no"):
        raise SettingsError(
            "registration", "the checkout has uncommitted changes", "Commit them: a proof names its commit"
        )
    _write([*blocks(), block])
    return block


def registered(world: str, first: int, cases: int) -> Block | None:
    """The registration of a block under the present code; None without one."""
    code = (engine_hash(), judge_hash())
    own = [block for block in blocks() if (block.world, block.first, block.cases) == (world, first, cases)]
    return next((block for block in own if block.registered and (block.engine, block.judge) == code), None)


def judged(block: Block, reached: dict[str, float], cases: int) -> None:
    """Write down what a block, or so many of its cases, failed."""
    missed = [name for name in TARGETS if not holds(name, reached[name])]
    failed = {name: None if np.isnan(reached[name]) else reached[name] for name in missed}
    note = "" if cases == block.cases else f"the first {cases} of {block.cases} registered"
    _write([replace(each, failed=failed, note=note) if each == block else each for each in blocks()])


def markdown() -> str:
    """Table of all blocks."""
    lines = ["| world | seeds | date | commit | registered before | failed |", "|---|---|---|---|---|---|"]
    for block in blocks():
        failed = "not run" if block.failed is None else _failures(block.failed)
        note = f"; {block.note}" if block.note else ""
        seeds = f"{block.first}–{block.first + block.cases - 1}"
        before = f"engine {block.engine}, judge {block.judge}" if block.registered else "no"
        lines.append(f"| {block.world} | {seeds} | {block.date} | {block.commit[:7]} | {before} | {failed}{note} |")
    return "\n".join(lines)


def _failures(failed: dict[str, float | None]) -> str:
    return ", ".join(name if value is None else f"{name} {value:.3g}" for name, value in failed.items()) or "nothing"


def _next_free(world: str) -> int:
    last = max((block.seeds.stop for block in blocks() if block.world == world), default=0)
    return max(FIRST_FREE, 10_000 * -(-last // 10_000))


def _write(entries: list[Block]) -> None:
    PATH.write_text(json.dumps([asdict(entry) for entry in entries], indent=1, ensure_ascii=False) + "\n")


def _git(*words: str) -> str:
    return subprocess.run(["git", *words], check=True, capture_output=True, text=True).stdout.strip()
