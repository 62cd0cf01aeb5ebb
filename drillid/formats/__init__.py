"""Rig logs of any file format behind one function.

A format is one module of `drillid.formats.readers` with three members: `SUFFIXES`, the file name
endings that it reads; `headers(path, dialect)`, the columns of each table of the file with what
the file says about them; and `read_columns(path, header, columns, text, rows)`, which returns
columns as an Arrow table, the ones in `text` unchanged and the others as float64 where possible,
limited to the first `rows` rows where that is given. They raise `OSError`, or `ValueError` with the
reason. Everything else (packed files, a missing column, text among the numbers, times in any form)
is dealt with in this package once for all formats.
"""

from drillid.formats.column_names import column_in, column_named
from drillid.formats.continued import names_of
from drillid.formats.description import Dialect, Header, LogFormat, Note, TimeColumn
from drillid.formats.detection import format_of, formats
from drillid.formats.log import Log, first_stamp, headers, read_log, table_with

__all__ = [
    "Dialect",
    "Header",
    "Log",
    "LogFormat",
    "Note",
    "TimeColumn",
    "column_in",
    "column_named",
    "first_stamp",
    "format_of",
    "formats",
    "headers",
    "names_of",
    "read_log",
    "table_with",
]
