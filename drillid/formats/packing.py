"""Packed files: gzip, bzip2, xz, zstandard and zip with one member, read as streams, bombs refused."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, cast

from drillid.formats.description import Note, Unusable
from drillid.formats.places import shortened

PACKED = (".gz", ".gzip", ".bz2", ".xz", ".zst", ".zstd", ".zip")
"""Endings of packed files."""
_MAGIC = {b"\x1f\x8b": "gzip", b"BZh": "bz2", b"\xfd7zXZ\x00": "xz", b"\x28\xb5\x2f\xfd": "zstd", b"PK\x03\x04": "zip"}
_MOST_NAMES = 4
"""Number of files of an archive that a message lists."""
_BESIDE = re.compile(
    r"(?:read[ _-]?me|licen[cs]e|about|copying|manifest|checksums?|md5sums?|sha\d+sums?)(?:\.\w+)?"
    r"|.*\.(?:md|pdf|docx?|rtf|html?|png|jpe?g|gif|md5|sha\d+|sfv)|thumbs\.db|desktop\.ini",
    re.IGNORECASE,
)
"""Files of an archive that are not logs."""
_TAR_MAGIC = slice(257, 262), b"ustar"
"""Position and content of the bytes that identify tar archives."""
_ALLOWED_BYTES = 256 * 2**20
"""Content of this size is allowed whatever it is packed into."""
_LARGEST_RATIO = 250
"""Larger content may be at most this many times the size of the file: logs of rigs pack 3 to 50 times."""
_BLOCK = 2**20


def packing_of(path: Path) -> str | None:
    """How a file is packed, by its first bytes; None where it is not, or where it is missing or a folder."""
    start = first_bytes(path, 8)
    return next((name for magic, name in _MAGIC.items() if start.startswith(magic)), None)


def first_bytes(path: Path, count: int) -> bytes:
    """The file's first bytes as they are stored; none of a folder or a missing file."""
    if not path.is_file():
        return b""
    with path.open("rb") as file:
        return file.read(count)


def inner_name(path: Path) -> str:
    """Name of the file's content: without the ending of its packing, or of the member of a zip file."""
    name = path.name
    while name.lower().endswith(PACKED):
        if name == path.name and packing_of(path) == "zip":
            with contextlib.suppress(ValueError, zipfile.BadZipFile, OSError), zipfile.ZipFile(path) as archive:
                return Path(_member(archive).filename).name
        name = name[: name.rindex(".")]
    return name


@contextlib.contextmanager
def opened(path: Path) -> Iterator[IO[bytes]]:
    """The file's content, unpacked as it is read.

    Raises
    ------
    ValueError
        If the file is damaged, a zip file with several members, or a bomb.
    OSError
        If it cannot be read.
    """
    packing = packing_of(path)
    if packing is None:
        with path.open("rb") as file:
            yield file
        return
    try:
        with contextlib.ExitStack() as stack:
            yield cast(IO[bytes], _Limited(_unpacked(path, packing, stack), path.stat().st_size))
    except (zlib.error, EOFError, zipfile.BadZipFile, RuntimeError, NotImplementedError) as error:
        raise ValueError(str(error) or "it is cut short") from error


def _unpacked(path: Path, packing: str, stack: contextlib.ExitStack) -> Any:
    if packing == "zip":
        archive = stack.enter_context(zipfile.ZipFile(path))
        return stack.enter_context(archive.open(_member(archive)))
    if packing == "gzip":
        import gzip

        return stack.enter_context(gzip.open(path))
    if packing == "bz2":
        import bz2

        return stack.enter_context(bz2.open(path))
    if packing == "xz":
        import lzma

        return stack.enter_context(lzma.open(path))
    import pyarrow as pa

    return stack.enter_context(pa.input_stream(str(path), compression="zstd"))


def _member(archive: zipfile.ZipFile) -> zipfile.ZipInfo:
    """The one log in an archive, whatever folders, hidden files and texts for its reader lie beside it.

    Raises
    ------
    Unusable
        If it holds several files, none, or one that is locked.
    """
    members = _files(archive)
    if len(members) > 1:
        members = [member for member in members if not _is_beside(member)] or members
    if len(members) != 1:
        names = ", ".join(shortened(member.filename) for member in members[:_MOST_NAMES])
        raise Unusable(
            f"is a zip file with {len(members)} files ({names}), where one is expected",
            "Unpack it, or zip each log separately",
        )
    if members[0].flag_bits & 1:
        raise Unusable("is protected by a password", "Unpack it")
    return members[0]


def _files(archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """Files of an archive, without hidden ones."""
    return [
        member
        for member in archive.infolist()
        if not member.is_dir() and not Path(member.filename).name.startswith(".") and "__MACOSX" not in member.filename
    ]


def _is_beside(member: zipfile.ZipInfo) -> bool:
    return _BESIDE.fullmatch(Path(member.filename).name) is not None


def notes_on(path: Path) -> tuple[Note, ...]:
    """A note on the files beside the log in an archive that are not logs, if there are any."""
    if not path.name.lower().endswith(PACKED) or packing_of(path) != "zip":
        return ()
    with zipfile.ZipFile(path) as archive:
        files = _files(archive)
    beside = [member.filename for member in files if _is_beside(member)] if len(files) > 1 else []
    names = ", ".join(f"'{shortened(name)}'" for name in beside[:_MOST_NAMES])
    more = f" and {len(beside) - _MOST_NAMES} more" if len(beside) > _MOST_NAMES else ""
    what = f"files in the archive are not logs, judging by their names, and are not read: {names}{more}"
    return ((what, "Zip each log separately if one of them is a log"),) if beside else ()


class _Limited(io.RawIOBase):
    """A stream that ends with an error where its content is absurdly larger than the file."""

    def __init__(self, stream: Any, packed_size: int) -> None:
        self.stream, self.size = stream, 0
        self.limit = max(_ALLOWED_BYTES, _LARGEST_RATIO * packed_size)

    def readable(self) -> bool:
        """Streams of bytes to read."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Next bytes into the buffer."""
        content = self.read(len(buffer))
        buffer[: len(content)] = content
        return len(content)

    def read(self, size: int = -1) -> bytes:
        """Next bytes; all that is left by default."""
        if size < 0:
            return b"".join(iter(lambda: self.read(_BLOCK), b""))
        content: bytes = bytes(self.stream.read(size))
        self.size += len(content)
        if self.size > self.limit:
            what = f"unpacks to more than {self.limit / 2**20:.0f} MiB, far more than a log of its size holds"
            raise Unusable(what, "Export the log again; a log of unusual size can be listed unpacked")
        return content


@contextlib.contextmanager
def unpacked_file(path: Path, suffix: str, streams: bool) -> Iterator[Path]:
    """A file that the reader can read: the file itself, or an unpacked copy while the block lasts.

    Parameters
    ----------
    suffix : ending of the name that the copy is given
    streams : whether the reader unpacks by itself, as `opened` does
    """
    packing = packing_of(path)
    if streams or packing is None or (packing == "zip" and not path.name.lower().endswith(PACKED)):
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="drillid-") as folder:
        copy = Path(folder, f"log{suffix}")
        with opened(path) as content, copy.open("wb") as file:
            shutil.copyfileobj(content, file, _BLOCK)
        yield copy


def check_no_tar(start: bytes) -> None:
    """Refuse a tar archive, by the first bytes of the unpacked content.

    Raises
    ------
    Unusable
        If it is one.
    """
    place, magic = _TAR_MAGIC
    if start[place] == magic:
        raise Unusable("is a tar archive, which may hold several files", "Unpack it, or pack each log separately")


def lines_at_start(path: Path, size: int = 2**18) -> bytes:
    """The first bytes of the content, up to `size`."""
    with opened(path) as content:
        return content.read(size)


def check_archive(path: Path) -> None:
    """Refuse a workbook, which is a zip file, that unpacks to absurdly more than its size.

    Raises
    ------
    ValueError
        If it is not a zip file, or is a bomb.
    """
    with zipfile.ZipFile(path) as archive:
        size = sum(member.file_size for member in archive.infolist())
    limit = max(_ALLOWED_BYTES, _LARGEST_RATIO * path.stat().st_size)
    if size > limit:
        raise Unusable(
            f"unpacks to {size / 2**20:.0f} MiB, far more than a workbook of its size holds",
            "Export the log again, as CSV",
        )
