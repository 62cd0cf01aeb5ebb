"""Child processes that end when their parent does, at once and however it ends."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

_LOOK_EVERY_S = 1.0
_PR_SET_PDEATHSIG = 1


def mapped_apart(function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[tuple[Item, Future[Result]]]:
    """Apply a function to one item after the other in a child process, replaced by a new one if it is killed.

    The child is forked, so it has all that this process has imported, and keeps its own imports
    for the items that follow. No threads may run here, as a fork does not copy them.

    Yields
    ------
    Each item with its finished future, whose exception is `BrokenProcessPool` if the child died on this item.
    """
    waiting = list(items)
    while waiting:
        with _child() as child:
            while waiting:
                item = waiting[0]
                try:
                    future = child.submit(function, item)
                except BrokenProcessPool:
                    # it died between two items
                    break
                del waiting[0]
                died = isinstance(future.exception(), BrokenProcessPool)
                yield item, future
                if died:
                    break


def _child() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(1, multiprocessing.get_context("fork"), initializer=end_with, initargs=(os.getpid(),))


def end_with(parent: int) -> None:
    """End this process when its parent is gone; otherwise a killed job would leave it waiting for ever."""
    if sys.platform == "linux":
        # the kernel ends this process at once, whatever it is busy with
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(_LOOK_EVERY_S)
        os._exit(1)

    # on other systems, and if the parent was gone before that call
    threading.Thread(target=watch, daemon=True).start()
