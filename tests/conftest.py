"""Two simulated wells that the tests of the stages share, and which tests a process takes together."""

from pathlib import Path

import numpy as np
import pytest
from xdist.remote import Producer
from xdist.scheduler import LoadScopeScheduling

from tests.once import made_once
from tests.simulated import SHALLOW, Processed, drilled, processed

LONG = (
    *("tests/workflow/test_kill.py", "tests/unit/discrepancy"),
    *("tests/workflow/test_targets.py", "tests/truth/discrepancy/test_detectors.py"),
    *("tests/workflow/test_workflow.py", "tests/truth/blind/test_engine.py"),
    *("tests/workflow/test_dask.py", "tests/baselines"),
    *("tests/workflow/test_demo.py", "tests/truth/discrepancy/test_learnt_process.py"),
    *("tests/workflow/test_nightly.py", "tests/truth/common_causes/test_fleets.py"),
    *("tests/workflow/test_resume.py", "tests/truth/discrepancy/test_held_control.py"),
    *("tests/workflow/test_mirror.py", "tests/unit/records"),
    *("tests/workflow/test_s3.py", "tests/unit/figures"),
    *("tests/workflow/test_faults.py", "tests/truth/blind/test_other_cases.py"),
    *("tests/workflow/test_names.py", "tests/truth/discrepancy/test_products.py"),
    *("tests/workflow/test_jobqueue.py", "tests/truth/discrepancy/test_evidence.py"),
    *("tests/workflow/test_kubernetes.py", "tests/truth/blind/test_sizes_of_detections.py"),
    *("tests/workflow/test_progress.py", "tests/unit"),
    *("tests/unit/report", "tests/truth/discrepancy/test_learning_search.py"),
    *("tests/truth/discrepancy/test_learning.py", "tests/truth/discrepancy/test_limits_of_other_drives.py"),
    *("tests/unit/formats", "tests/truth/discrepancy/test_intervals.py"),
    *("tests/truth/demo/test_wash_out.py", "tests/truth/discrepancy/test_law_kinds.py"),
    *("tests/unit/fits", "tests/data_shared/test_w10.py"),
    *("tests/unit/fleet", "tests/truth/simulation/test_linear_effects.py"),
    *("tests/truth/discoveries/test_motor.py", "tests/truth/fits/joint/test_gains.py"),
    *("tests/truth/fits/test_window_fit.py", "tests/truth/mobility/test_gate_and_stacks.py"),
    *("tests/truth/blind/test_ideal.py", "tests/truth/simulation/test_friction.py"),
)
"""Modules and rooms of 15 s and more, which come first so that the processes end together. A workflow waits for what it
starts, so that each has another's work beside it. Of the first three one alone needs compiled functions: what it has
compiled by the time that others come to theirs is not compiled beside it a second time.
"""
ROOMS = ("tests/unit/", "tests/baselines/")
"""Where all modules of a folder share what is made for them."""


def scope_of(nodeid: str) -> str:
    """The module of a test, or its room, which goes to one process as a whole."""
    module = nodeid.partition("::")[0]
    return module.rpartition("/")[0] if module.startswith(ROOMS) else module


class ByRoom(LoadScopeScheduling):
    """Rooms and modules in the order in which they were collected."""

    def _split_scope(self, nodeid: str) -> str:
        return scope_of(nodeid)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> ByRoom:
    """For `-n`, with whatever distribution."""
    return ByRoom(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest first."""
    rank = {scope: place for place, scope in enumerate(LONG)}
    items.sort(key=lambda item: rank.get(scope_of(item.nodeid), len(LONG)))


@pytest.fixture(scope="session")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> Processed:
    """Two stands of two windows each, one assembly run, nothing wrong. Read only."""

    def make(folder: Path) -> Processed:
        return processed(folder, "healthy", [drilled(SHALLOW, 1200.0, seed) for seed in (1, 2)])

    return made_once(tmp_path_factory, "healthy", make)


@pytest.fixture(scope="session")
def troubled(tmp_path_factory: pytest.TempPathFactory) -> Processed:
    """A good window, one whose sweep does not repeat, one whose speed does not follow the sweep. Read only."""

    def make(folder: Path) -> Processed:
        stands = [drilled(SHALLOW, 600.0, 3), drilled(SHALLOW, 600.0, 5, sweep_period=600.0)]
        stands.append(drilled(SHALLOW, 600.0, 4))
        stands[2]["speed"] = 10.5 + 0.1 * np.random.default_rng(0).standard_normal(stands[2]["speed"].size)
        return processed(folder, "troubled", stands)

    return made_once(tmp_path_factory, "troubled", make)
