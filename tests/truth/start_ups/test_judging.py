"""The judgement of models of a start of rotation at its stated error rate, and what it says is saved."""

import numpy as np
import pytest

from drillid.start_ups.judging import gain

CASES = 4000


@pytest.mark.parametrize("blocks", [3, 5, 12])
def test_a_model_that_is_no_better_is_kept_in_one_log_of_twenty(blocks: int) -> None:
    before, after = np.random.default_rng(blocks).chisquare(4, size=(2, CASES, blocks))
    kept = np.mean([gain(*errors).low > 0 for errors in zip(before, after, strict=True)])
    assert 0.03 < kept < 0.065


def test_the_gain_is_the_share_of_the_error_that_is_saved() -> None:
    before = np.array([300.0, 500.0, 400.0, 800.0])
    found = gain(before, before / 4)
    assert found.value == pytest.approx(0.75)
    assert 0 < found.low < 0.75 < found.high <= 1
