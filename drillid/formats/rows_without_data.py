"""Rows without data among those of a table: repeated headers, remarks, totals and a cut line at its end."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from drillid.formats.description import Note
from drillid.formats.header_rows import Cells, is_datum
from drillid.formats.places import shortened

_LONGEST_FOOTER = 100
"""Rows with numbers but without a time that the end of a table may have; more are a column of times that is none."""
_MOST_APART = 20
"""Largest number of rows that are each told; of more, the first ones and their number are."""
_REMEDY = "None needed if it is a header, a remark or a total; otherwise correct it"


@dataclass(frozen=True)
class WithoutData:
    """Rows that are left out.

    rows : their places, in order
    texts : the first ones as they are
    others : number of rows of data
    """

    rows: tuple[int, ...]
    texts: tuple[str, ...]
    others: int

    @property
    def credible(self) -> bool:
        """Whether there are any, and fewer than rows of data: else the table is another than it seems."""
        return 0 < len(self.rows) < self.others

    def notes(self, place: Callable[[int], str]) -> list[Note]:
        """A note for each; of very many, one for the rest."""
        told = zip(self.rows, self.texts, strict=False)
        what = "is not a row of data and is left out"
        notes = [(f"{place(row)} {what}: '{shortened(text)}'", _REMEDY) for row, text in told]
        more = len(self.rows) - len(self.texts)
        return [*notes, (f"{more} more rows are not rows of data and are left out", _REMEDY)] if more else notes


def rows_without_data(
    rows: Iterable[tuple[int, Cells, bool]], above: Collection[Cells], times: Sequence[int]
) -> WithoutData:
    """The rows of a table that hold neither a number nor a time, repeat its header, or end it without a time.

    Parameters
    ----------
    rows : place and cells of each row behind the header, and whether it is whole; the end of a table may not be
    above : rows of the header and what stands above it
    times : columns of the times; without them, the end of the table is as the rest
    """
    found, behind, others = list[tuple[int, str]](), list[tuple[int, str]](), 0
    for at, cells, whole in rows:
        bare = tuple(cell.strip() for cell in cells)
        row = (at, ", ".join(filter(None, bare)))
        if bare in above or not any(map(is_datum, bare)):
            found.append(row)
        elif not whole or (times and not any(_has_digit(bare, column) for column in times)):
            behind.append(row)
        else:
            others += len(behind) + 1
            behind.clear()
    if len(behind) > _LONGEST_FOOTER:
        others += len(behind)
        behind.clear()
    ended = sorted({*found, *behind})
    return WithoutData(tuple(at for at, _ in ended), tuple(text for _, text in ended[:_MOST_APART]), others)


def may_be_times(column: Any) -> bool:
    """Whether each cell of an Arrow column of text has a digit."""
    import pyarrow.compute as pc

    return not column.null_count and pc.all(pc.match_substring_regex(column, "[0-9]"), min_count=0).as_py()


def _has_digit(cells: Cells, column: int) -> bool:
    return column < len(cells) and any(character.isdigit() for character in cells[column])
