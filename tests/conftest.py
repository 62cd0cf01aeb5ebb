"""Two simulated wells that the tests of the stages share; each process makes them once, when first asked."""

import numpy as np
import pytest

from tests.simulated import SHALLOW, Processed, drilled, processed


@pytest.fixture(scope="session")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> Processed:
    """Two stands of two windows each, one assembly run, nothing wrong. Read only."""
    stands = [drilled(SHALLOW, 1200.0, seed) for seed in (1, 2)]
    return processed(tmp_path_factory.mktemp("healthy") / "results", "healthy", stands)


@pytest.fixture(scope="session")
def troubled(tmp_path_factory: pytest.TempPathFactory) -> Processed:
    """A good window, one whose sweep does not repeat, one whose speed does not follow the sweep. Read only."""
    stands = [drilled(SHALLOW, 600.0, 3), drilled(SHALLOW, 600.0, 5, sweep_period=600.0), drilled(SHALLOW, 600.0, 4)]
    stands[2]["speed"] = 10.5 + 0.1 * np.random.default_rng(0).standard_normal(stands[2]["speed"].size)
    return processed(tmp_path_factory.mktemp("troubled") / "results", "troubled", stands)
