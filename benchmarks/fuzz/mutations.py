"""Mutations of logs: of their tables before they are written, and of the bytes of their files."""

import gzip
import io
import zipfile
from collections.abc import Callable
from random import Random

import numpy as np
import pandas as pd

OfTable = Callable[[Random, pd.DataFrame], pd.DataFrame]
OfBytes = Callable[[Random, bytes], bytes]

CELLS = (
    *(np.nan, np.inf, -np.inf, 0.0, -0.0, 1e308, -1e308, 5e-324, 1e19, -999.25, -9999.0, 65535.0, -32768.0, 1e6),
    *(
        "",
        " ",
        "n/a",
        "NaN",
        "inf",
        "1,5",
        "1.234,5",
        "1e999",
        "0x10",
        "١٢",
        "true",
        "2025-03-03",
        "=1+1",
        "\x00",
        "−5",
        "1_0",
    ),
)
"""Values that recorders, offices and damage put into cells."""
STAMPS = (
    *("", "noon", "0", "NaT", "2025-03-03T06:00:00", "2025-03-03T06:00:00+25:00", "2025-03-03T06:00:00.5-05:00"),
    *("2025-02-30T00:00:00Z", "1677-09-21T00:12:43Z", "2262-04-12T00:00:00Z", "2233-01-01T00:00:00Z", "9999-12-31"),
    *("0001-01-01", "1741000000", "1741000000000000000", "45718.25", "03/04/2025 6:00 PM", "06:00:00", "2025-W10-1"),
    *("2025-03-03T24:00:00Z", "2025-03-30T02:30:00", "2025-10-26T02:30:00", "-1", "1e300", "2025-03-03T06:00:60Z"),
)
"""Stamps in other forms than the log's, impossible ones, and none."""
NAMES = ("", " ", "Time", "RPM", "\x07", "a" * 70_000, "Drehzahl ü½", "\udcff\udcfe", "RPM,HOLE", '"', "<script>", "\n")
"""Names that a column may have by accident."""
TOKENS = tuple(
    text.encode("utf-8", "surrogateescape")
    for text in (
        *(
            "nan",
            "inf",
            "-999.25",
            "1e999",
            "\x00",
            "\ufeff",
            "\r",
            "\n\n",
            ",",
            ",,,,,,,,",
            ";",
            "\t",
            '"',
            "'",
            "Z",
            "+25:00",
        ),
        *(
            "2233-",
            "0000-00-00T00:00:00Z",
            "\udcff",
            "<",
            "&",
            "]]>",
            "~A\n",
            "~C\n",
            "<!ENTITY a 'b'>",
            "PAR1",
            "PK\x03\x04",
            "#",
        ),
    )
)
"""Bytes that mean something to one reader or another."""


def cells(random: Random, log: pd.DataFrame) -> pd.DataFrame:
    """Some cells of a column replaced."""
    name = random.choice(list(log.columns))
    rows = random.sample(range(len(log)), min(len(log), random.choice((1, 1, 5, 200))))
    values = log[name].astype(object).tolist()
    for row in rows:
        values[row] = random.choice(STAMPS if name == "Time" else CELLS)
    return log.assign(**{name: pd.Series(values, index=log.index, dtype=object)})


def numbers(random: Random, log: pd.DataFrame) -> pd.DataFrame:
    """Runs of numbers of a column replaced by one, by noise, or taken out."""
    name = random.choice([name for name in log.columns if name != "Time" and log[name].dtype.kind == "f"] or [None])
    if name is None:
        return log
    values = log[name].to_numpy(copy=True)
    generator = np.random.default_rng(random.getrandbits(32))
    for _ in range(random.choice((1, 1, 4, 40))):
        first, length = random.randrange(len(log)), random.choice((1, 1, 2, 3, 5, 40, 300))
        inside = values[first : first + length]
        inside[:] = random.choice(
            [
                lambda inside: random.choice([cell for cell in CELLS if isinstance(cell, float)]),
                lambda inside: values[0],
                lambda inside: np.nan,
                lambda inside: inside[::-1].copy(),
                lambda inside: inside + generator.normal(0, 10.0 ** random.randint(-6, 4), inside.size),
                lambda inside: inside * random.choice((-1.0, 0.3048, 3.28, 1e3, 1e-3)),
            ]
        )(inside)
    return log.assign(**{name: values})


def whole_column(random: Random, log: pd.DataFrame) -> pd.DataFrame:
    """A column of one value, of another kind, or of another size."""
    name = random.choice([name for name in log.columns if name != "Time"] or ["Time"])
    column = log[name]
    changed = random.choice(
        [
            lambda: pd.Series(random.choice(CELLS), index=column.index),
            lambda: column.astype(str),
            lambda: column.isna(),
            lambda: pd.Series([str(value).encode() for value in column], index=column.index),
            lambda: pd.to_numeric(column, errors="coerce") * 10.0 ** random.randint(-310, 308),
            lambda: -pd.to_numeric(column, errors="coerce"),
            lambda: pd.to_numeric(column, errors="coerce").where(column.index % random.randint(2, 500) == 0),
            lambda: pd.Series(
                np.random.default_rng(random.getrandbits(32)).standard_cauchy(len(log)), index=column.index
            ),
            lambda: pd.Series(
                np.random.default_rng(random.getrandbits(32)).integers(0, 3, len(log)), index=column.index
            ),
            lambda: column.ffill().where(column.index % 100 < 50).ffill(),
        ]
    )
    with np.errstate(all="ignore"):
        return log.assign(**{name: changed()})


def names(random: Random, log: pd.DataFrame) -> pd.DataFrame:
    """A column renamed, left out, or moved."""
    name = random.choice(list(log.columns))
    others = [column for column in log.columns if column != name]
    return random.choice(
        [
            lambda: log.rename(columns={name: random.choice(NAMES)}),
            lambda: log.drop(columns=name),
            lambda: log[[*others, name]],
            lambda: log.rename(columns={name: others[0], others[0]: name}) if others else log,
        ]
    )()


def stamps(random: Random, log: pd.DataFrame) -> pd.DataFrame:
    """Stamps moved, repeated, zeroed, in another unit or another order."""
    if "Time" not in log or log["Time"].dtype.kind != "M" or log.empty:
        return log
    time, rows = log["Time"], np.arange(len(log))
    first, stop = sorted(random.sample(range(len(log) + 1), 2)) if len(log) > 1 else (0, 1)
    inside = pd.Series((rows >= first) & (rows < stop), index=log.index)
    generator = np.random.default_rng(random.getrandbits(32))
    far = pd.Timedelta(seconds=random.choice((0.001, 0.3, 7, 299, 3600, 4e6, 3e8)) * random.choice((-1, 1)))
    since = time - time.iloc[0]
    changed = random.choice(
        [
            lambda: time.mask(inside, pd.Timestamp(0)),
            lambda: time.mask(inside, pd.NaT),
            lambda: time + inside * far,
            lambda: time + far * (rows // random.choice((1, 2, 50, 300))),
            lambda: time.iloc[0] + since * random.choice((0.0, 1e-9, 1e-6, 1e-3, 0.5, 60.0, 1e3, 1e5)),
            lambda: time.dt.floor(random.choice(("s", "100ms", "h"))),
            lambda: time + pd.to_timedelta(generator.normal(0, random.choice((0.002, 0.02, 5.0)), len(log)), unit="s"),
            lambda: time.where(
                ~inside, pd.Timestamp(0) + pd.to_timedelta(generator.integers(0, 2**62, len(log)), "ns")
            ),
            lambda: pd.Series(
                [cell.isoformat() + random.choice(("Z", "", "+01:00")) for cell in time], index=log.index
            ),
            lambda: time.astype("int64") // random.choice((1, 10**3, 10**6, 10**9)),
            lambda: since.dt.total_seconds(),
            lambda: time.dt.tz_localize("UTC").dt.tz_convert("America/Chicago").dt.tz_localize(None),
        ]
    )
    return log.assign(Time=changed())


def rows(random: Random, log: pd.DataFrame) -> pd.DataFrame:
    """Rows left out, repeated, shuffled, turned round, or hardly any."""
    size = len(log)
    first, stop = sorted((random.randint(0, size), random.randint(0, size)))
    seed = random.getrandbits(32)
    return random.choice(
        [
            lambda: log.iloc[: random.randint(0, 15)],
            lambda: log.iloc[::-1],
            lambda: log.sample(frac=1, random_state=seed),
            lambda: log.sample(frac=random.random(), random_state=seed).sort_index(),
            lambda: pd.concat([log.iloc[:stop], log.iloc[first:]]),
            lambda: pd.concat([log.iloc[stop:], log.iloc[:stop]]),
            lambda: log.iloc[np.repeat(np.arange(size), random.randint(1, 3))],
            lambda: log.iloc[:: random.randint(2, 60)],
            lambda: pd.concat([log, log]),
        ]
    )()


def flips(random: Random, content: bytes) -> bytes:
    """Some bits turned over."""
    changed = bytearray(content)
    for _ in range(random.choice((1, 1, 3, 20, 200))):
        if changed:
            changed[random.randrange(len(changed))] ^= 1 << random.randrange(8)
    return bytes(changed)


def cut(random: Random, content: bytes) -> bytes:
    """The file up to some byte."""
    return content[: random.randint(0, len(content))]


def part(random: Random, content: bytes) -> tuple[int, int]:
    """Bounds of some bytes of the file, a few of them or many."""
    first = random.randint(0, len(content))
    return first, min(len(content), first + random.choice((1, 4, 8, 64, 512, 10_000)))


def removed(random: Random, content: bytes) -> bytes:
    """Some bytes left out."""
    first, stop = part(random, content)
    return content[:first] + content[stop:]


def repeated(random: Random, content: bytes) -> bytes:
    """Some bytes several times."""
    first, stop = part(random, content)
    return content[:first] + content[first:stop] * random.choice((2, 3, 50)) + content[stop:]


def spliced(random: Random, content: bytes) -> bytes:
    """Some bytes put somewhere else, or over others."""
    first, stop = part(random, content)
    at = random.randint(0, len(content))
    return content[:at] + content[first:stop] + content[at + random.choice((0, stop - first)) :]


def filled(random: Random, content: bytes) -> bytes:
    """Some bytes zeroed, all ones, or anything."""
    first, stop = part(random, content)
    fill = random.choice((bytes(stop - first), b"\xff" * (stop - first), random.randbytes(stop - first)))
    return content[:first] + fill + content[stop:]


def tokens(random: Random, content: bytes) -> bytes:
    """Bytes that mean something put in, or in place of others."""
    for _ in range(random.choice((1, 1, 3))):
        at = random.randint(0, len(content))
        token = random.choice(TOKENS)
        content = content[:at] + token + content[at + random.choice((0, len(token))) :]
    return content


def replaced(random: Random, content: bytes) -> bytes:
    """One byte that occurs often replaced by another wherever it occurs."""
    old, new = random.choice(
        ((b"\n", b"\r"), (b"\n", b"\r\n"), (b",", b";"), (b".", b","), (b":", b"."), (b"-", b"/"), (b"0", b""))
    )
    return content.replace(old, new, random.choice((1, 5, -1)))


def wrapped(random: Random, content: bytes) -> bytes:
    """The file packed once more, in an archive, several times, or twice in one archive."""
    for _ in range(random.choice((1, 1, 2, 5))):
        if random.random() < 0.5:
            content = gzip.compress(content, 1, mtime=0)
            continue
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in random.choice((("log.csv",), ("log.zip",), ("a.csv", "b.csv"), ("../log.csv",), ("folder/",))):
                archive.writestr(name, content)
        content = buffer.getvalue()
    return content


OF_TABLES: tuple[OfTable, ...] = (cells, numbers, numbers, numbers, whole_column, names, stamps, stamps, rows, rows)
OF_BYTES: tuple[OfBytes, ...] = (flips, cut, removed, repeated, spliced, filled, tokens, replaced, wrapped)
