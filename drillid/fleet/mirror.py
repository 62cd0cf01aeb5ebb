"""A copy of the results elsewhere: on a store such as S3, or in another folder, brought up to date after each run.

Stages rename whole folders and lock files, which object stores cannot do, so they work in a folder of this machine or
of a mounted share. The copy keeps the same guarantee: a well's folder has no key.json there while it is being brought
up to date, and files that refer to others (manifests, tables and the report) come last. Of the files in its place, only
those that its listing names are ever deleted.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drillid.errors import SettingsError
from drillid.fleet.manifest import KEY, write_whole
from drillid.fleet.mirror_lock import LOCK, hold, refuse_while_held

LISTING = "mirror.json"
"""What the copy holds: its place, its version, and size and time in ns of each file by its path; while it is brought up
to date, only what stays as it is, beside the names of all other files that may be there (`begun`)."""
_VERSION = ".mirror"
"""The versions of the copy that this machine's results continue from: JSON with its place and their names."""
_NOT_COPIED = {"raw", "logs", "benchmarks", LISTING, _VERSION}
"""At the top of the results: inputs, and records of this machine's runs alone. A well's folder may have such a name."""
_ASIDE = ".previous"
"""Folder of what a stage keeps for itself."""
_AT_ONCE = 500
"""Number of files copied in one request."""


@dataclass(frozen=True)
class Changes:
    """Numbers of files written to the copy and deleted from it."""

    written: int
    deleted: int


def update_mirror(results: Path, mirror: str, listing: Path) -> Changes:
    """Bring the copy of the results up to date; unchanged files are left alone.

    Parameters
    ----------
    results : folder of the results
    mirror : folder or URL of the copy, such as s3://bucket/main
    listing : file in which to list what the copy holds

    Raises
    ------
    SettingsError
        If the place does not answer or cannot be written, holds something else, or another machine has brought it up to
        date meanwhile.
    """
    local = _files(results)
    with _answering(mirror):
        system, root = _place(mirror)
        before = _listing_there(system, root)
        _refuse_other(system, root, before, results, mirror)
        _refuse_newer(before, results, mirror)
        known, there = before.get("files", {}), _sizes_there(system, root)
        written = {*known, *before.get("begun", ())}
        changed = {name for name, state in local.items() if known.get(name) != state or there.get(name) != state[0]}
        gone = (written & there.keys()) - local.keys()
        # a well's folder that changes has no key until it is complete
        folders = set(map(_folder, changed | gone))
        keys = {f"{folder}/{KEY}" for folder in folders} & there.keys()
        stay = {name: state for name, state in known.items() if _folder(name) not in folders and _has_key(name, known)}
        begun = {"files": stay, "begun": sorted((written | changed) - stay.keys())}
        version = uuid.uuid4().hex
        # whether the run is killed before or after a listing is written, one of the two versions is right
        _remember(results, mirror, before.get("version"), version)
        if changed or gone:
            _write_listing(system, root, {"mirror": mirror, "version": version, **begun})
        _delete(system, root, keys | gone)
        for names in _in_order(changed | (keys & local.keys())):
            _put(system, results, root, names)
        content = {"mirror": mirror, "version": version, "files": local}
        write_whole(listing, _text(content))
        _write_listing(system, root, content)
        _remember(results, mirror, version)
    return Changes(len(changed), len(gone))


def restore(results: Path, mirror: str) -> bool:
    """Fetch the results from their copy if this machine has none yet; returns whether it did.

    Raises
    ------
    SettingsError
        If the place does not answer, or another machine works on the copy.
    """
    if results.exists():
        return False
    part = results.with_name(f"{results.name}.{os.getpid()}.part")
    with _answering(mirror):
        system, root = _place(mirror)
        if not system.exists(f"{root}/{LISTING}"):
            return False
        refuse_while_held(system, root, results)
        listing = _listing_there(system, root)
        files = listing["files"]
        try:
            for names in _pieces([*files, LISTING]):
                places = [part / name for name in names]
                for place in places:
                    place.parent.mkdir(parents=True, exist_ok=True)
                system.get([f"{root}/{name}" for name in names], [str(place) for place in places])
            for name, (_, time_ns) in files.items():
                os.utime(part / name, ns=(time_ns, time_ns))
            _remember(part, mirror, listing.get("version"))
            part.rename(results)
        finally:
            shutil.rmtree(part, ignore_errors=True)
    return True


def _files(results: Path) -> dict[str, list[int]]:
    """Size and time of each file to be copied, by its path within the results."""
    found = {}
    for folder, folders, names in os.walk(results):
        inside = Path(folder).relative_to(results)
        folders[:] = sorted(name for name in folders if _is_copied(inside / name))
        for name in sorted(names):
            path = inside / name
            if _is_copied(path) and path.suffix not in (".part", ".lock") and name != LOCK:
                state = (results / path).stat()
                found[path.as_posix()] = [state.st_size, state.st_mtime_ns]
    return found


def _is_copied(path: Path) -> bool:
    """Whether a folder or file of the results, by its path within them, belongs into the copy."""
    if len(path.parts) == 1 and path.name in _NOT_COPIED:
        return False
    is_of_well = len(path.parts) == 2
    return path.name != _ASIDE and (is_of_well or path.suffix != ".part")


def _folder(name: str) -> str:
    """The folder of a stage and well that a file is in; of other files, the path or its beginning."""
    return "/".join(Path(name).parts[:2])


def _has_key(name: str, files: Mapping[str, Any]) -> bool:
    """Whether a file is in the folder of a well that a stage has finished."""
    return f"{_folder(name)}/{KEY}" in files


def hold_mirror(results: Path, mirror: str) -> Callable[[], None]:
    """Keep other machines away from the copy until the returned function is called.

    Raises
    ------
    SettingsError
        If another machine works on it, or has brought it up to date since this one did; or the place holds something
        else, or does not answer.
    """
    with _answering(mirror):
        system, root = _place(mirror)
        _refuse_other(system, root, _listing_there(system, root), results, mirror)
        if _is_local(system):
            Path(root).mkdir(parents=True, exist_ok=True)
        release = hold(system, root, results)
        try:
            _refuse_newer(_listing_there(system, root), results, mirror)
        except BaseException:
            release()
            raise
    return release


def _refuse_other(system: Any, root: str, listing: Mapping[str, Any], results: Path, mirror: str) -> None:
    """Refuse a place that is not for a copy alone: around or within the results, or with files of others."""
    if _is_local(system):
        place, own = Path(root).resolve(), results.resolve()
        if place.is_relative_to(own) or own.is_relative_to(place):
            what = f"{mirror} and the results in {results} lie in one another"
            raise SettingsError("mirror", what, "Name a place of its own for the copy")
    if listing or _remembered(results, mirror) or not _is_in_use(system, root):
        return
    remedy = "Name an empty folder, or one that does not exist yet"
    raise SettingsError("mirror", f"{mirror} holds files, but no copy of results", remedy)


def _is_in_use(system: Any, root: str) -> bool:
    """Whether anything lies in a place but the lock of a run."""
    if not system.exists(root):
        return False
    names = [str(name).rstrip("/") for name in system.ls(root, detail=False)]
    return any(name not in (root, f"{root}/{LOCK}") for name in names)


def _refuse_newer(listing: Mapping[str, Any], results: Path, mirror: str) -> None:
    """Refuse a copy that another machine has brought up to date: it would be overwritten by older results."""
    if "version" in listing and listing["version"] not in _remembered(results, mirror):
        raise SettingsError(
            "mirror",
            f"{mirror} was brought up to date from elsewhere, and {results} does not continue from that",
            f"Move {results} away, so that the next run starts from the copy, or name another place",
        )


def _remember(results: Path, mirror: str, *versions: str | None) -> None:
    write_whole(results / _VERSION, json.dumps({"mirror": mirror, "versions": versions}))


def _remembered(results: Path, mirror: str) -> Sequence[str]:
    try:
        content = json.loads((results / _VERSION).read_bytes())
        return list(content["versions"]) if content["mirror"] == mirror else []
    except (OSError, ValueError, LookupError, TypeError):
        return []


def _listing_there(system: Any, root: str) -> dict[str, Any]:
    """What the copy holds according to its own listing, see `LISTING`; empty if there is no readable one."""
    system.invalidate_cache()
    try:
        content = json.loads(system.cat_file(f"{root}/{LISTING}"))
    except (FileNotFoundError, ValueError):
        return {}
    return content if isinstance(content, dict) and isinstance(content.get("files"), dict) else {}


def _write_listing(system: Any, root: str, content: Mapping[str, Any]) -> None:
    """Write the copy's own listing, whole even if the machine dies meanwhile; object stores write whole objects."""
    if _is_local(system):
        Path(root).mkdir(parents=True, exist_ok=True)
        write_whole(Path(root, LISTING), _text(content))
    else:
        system.pipe_file(f"{root}/{LISTING}", _text(content).encode())


def _text(listing: Mapping[str, Any]) -> str:
    return json.dumps(listing, indent=0)


def _sizes_there(system: Any, root: str) -> dict[str, int]:
    system.invalidate_cache()
    files = system.find(root, detail=True) if system.exists(root) else {}
    return {name.removeprefix(root).lstrip("/"): int(file["size"]) for name, file in files.items()}


def _in_order(names: Iterable[str]) -> list[list[str]]:
    """Files in the order in which they are copied: data, then keys, then manifests, tables and report."""
    order: list[list[str]] = [[], [], []]
    for name in sorted(names):
        path = Path(name)
        last = len(path.parts) == 1 or (len(path.parts) == 2 and path.suffix == ".json")
        order[2 if last else int(path.name == KEY)].append(name)
    return order


def _put(system: Any, folder: Path, root: str, names: list[str]) -> None:
    for piece in _pieces(names):
        places = [f"{root}/{name}" for name in piece]
        if _is_local(system):
            for place in places:
                Path(place).parent.mkdir(parents=True, exist_ok=True)
        system.put([str(folder / name) for name in piece], places)


def _delete(system: Any, root: str, names: Iterable[str]) -> None:
    # keys first, so that a half-deleted folder never looks complete
    for piece in _pieces(sorted(names, key=lambda name: Path(name).name != KEY)):
        system.rm([f"{root}/{name}" for name in piece])


def _pieces(names: list[str]) -> Iterator[list[str]]:
    for start in range(0, len(names), _AT_ONCE):
        yield names[start : start + _AT_ONCE]


def _place(mirror: str) -> tuple[Any, str]:
    from fsspec.core import url_to_fs

    system, root = url_to_fs(mirror)
    return system, str(root).rstrip("/")


def _is_local(system: Any) -> bool:
    return "file" in system.protocol


@contextlib.contextmanager
def _answering(mirror: str) -> Iterator[None]:
    try:
        yield
    except SettingsError:
        raise
    except Exception as error:  # each store raises errors of its own
        said = " ".join(f"{type(error).__name__}: {error}".split())
        remedy = "Check the address, the network and the credentials, then run again"
        raise SettingsError("mirror", f"{mirror} cannot be reached or written ({said})", remedy) from error
