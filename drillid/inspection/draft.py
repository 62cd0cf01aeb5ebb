"""A draft of the rig description that reads some log files, as YAML with a comment on whatever must be checked."""

from __future__ import annotations

import glob
import itertools
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from drillid.config.rig import CHANNEL_UNITS, CHANNELS, REQUIRED_CHANNELS, Channel, Clock, LogFile, OtherLogs
from drillid.inspection.contents import ChannelGuess, Contents

UNKNOWN = "?"
"""Stands for a column that is not known yet."""
_TAKEN = {"column": r"times are taken from column '(.*)'", "date": r"dates are taken from column '(.*)'"}
_DIGITS_AT_END = re.compile(r"\d[\d_T:. -]*$")
_DIGITS_AT_START = re.compile(r"^[\d_T: -]*\dZ?")
"""Numbers, dates and times in the names of files, which differ from log to log."""
_ORDER = re.compile(r"read as (day first|month first)")


def draft(name: str, found: Sequence[Contents], clock: Clock, file: LogFile) -> str:
    """The rig description for the files; those without sweep are described in its `other_logs`.

    Parameters
    ----------
    name : of the rig
    found : what the files hold
    clock, file : what the user has stated about them
    """
    fast = [contents for contents in found if contents.sweep is not None] or list(found)
    slow = [contents for contents in found if contents not in fast]
    files = {contents.path for contents in fast}
    apart = [contents for contents in slow if contents.path not in files]
    channels = dict(fast[0].channels)
    for contents in slow:
        # other tables of the same file are described together with it
        channels |= {
            channel: guess
            for channel, guess in contents.channels.items()
            if contents.path in files and channel not in channels
        }
    lines = [f"name: {_inline(name)}", f"time: {_inline(_time(fast[0], clock))}", "channels:"]
    lines += _channel_lines(channels, fast[0], REQUIRED_CHANNELS if not apart else ("torque_sweep", "speed"))
    layout = _layout(fast[0], file)
    lines += [f"file: {_inline(layout)}"] if layout else []
    if apart:
        lines.append("other_logs:")
    shapes: dict[tuple[str, ...], list[Contents]] = {}
    for contents in apart:
        shapes.setdefault(tuple(column.name for column in contents.columns), []).append(contents)
    for alike in shapes.values():
        own = [contents.path for contents in alike]
        for pattern, path in file_patterns(own, {contents.path for contents in found}.difference(own)):
            lines += _other_logs(pattern, path, alike, clock, file)
    if "torque_command" not in channels:
        lines.append("# no torque command was found: state the controller's gains, such as")
        lines.append("# controller: {proportional: 1500 N m s/rad, integral: 800 N m/rad}")
    return "\n".join(lines) + "\n"


def _channel_lines(
    channels: Mapping[Channel, ChannelGuess], contents: Contents, needed: Sequence[Channel], indent: str = "  "
) -> Iterator[str]:
    for name in CHANNELS:
        guess = channels.get(name)
        if guess is None and name in needed:
            unit = CHANNEL_UNITS[name]
            why = "no sweep was found" if name == "torque_sweep" else "none is named like it"
            yield f"{indent}{name}: {{column: '{UNKNOWN}', unit: {unit}}}  # {why}: write its column and unit"
        elif guess is not None:
            notes = [str(contents.sweep)] if name == "torque_sweep" and contents.sweep is not None else []
            notes += [_doubt(guess)] if guess.guessed else []
            comment = f"  # {'; '.join(notes)}" if notes else ""
            yield f"{indent}{name}: {_inline({'column': guess.column, 'unit': guess.unit})}{comment}"


def _doubt(guess: ChannelGuess) -> str:
    others = f", and so would {' or '.join(guess.others)}" if guess.others else ""
    return f"check the unit: the file states none, this one fits the size{others}"


def _other_logs(pattern: str, path: Path, alike: Sequence[Contents], clock: Clock, file: LogFile) -> Iterator[str]:
    """Logs of another shape, described by what one of them holds."""
    contents = next(each for each in alike if each.path == path)
    yield f"  - files: {_inline(pattern)}"
    yield f"    time: {_inline(_time(contents, clock))}"
    yield "    channels:"
    yield from _channel_lines(contents.channels, contents, (), "      ")
    layout = _layout(contents, file)
    if layout:
        yield f"    file: {_inline(layout)}"


def file_patterns(alike: Sequence[Path], others: Collection[Path]) -> list[tuple[str, Path]]:
    """Patterns that together match some files and no others, with the first file of each.

    One pattern matches all of them where their names have a part that the others lack; else each file has its own.
    """
    paths = list(dict.fromkeys(alike))
    for pattern in _common_patterns(paths) if len(paths) > 1 else ():
        if all(_matches(pattern, path) for path in paths) and not any(_matches(pattern, path) for path in others):
            return [(pattern, paths[0])]
    return [(_own_pattern(path, {*paths, *others} - {path}), path) for path in paths]


def _common_patterns(paths: Sequence[Path]) -> Iterator[str]:
    """Patterns made of what the files' names have in common, the likelier to match further logs first."""
    names, folders = [path.name for path in paths], {path.parent.name for path in paths}
    beginning = _common_beginning(names)
    ending = _common_beginning([name[len(beginning) :][::-1] for name in names])[::-1]
    word, rest = _DIGITS_AT_END.sub("", beginning), _DIGITS_AT_START.sub("", ending)
    found = [("", rest)] if rest.partition(".")[0] else []
    found += [(word, rest), (beginning, ending)]
    patterns = [f"{glob.escape(begin)}*{glob.escape(end)}" for begin, end in found]
    yield from patterns
    if len(folders) == 1:
        yield from (f"{glob.escape(*folders)}/{pattern}" for pattern in patterns)


def _common_beginning(names: Sequence[str]) -> str:
    alike = itertools.takewhile(lambda letters: len(set(letters)) == 1, zip(*names, strict=False))
    return "".join(letters[0] for letters in alike)


def _own_pattern(path: Path, others: Collection[Path]) -> str:
    """The name of a file, with its folder where another file has that name."""
    name, folder = glob.escape(path.name), glob.escape(path.parent.name)
    return f"{folder}/{name}" if folder and any(_matches(name, other) for other in others) else name


def _matches(pattern: str, path: Path) -> bool:
    return OtherLogs(files=pattern).match(path)


def _time(contents: Contents, clock: Clock) -> dict[str, Any]:
    """The times as stated, with what the reader decided, so that other logs of the rig are read alike."""
    stated = {name: value for name, value in clock.model_dump().items() if value is not None}
    decided = [what for what, _ in contents.notes]
    found = {key: match[1] for key, taken in _TAKEN.items() for what in decided if (match := re.search(taken, what))}
    for what in decided:
        if (match := _ORDER.search(what)) is not None:
            found["format"] = match[1]
    return found | stated


def _layout(contents: Contents, file: LogFile) -> dict[str, Any]:
    stated = {name: value for name, value in file.model_dump().items() if value not in (None, (), False)}
    comma = any("read with a decimal comma" in what for what, _ in contents.notes)
    return ({"decimal": ","} if comma else {}) | stated


def _inline(content: Any) -> str:
    """Content in one line of YAML."""
    text = yaml.safe_dump(content, default_flow_style=True, allow_unicode=True, sort_keys=False, width=10**6)
    return text.removesuffix("\n").removesuffix("\n...")
