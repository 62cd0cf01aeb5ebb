"""How a result came to be: the stages behind a file, each with its code, settings, inputs and versions."""

from __future__ import annotations

import contextlib
import hashlib
import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import drillid
from drillid.datasets.store import WellFolders
from drillid.errors import SettingsError
from drillid.fleet.manifest import stored, write_whole
from drillid.fleet.provenance import digest, numerical_versions, source_hash
from drillid.fleet.stages import ALL_STAGES, STAGES
from drillid.formats.description import Unusable
from drillid.formats.remote import local_file, url_of
from drillid.formats.remote import states as remote_states

_INPUTS = ".inputs.json"
"""Not a result: it may differ between runs that give the same results."""
_FIRST = next(name for name, stage in STAGES.items() if not stage.reads)
"""The stage that reads the logs of wells."""
_SETTLED_S = 2.0
"""Age beyond which any later change of a file shows in its modification time."""


def known_inputs(folder: Path) -> dict[str, list[str]]:
    """State and SHA-256 of the inputs that a folder's stage read, by path or URL."""
    try:
        content = json.loads((folder / _INPUTS).read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def inputs_of(paths: Sequence[Path], known: Mapping[str, list[str]] | None = None) -> dict[str, list[str]]:
    """State and SHA-256 of every file that exists, by path or URL.

    As in git's index, a file whose size, time and place on the disk are unchanged is not read again.

    Parameters
    ----------
    known : those of an earlier run, from `known_inputs`
    """
    found, elsewhere, known = dict[str, list[str]](), remote_states(paths), known or {}
    for path in paths:
        name, state = url_of(path) or str(path), elsewhere[path] if path in elsewhere else _local_state(path)
        if state and name in known and known[name][0] == state:
            found[name] = known[name]
            continue
        with contextlib.suppress(OSError, Unusable), local_file(path) as local, local.open("rb") as file:
            found[name] = [state, hashlib.file_digest(file, "sha256").hexdigest()]
    return found


def remember_inputs(folder: Path, found: Mapping[str, list[str]]) -> None:
    """Store the result of `inputs_of` in a stage's folder."""
    write_whole(folder / _INPUTS, json.dumps(found))


def _local_state(path: Path) -> str:
    """Size, time and inode; empty if the file is missing or so new that it may change within a tick of the clock."""
    try:
        status = path.stat()
    except OSError:
        return ""
    settled = time.time() - status.st_mtime > _SETTLED_S
    return f"{status.st_size} {status.st_mtime_ns} {status.st_ino}" if settled else ""


def inputs_behind(folders: WellFolders, first: str = _FIRST) -> dict[str, str]:
    """SHA-256 of the rig description and the logs behind a well's results, by path; empty before any stage has run.

    Parameters
    ----------
    first : the stage that reads them
    """
    found = stored(folders.stage(first)).get("inputs", {})
    return found if isinstance(found, dict) else {}


def attributes_of(key: Mapping[str, Any], inputs: Mapping[str, str]) -> dict[str, str]:
    """Attributes that tell what a dataset was made from; the same inputs give the same attributes wherever they lie.

    Parameters
    ----------
    key : content of the stage's key
    inputs : SHA-256 by path
    """
    versions = {"drillid": drillid.__version__, **numerical_versions()}
    return {
        "versions": ", ".join(f"{name} {version}" for name, version in versions.items()),
        "code_hash": key["source"],
        "configuration_hash": digest([key["settings"], key["rig"]]),
        "input_sha256": "\n".join(sorted(f"{found}  {Path(path).name}" for path, found in inputs.items())),
    }


def explain(path: Path) -> str:
    """How a file came to be, in words, from its own stage back to the logs.

    Parameters
    ----------
    path : a file or folder below `<results>/<stage>/<well>`

    Raises
    ------
    SettingsError
        If it lies in no such folder, or the stage never finished there.
    """
    _, stage, well = _place(path.absolute())
    lines = [f"{path} belongs to the stage {stage} of the well {well}."]
    for name, content in stages_behind(path).items():
        lines += _of_stage(name, content)
    return "\n".join(lines)


def stages_behind(path: Path) -> dict[str, dict[str, Any]]:
    """What each stage recorded about itself in its key.json, from the file's own stage back to the records.

    Parameters, errors : as for `explain`
    """
    results, stage, well = _place(path.absolute())
    waiting, found = [stage], dict[str, dict[str, Any]]()
    while waiting:
        name = waiting.pop(0)
        if name in found:
            continue
        content = stored(results / name / well)
        if not content:
            raise SettingsError(str(results / name / well), "was never finished", "Run the workflow again")
        found[name] = content
        waiting += sorted(content.get("upstream", {}), key=list(STAGES).index, reverse=True)
    return found


def _place(path: Path) -> tuple[Path, str, str]:
    if not path.exists():
        raise SettingsError(str(path), "does not exist", "Correct its path")
    for folder in (path, *path.parents):
        if folder.parent.name in ALL_STAGES and (folder / "problems.csv").exists():
            return folder.parent.parent, folder.parent.name, folder.name
    remedy = "Name a dataset, table or figure below <results>/<stage>/<well>"
    raise SettingsError(str(path), "is not a result of a stage of a well", remedy)


def _of_stage(name: str, content: dict[str, Any]) -> list[str]:
    stage = ALL_STAGES[name]
    now = source_hash(stage.module, *(["drillid.config.rig"] if stage.rig else []))
    same = "the code as it is now" if content["source"] == now else "the code has changed since"
    lines = [
        "",
        f"{name}: {content.get('status', 'done')}, key {content['key']}",
        f"  code      {content['source']}, {same}",
    ]
    for section, values in content["settings"].items():
        lines.append(f"  settings  {section}: {json.dumps(values)}")
    lines += [f"  sheet     {name}: {json.dumps(value)}" for name, value in content.get("stated", {}).items()]
    if content["rig"]:
        lines.append(f"  rig       {', '.join(stage.rig)}: {content['rig']}")
    for path, checksum in content.get("inputs", {}).items():
        kind = "described" if Path(path).suffix == ".yaml" else "log      "
        lines.append(f"  {kind} {path}: sha256 {checksum}")
    lines += [f"  from      {upstream}: key {key}" for upstream, key in content.get("upstream", {}).items()]
    if content.get("versions"):
        lines.append("  versions  " + ", ".join(f"{name} {version}" for name, version in content["versions"].items()))
    return lines
