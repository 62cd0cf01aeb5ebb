"""The ideal test of a case of either world."""

from benchmarks.blind.generator.cases import Case as OwnCase
from benchmarks.blind.ideal.ideal import Ideal
from benchmarks.blind.ideal.other import OtherResponses
from benchmarks.blind.ideal.own import OwnResponses
from benchmarks.blind.other_world.cases import Case as OtherCase


def ideal_of(case: OwnCase | OtherCase) -> Ideal:
    """The ideal test of a case."""
    return Ideal(case, OwnResponses(case) if isinstance(case, OwnCase) else OtherResponses(case))
