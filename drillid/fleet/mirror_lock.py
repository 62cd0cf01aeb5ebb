"""One machine at a time on a copy of the results: an object beside the copy names the machine working on it.

The object is renewed while the run lasts, as a store does not remove it by itself when a machine is gone.
"""

from __future__ import annotations

import contextlib
import json
import socket
import threading
import time
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any

from drillid.errors import SettingsError

LOCK = ".lock"
"""Name of the object: JSON with the `holder`, a `token` of its run and when it was last `renewed`, s since 1970."""
_RENEW_EVERY_S = 60.0
_SETTLE_S = 1.0
"""How long two machines that begin at once may take to write, each having found no lock."""
_GONE_AFTER_S = 900.0
"""A machine that has not renewed its lock for this long counts as gone."""


def hold(system: Any, root: str, results: Path) -> Callable[[], None]:
    """Keep other machines away from a copy until the returned function is called.

    Parameters
    ----------
    system : file system of the copy
    root : its folder there
    results : the folder that is copied; a lock left by an earlier run on it is taken over

    Raises
    ------
    SettingsError
        If another machine works on the copy; the message names it.
    """
    refuse_while_held(system, root, results)
    place, holder, token = f"{root}/{LOCK}", _holder(results), uuid.uuid4().hex
    _write(system, place, holder, token)
    # if two begin at once, the last to write holds the lock
    time.sleep(_SETTLE_S)
    _refuse_another(_read(system, place), lambda lock: lock.get("token") == token)
    done = threading.Event()

    def renew() -> None:
        while not done.wait(_RENEW_EVERY_S):
            # network errors differ from store to store; it tries again in a minute
            with contextlib.suppress(Exception):
                if _read(system, place).get("token", token) != token:
                    # it was taken over, after this machine had not been heard of for long
                    return
                _write(system, place, holder, token)

    def release() -> None:
        done.set()
        # a lock that cannot be removed expires after a while
        with contextlib.suppress(Exception):
            if _read(system, place).get("token") == token:
                system.rm_file(place)

    threading.Thread(target=renew, daemon=True).start()
    return release


def refuse_while_held(system: Any, root: str, results: Path) -> None:
    """Refuse a copy that another machine works on; parameters and errors as of `hold`."""
    _refuse_another(_read(system, f"{root}/{LOCK}"), lambda lock: lock.get("holder") == _holder(results))


def _holder(results: Path) -> str:
    return f"{socket.gethostname()}:{results.absolute()}"


def _refuse_another(lock: dict[str, Any], is_own: Callable[[dict[str, Any]], bool]) -> None:
    renewed = float(lock.get("renewed", 0.0))
    if lock and not is_own(lock) and time.time() - renewed < _GONE_AFTER_S:
        seen = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(renewed))
        raise SettingsError(
            "mirror",
            f"another machine works on the copy ({lock.get('holder')}, last seen {seen})",
            f"Wait until its run ends; one that was killed counts as gone after {_GONE_AFTER_S / 60:.0f} minutes",
        )


def _write(system: Any, place: str, holder: str, token: str) -> None:
    system.pipe_file(place, json.dumps({"holder": holder, "token": token, "renewed": time.time()}).encode())


def _read(system: Any, place: str) -> dict[str, Any]:
    system.invalidate_cache()
    try:
        content = json.loads(system.cat_file(place))
    except (FileNotFoundError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}
