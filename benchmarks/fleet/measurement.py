"""Where every part of `make bench-fleet` writes its results."""

from pathlib import Path

FILE = Path("results/bench-fleet.json")
FOLDER = Path("results/bench-fleet")
"""Where parts keep what they simulate and run."""
