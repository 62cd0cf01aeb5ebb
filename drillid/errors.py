"""The error classes: every message names the place, the fault and the remedy."""

import contextlib
import errno
import traceback
from collections.abc import Iterator
from pathlib import Path

_LIBRARY = Path(__file__).resolve().parent
_OF_THE_MACHINE = {
    *(errno.EACCES, errno.EPERM, errno.EKEYEXPIRED, errno.EKEYREVOKED, errno.EKEYREJECTED),
    *(errno.EIO, errno.EREMOTEIO, errno.ESTALE, errno.ENODEV, errno.ENXIO, errno.EBUSY),
    *(errno.ETIMEDOUT, errno.ENOTCONN, errno.ENETDOWN, errno.ENETUNREACH, errno.EHOSTDOWN, errno.EHOSTUNREACH),
    *(errno.EMFILE, errno.ENFILE, errno.ENOSPC, errno.EDQUOT, errno.EROFS),
}
"""Numbers of errors of permissions, disks, shares and networks, which say nothing about the content of a file."""


def place_in_library(error: BaseException) -> traceback.FrameSummary:
    """Innermost place in the library that an unforeseen error passed through; where it was raised if there is none."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if Path(frame.filename).is_relative_to(_LIBRARY)]
    return (own or frames)[-1]


def is_of_machine(error: BaseException | None) -> bool:
    """Whether permissions, a disk, a share or a network failed, so that the same file may be read another time.

    An error that was raised from another one, or while that was handled, is what that one is.
    """
    while error is not None:
        if isinstance(error, PermissionError | ConnectionError | TimeoutError):
            return True
        if isinstance(error, OSError) and error.errno in _OF_THE_MACHINE:
            return True
        error = error.__cause__ if error.__suppress_context__ else error.__context__
    return False


class DrillidError(Exception):
    """A fault, its place and its remedy, as one sentence each.

    Parameters
    ----------
    where : file, sheet row, column, well or interval of time of the fault
    what : the fault
    remedy : what the user can do about it
    """

    def __init__(self, where: str, what: str, remedy: str) -> None:
        self.where, self.what, self.remedy = where, what, remedy
        super().__init__(where, what, remedy)

    def __str__(self) -> str:
        return f"{self.where}: {self.what}. {self.remedy}"


class SettingsError(DrillidError):
    """A setting, sheet or rig description that cannot be used."""


class LogError(DrillidError):
    """A raw log that cannot be read or lacks required content."""


class DatasetError(DrillidError):
    """A dataset that does not match its declared schema."""


class DamageError(DatasetError):
    """A stored dataset that is no longer as it was written.

    Parameters
    ----------
    stage : stage that wrote the dataset
    """

    def __init__(self, where: str, what: str, stage: str) -> None:
        self.stage = stage
        super().__init__(where, what, "The next run makes it again")


class EstimationError(DrillidError):
    """Data that are insufficient for the requested estimate."""


class UnstableControlError(EstimationError):
    """A speed control that is unstable by itself, so that no estimate of a limit of its stability exists."""


@contextlib.contextmanager
def writing(path: Path, given: str = "path", fault: type[DrillidError] = SettingsError) -> Iterator[None]:
    """Write a file that a user names, in a folder that need not be there.

    Parameters
    ----------
    given : what the user is to give another one of
    fault : raised if it cannot be written
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        raise fault(str(path), f"it cannot be written: {error}", f"Give another {given}") from error
