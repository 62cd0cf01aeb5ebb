"""Rows without data among those of a table: repeated headers, remarks, totals and a cut line at its end."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from drillid.formats.description import Note
from drillid.formats.header_rows import Cells, is_datum
from drillid.formats.places import shortened

_LONGEST_FOOTER = 100
"""Largest number of rows with numbers but no time at a table's end; with more, the column of times is not one."""
_MOST_APART = 20
"""Largest number of rows that are reported each; of more, the first ones and the number of the rest."""
_REMEDY = "None needed if it is a header, a remark or a total; otherwise correct it"


@dataclass(frozen=True)
class WithoutData:
    """Rows that are left out.

    rows : their places, in order
    texts : the first ones, unchanged
    others : number of rows of data
    """

    rows: tuple[int, ...]
    texts: tuple[str, ...]
    others: int

    @property
    def credible(self) -> bool:
        """Whether there are any, and fewer than rows of data: otherwise the table is not what it seems."""
        return 0 < len(self.rows) < self.others

    def notes(self, place: Callable[[int], str]) -> list[Note]:
        """A note for each; of very many, one for the rest."""
        told = zip(self.rows, self.texts, strict=False)
        what = "is not a row of data and is left out"
        notes = [(f"{place(row)} {what}: '{shortened(text)}'", _REMEDY) for row, text in told]
        more = len(self.rows) - len(self.texts)
        return [*notes, (f"{more} more rows are not rows of data and are left out", _REMEDY)] if more else notes


def rows_without_data(
    rows: Iterable[tuple[int, Cells, bool]],
    above: Collection[Cells],
    times: Sequence[int],
    check: Callable[[int, Cells], None] = lambda at, cells: None,
) -> WithoutData:
    """The rows of a table that hold neither a number nor a time, repeat its header, or end it without a time.

    Parameters
    ----------
    rows : place and cells of each row behind the header, and whether it is complete; the last one may not be
    above : rows of the header and what stands above it
    times : columns of the times; without them, rows at the end of the table are treated like the others
    check : refuses rows of text, given their place and cells, that must not be left out
    """
    found, behind, others = list[tuple[int, str]](), list[tuple[int, str]](), 0
    for at, cells, whole in rows:
        bare = tuple(cell.strip() for cell in cells)
        row = (at, ", ".join(filter(None, bare)))
        if bare in above:
            found.append(row)
        elif not any(map(is_datum, bare)):
            check(at, bare)
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
