"""Runs on measured data and on known truths, each of which prints its table: `python -m benchmarks.<name>`."""
