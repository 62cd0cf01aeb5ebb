"""What a well's results were made from, by the keys of its stages, and how that differs from before."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from drillid.datasets.store import WellFolders
from drillid.fleet.explain import inputs_behind
from drillid.fleet.manifest import stored
from drillid.fleet.stages import STAGES

_RIG_FILE = ".yaml"
_NAMED = 3
"""Number of settings, or of logs of one kind, that a reason names."""

Origin = Mapping[str, Any]
"""Code, settings, rig description and versions by `stages`, and checksums of the `logs` by their paths."""


def origin(folders: WellFolders) -> dict[str, Any]:
    """Origin of the results of the stages that have finished."""
    keys = {stage: stored(folders.stage(stage)) for stage in STAGES}
    parts = ("source", "settings", "rig", "versions")
    return {
        "stages": {stage: {part: key.get(part) for part in parts} for stage, key in keys.items() if key},
        "logs": {path: sha for path, sha in inputs_behind(folders).items() if Path(path).suffix != _RIG_FILE},
    }


def reason(before: Origin, now: Origin, stage: str) -> str:
    """What has changed in the inputs of a stage and of those before it; empty where none of the inputs is known.

    Parameters
    ----------
    before, now : as returned by `origin`, or empty
    """
    old, new = before.get("stages", {}), now.get("stages", {})
    known = [name for name in list(STAGES)[: list(STAGES).index(stage) + 1] if name in old and name in new]
    if not known:
        return ""

    def changed(part: str) -> list[str]:
        return [name for name in known if old[name][part] != new[name][part]]

    settings = dict(each for name in known for each in _differing(old[name]["settings"], new[name]["settings"]))
    versions = dict(each for name in known for each in _differing(old[name]["versions"], new[name]["versions"]))
    rig, code = ", ".join(changed("rig")), ", ".join(changed("source"))
    return "; ".join(
        [
            *_other_logs(before["logs"], now["logs"]),
            *_listed([f"setting {name} {words}" for name, words in settings.items()]),
            *([f"rig description changed (parts read by {rig})"] if rig else []),
            *([f"code of {code} changed"] if code else []),
            *_listed([f"{name} {words}" for name, words in versions.items()]),
        ]
    )


def _differing(old: Any, new: Any, name: str = "") -> Iterator[tuple[str, str]]:
    """Names of the values that differ, each with a phrase on how."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            yield from _differing(old.get(key), new.get(key), f"{name}.{key}".lstrip("."))
    elif old != new:
        yield name, f"changed from {json.dumps(old)} to {json.dumps(new)}"


def _other_logs(old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[str]:
    """Logs whose content has changed; one that has only moved counts as unchanged."""
    same = set(old.values()) & set(new.values())
    before = {path for path, checksum in old.items() if checksum not in same}
    now = {path for path, checksum in new.items() if checksum not in same}
    for kind, paths in (("corrected", before & now), ("new", now - before), ("removed", before - now)):
        if paths:
            yield f"{kind} {'log' if len(paths) == 1 else 'logs'} {_shortened(paths)}"


def _shortened(paths: Collection[str]) -> str:
    names = sorted(Path(path).name for path in paths)
    return ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")


def _listed(changes: list[str]) -> list[str]:
    more = [f"{len(changes) - _NAMED} more of these"] if len(changes) > _NAMED else []
    return changes[:_NAMED] + more
