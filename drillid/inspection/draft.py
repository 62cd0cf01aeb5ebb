"""A draft of the rig description that reads some log files, as YAML with a comment on whatever must be checked."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import yaml

from drillid.config.rig import CHANNEL_UNITS, CHANNELS, REQUIRED_CHANNELS, Channel, Clock, LogFile
from drillid.inspection.contents import ChannelGuess, Contents

UNKNOWN = "?"
"""Stands for a column that is not known yet."""
_TAKEN = {"column": r"times are taken from column '(.*)'", "date": r"dates are taken from column '(.*)'"}
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
        lines += _other_logs(alike, clock, file)
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


def _other_logs(alike: Sequence[Contents], clock: Clock, file: LogFile) -> Iterator[str]:
    yield f"  - files: {_inline(_pattern([contents.path.name for contents in alike]))}"
    yield f"    time: {_inline(_time(alike[0], clock))}"
    yield "    channels:"
    yield from _channel_lines(alike[0].channels, alike[0], (), "      ")
    layout = _layout(alike[0], file)
    if layout:
        yield f"    file: {_inline(layout)}"


def _pattern(names: Sequence[str]) -> str:
    """A pattern for the names: the one name, or the common end of several."""
    if len(names) == 1:
        return re.sub(r"([*?\[])", r"[\1]", names[0])
    ending = itertools.takewhile(
        lambda letters: len(set(letters)) == 1, zip(*(name[::-1] for name in names), strict=False)
    )
    return "*" + "".join(letters[0] for letters in ending)[::-1]


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
