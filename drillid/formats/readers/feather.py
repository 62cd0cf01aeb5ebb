"""Apache Feather and Arrow files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from drillid.formats.arrow_tables import with_floats
from drillid.formats.description import Dialect, Header
from drillid.formats.readers.parquet import header_of

SUFFIXES = (".feather", ".arrow", ".ipc", ".arrows")
FRAGILE = True


@contextmanager
def _batches(path: Path, columns: list[int] | None = None) -> Iterator[tuple[Any, Iterator[Any]]]:
    """Schema and batches of a file, or of a stream that was saved as one."""
    import pyarrow as pa

    options = pa.ipc.IpcReadOptions(included_fields=columns)
    with pa.OSFile(str(path)) as source:
        if source.read(6) == b"ARROW1":
            source.seek(0)
            file = pa.ipc.open_file(source, options=options)
            yield file.schema, (file.get_batch(number) for number in range(file.num_record_batches))
            return
        source.seek(0)
        stream = pa.ipc.open_stream(source, options=options)
        yield stream.schema, iter(stream)


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """The one table of the file."""
    with _batches(path) as (schema, _):
        return [header_of(schema)]


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table; numbers of any width become float64."""
    import pyarrow as pa

    wanted = [header.columns.index(name) for name in columns]
    with _batches(path, sorted(wanted)) as (schema, batches):
        found, count = [], 0
        for batch in batches:
            # damaged lengths and offsets would lead out of memory later on
            batch.validate(full=True)
            found.append(batch)
            count += batch.num_rows
            if rows is not None and count >= rows:
                break
        table = pa.Table.from_batches(found, schema)
    table = table.rename_columns([header.columns[at] for at in sorted(wanted)]).select(list(columns))
    return with_floats(table if rows is None else table.slice(0, rows), text)
