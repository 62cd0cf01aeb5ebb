"""What the benchmark of nights takes from the logs of jobs, and what it says of a fleet."""

from pathlib import Path

import pytest

from benchmarks.fleet.nightly import Cost, share_of_fleet, worked_seconds


def test_time_is_that_of_the_well_in_the_logs_of_a_stage(tmp_path: Path) -> None:
    lines = [
        "2026-11-25 01:00:00,000 A: done, 0 problem(s), 9.0 s, 8.00 s of one core",
        "2026-11-25 01:00:09,000 B: done, 1 problem(s), 3.0 s, 2.50 s of one core",
    ]
    (tmp_path / "A.log").write_text("\n".join(lines))
    assert worked_seconds(tmp_path, "B: ") == 2.5
    assert worked_seconds(tmp_path, "A: ") == 8.0
    assert worked_seconds(tmp_path, "C: ") == 0.0


def test_what_a_job_takes_counts_once_for_its_wells() -> None:
    full, night = Cost(220.0, {"fits": 200.0}), Cost(24.0, {"fits": 4.0})
    assert (full.rest, night.rest) == (20.0, 20.0)
    assert share_of_fleet(full, night) == pytest.approx((50 * 4 + 2 * 20) / (50 * 200 + 2 * 20))
