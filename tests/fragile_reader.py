"""A reader of logs that does what damaged bytes may have a C library do: the log's text says which."""

import ctypes
import errno
import os
import signal
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from drillid.formats import Dialect, Header
from drillid.formats.description import Unusable

SUFFIXES = (".fragile",)
FRAGILE = True


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """One column, or the end of the process."""
    match path.read_text():
        case "segfault":
            ctypes.string_at(0)
        case "abort":
            os.abort()
        case "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        case "loop":
            while True:
                pass
        case "sleep":
            time.sleep(600)
        case "memory":
            np.ones((10_000, 1_000_000))
        case "unusable":
            raise Unusable("is a picture", "Export the log")
        case "share":
            raise OSError(errno.ESTALE, os.strerror(errno.ESTALE), str(path))
        case "bug":
            raise RuntimeError("a fault of the reader")
    return [Header(("a",))]


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The number of the process."""
    return pa.table({"a": [os.getpid()]})
