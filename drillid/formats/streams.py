"""Streams of text on their way to a parser: other encodings, runs of spaces."""

from __future__ import annotations

import codecs
import io
import itertools
from collections.abc import Collection, Iterator
from typing import IO

DELIMITER = "\x1f"
"""Character that stands for any number of spaces; it occurs in no text."""
_BLOCK = 2**22
_LINES = 2**14


class _Changed(io.RawIOBase):
    """A stream of bytes that is changed block by block."""

    def __init__(self, stream: IO[bytes]) -> None:
        self.stream, self.ready = stream, b""

    def readable(self) -> bool:
        """Streams of bytes to read."""
        return True

    def next_block(self) -> bytes | None:
        """The next changed bytes, None at the end."""
        raise NotImplementedError

    def read(self, size: int | None = -1) -> bytes:
        """Next bytes."""
        pieces, held, wanted = [self.ready], len(self.ready), -1 if size is None else size
        while wanted < 0 or held < wanted:
            block = self.next_block()
            if block is None:
                break
            pieces.append(block)
            held += len(block)
        whole = b"".join(pieces)
        if wanted < 0:
            self.ready = b""
            return whole
        self.ready = whole[wanted:]
        return whole[:wanted]


class _ByLines(_Changed):
    """A stream of lines, changed many at a time."""

    def __init__(self, stream: IO[bytes]) -> None:
        super().__init__(stream)
        self.rest, self.ended = b"", False

    def changed(self, lines: bytes) -> bytes:
        """The changed lines."""
        raise NotImplementedError

    def next_block(self) -> bytes | None:
        """Whole lines; what follows the last line break waits for the next block."""
        if self.ended:
            return None
        block = self.stream.read(_BLOCK)
        self.ended = not block
        block = self.rest + block
        whole = len(block) if self.ended else _whole_lines(block)
        self.rest = block[whole:]
        return self.changed(block[:whole])


class Squeezed(_ByLines):
    """Lines with each run of spaces and tabs as one `DELIMITER`, and none at their ends."""

    def changed(self, lines: bytes) -> bytes:
        """The lines with one delimiter between their words."""
        return squeezed(lines)


class Closed(_ByLines):
    """Lines in which a quote that does not close is a character like any other.

    A parser takes all that follows such a quote, up to the next one, as a single cell.
    """

    def __init__(self, stream: IO[bytes], delimiter: str, width: int) -> None:
        """A stream of lines with so many cells each."""
        super().__init__(stream)
        self.delimiter, self.width = delimiter.encode(), width

    def changed(self, lines: bytes) -> bytes:
        """The lines, without the quotes of those whose quotes are not in pairs."""
        return b"".join(map(self._closed, lines.splitlines(keepends=True))) if b'"' in lines else lines

    def _closed(self, line: bytes) -> bytes:
        """The line without its quotes, if their number is odd and it has all of its cells."""
        if line.count(b'"') % 2 == 0 or line.count(self.delimiter) + 1 < self.width:
            return line
        return line.replace(b'"', b"")


class WithoutLines(_Changed):
    """Lines without those of some numbers, counted from 0."""

    def __init__(self, stream: IO[bytes], left_out: Collection[int]) -> None:
        super().__init__(stream)
        self.kept = (line for at, line in enumerate(lines_of(stream)) if at not in left_out)

    def next_block(self) -> bytes | None:
        """The next lines."""
        return b"".join(itertools.islice(self.kept, _LINES)) or None


class Transcoded(_Changed):
    """The same text in UTF-8."""

    def __init__(self, stream: IO[bytes], encoding: str) -> None:
        super().__init__(stream)
        self.decoder, self.ended = codecs.getincrementaldecoder(encoding)(errors="replace"), False

    def next_block(self) -> bytes | None:
        """The next characters."""
        if self.ended:
            return None
        block = self.stream.read(_BLOCK)
        self.ended = not block
        return self.decoder.decode(block, final=not block).encode()


def lines_of(stream: IO[bytes]) -> Iterator[bytes]:
    """Lines with their ends, whatever these are; `bytes.splitlines` block by block."""
    rest = b""
    while block := stream.read(_BLOCK):
        block = rest + block
        whole = _whole_lines(block)
        rest = block[whole:]
        yield from block[:whole].splitlines(keepends=True)
    yield from rest.splitlines(keepends=True)


def _whole_lines(block: bytes) -> int:
    """Size of the lines of a block that are complete."""
    # a carriage return at the very end may belong to a line feed that is yet to come
    return 1 + max(block.rfind(b"\n"), block.rfind(b"\r", 0, -1))


def squeezed(lines: bytes) -> bytes:
    """Lines with one delimiter between their words."""
    ended = b"\n" if lines.endswith((b"\n", b"\r")) else b""
    return b"\n".join(map(DELIMITER.encode().join, map(bytes.split, lines.splitlines()))) + ended


def in_utf_8(stream: IO[bytes], encoding: str) -> IO[bytes]:
    """The stream itself where its text is UTF-8 or ASCII, else its text in UTF-8."""
    if encoding.lower() in ("utf-8", "utf8", "ascii"):
        return stream
    return Transcoded(stream, encoding)  # type: ignore[return-value]


def parsable(stream: IO[bytes], delimiter: str, width: int) -> tuple[IO[bytes], str]:
    """Lines as a parser takes them, and the delimiter between their cells.

    Parameters
    ----------
    delimiter : a space stands for runs of spaces and tabs
    width : number of cells of a line
    """
    if delimiter != " ":
        return Closed(stream, delimiter, width), delimiter  # type: ignore[return-value]
    return Closed(Squeezed(stream), DELIMITER, width), DELIMITER  # type: ignore[arg-type,return-value]
