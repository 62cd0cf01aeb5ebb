"""Where the tests' files go: tens of thousands of small ones, which some disks take minutes to delete.

Prints what `make test` adds to its environment: a folder in memory, if the machine has one with room for them.
"""

import os
from pathlib import Path

import psutil

MEMORY = Path("/dev/shm")
ROOM = 2e9
"""Bytes, of the folder; the tests need a fifth of it."""
LEFT = 8e9
"""Bytes of memory for the tests themselves and that folder."""


def environment() -> dict[str, str]:
    """Variables for tests in memory; none where their files go to a disk."""
    try:
        folder = os.statvfs(MEMORY)
    except OSError:
        return {}
    is_usable = os.access(MEMORY, os.W_OK) and not folder.f_flag & os.ST_NOEXEC
    if not is_usable or folder.f_bavail * folder.f_frsize < ROOM or psutil.virtual_memory().available < LEFT:
        return {}
    # of tests that pass nothing is kept, which would take up memory until the machine stops
    return {"TMPDIR": str(MEMORY), "PYTEST_ADDOPTS": "--override-ini=tmp_path_retention_policy=failed"}


if __name__ == "__main__":
    print(*(f"{name}={value}" for name, value in environment().items()))
