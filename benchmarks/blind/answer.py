"""An engine's answer to a case, in the vocabulary of the proof."""

from dataclasses import dataclass

from benchmarks.blind.vocabulary import CAUSES, NONE, UNKNOWN, members


@dataclass(frozen=True)
class Claim:
    """One verdict of an answer."""

    verdict: str
    """none, a cause, a class as its members joined by |, or unknown."""
    probability: float
    """That it is right."""
    cause: str = ""
    """The likeliest member."""
    size: float = float("nan")
    size_low: float = float("nan")
    """95 % interval."""
    size_high: float = float("nan")
    location_m: float = float("nan")
    predictive_gain_low: float = float("nan")

    @property
    def members(self) -> tuple[str, ...]:
        """Causes that it names."""
        return members(self.verdict)

    @property
    def family(self) -> str:
        """Family of the likeliest member; empty where no cause is named."""
        named = self.members
        return CAUSES[self.cause if self.cause in named else named[0]].family if named else ""

    @property
    def kind(self) -> str:
        """none, unknown or named."""
        return self.verdict if self.verdict in (NONE, UNKNOWN) else "named"


@dataclass(frozen=True)
class Answer:
    """Verdicts about a case."""

    verdicts: tuple[Claim, ...]
    second_pass: float = float("nan")
    """p-value of the extended model's misfit; NaN where the model was not extended."""
    failure: str = ""
    """Why the engine gave no verdict; empty where it did."""
    seconds: float = float("nan")
    """Processor time of the examination."""
    score: float = float("nan")
    """Evidence that something is wrong, of engines that leave its threshold to the proof."""
