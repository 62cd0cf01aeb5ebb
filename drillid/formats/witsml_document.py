"""WITSML documents as streams of log objects with lines of their data; those with a DTD are refused."""

from __future__ import annotations

import codecs
import csv
import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, Any
from xml.sax.handler import ContentHandler

from drillid.formats.description import Unusable
from drillid.formats.mnemonics import time_among
from drillid.formats.packing import opened
from drillid.formats.text_layout import decoded

_BLOCK = 2**18
_LINES = 20_000
_OF_VERSION_2 = ("ChannelSet", "ChannelIndex")
_DECLARED = re.compile(rb"^(?:\xef\xbb\xbf)?\s*<\?xml[^>]*?encoding=[\"'](?P<encoding>[\w-]+)[\"'][^>]*\?>")
_DECLARATION = re.compile(r"^\s*<\?xml[^>]*\?>")
_TIME_INDEX, _ELAPSED_INDEX = "date time", "elapsed time"
_OF_CURVE = {"mnemonic": "mnemonic", "mnemAlias": "alias", "unit": "unit", "nullValue": "null", "typeLogData": "kind"}
"""Elements whose text a curve keeps, and the names under which it is kept."""
_OF_LOG = {
    "name": "name",
    "indexType": "index_type",
    "indexCurve": "index_curve",
    "startDateTimeIndex": "start",
    "nullValue": "null",
}
_LISTS = {"mnemonicList": "mnemonics", "unitList": "units"}
"""The same for a log object, as text and as lists."""


@dataclass
class Curve:
    """What a log object says of a curve, as text; `column`: its number among the cells, 0 where it is not stated."""

    mnemonic: str = ""
    alias: str = ""
    unit: str = ""
    null: str = ""
    column: int = 0
    kind: str = ""


@dataclass
class LogObject:
    """One log object, filled while it is read.

    place : its number and that of its block of data in the document
    start : start of its index, as text
    mnemonics, units : listed beside its data, in the order of the cells
    """

    place: tuple[int, int] = (0, 0)
    name: str = ""
    uid: str = ""
    index_type: str = ""
    index_curve: str = ""
    index_column: int = 0
    start: str = ""
    null: str = ""
    delimiter: str = ","
    curves: list[Curve] = field(default_factory=list)
    mnemonics: list[str] = field(default_factory=list)
    units: list[str] = field(default_factory=list)

    @property
    def called(self) -> str:
        """Its name, or what else identifies it."""
        return self.name or self.uid or f"log {self.place[0]}"

    @property
    def over_time(self) -> bool:
        """Whether the index is a time; if the log does not say, by the name of its index."""
        if self.index_type:
            return self.index_type.replace("_", " ").strip().lower() in (_TIME_INDEX, "datetime", _ELAPSED_INDEX)
        ordered = self.ordered()
        index = self.index_curve or (ordered[0].mnemonic if ordered else "")
        return "TIME" in index.upper() or time_among([index]) is not None

    @property
    def over_elapsed_time(self) -> bool:
        """Whether the index counts from the log's start."""
        return self.index_type.replace("_", " ").strip().lower() == _ELAPSED_INDEX

    def ordered(self) -> list[Curve]:
        """Curves in the order of the cells."""
        if self.mnemonics:
            by_name: dict[str, Curve] = {}
            for curve in self.curves:
                by_name.setdefault(curve.mnemonic, curve)
            found = [by_name.get(name) or Curve(name) for name in self.mnemonics]
            units = itertools.chain(self.units, itertools.repeat(""))
            return [replace(curve, unit=curve.unit or unit) for curve, unit in zip(found, units, strict=False)]
        if self.curves and all(curve.column for curve in self.curves):
            return sorted(self.curves, key=lambda curve: curve.column)
        return self.curves


def documents(path: Path, lines: bool) -> Iterator[tuple[LogObject, list[str]]]:
    """Logs of a document with pieces of their lines of data.

    A log is yielded once for each piece, or once without lines where only headers are wanted.
    """
    from defusedxml import DefusedXmlException

    handler = _Handler(lines=lines)
    parser = _parser(handler)
    try:
        with opened(path) as content:
            yield from _fed(parser, handler, content)
    except DefusedXmlException as error:
        raise Unusable(
            "declares entities or a document type, which no WITSML log needs and which may be an attack",
            "Export the log again without them",
        ) from error


def _fed(parser: Any, handler: _Handler, content: IO[bytes]) -> Iterator[tuple[LogObject, list[str]]]:
    from xml.sax import SAXException, SAXParseException

    try:
        for block in _blocks(content):
            parser.feed(block)
            yield from handler.taken()
        parser.close()
    except SAXParseException as error:
        raise ValueError(f"line {error.getLineNumber()}: {error.getMessage()}") from error
    except (SAXException, AssertionError) as error:
        raise ValueError(str(error)) from error
    yield from handler.taken()
    if not handler.number:
        raise Unusable(
            f"holds no log object of WITSML, but '{handler.root}'", "Export the log object with the channels"
        )


def _blocks(content: IO[bytes]) -> Iterator[bytes]:
    """Pieces of a document, turned into UTF-8 where its declaration is wrong."""
    first = content.read(_BLOCK)
    actual = _undeclared(first)
    if actual is None:
        yield from itertools.chain([first] if first else [], iter(lambda: content.read(_BLOCK), b""))
        return
    decoder = codecs.getincrementaldecoder(actual)(errors="replace")
    yield decoder.decode(_DECLARED.sub(b"", first, count=1)).encode()
    while block := content.read(_BLOCK):
        yield decoder.decode(block).encode()
    yield decoder.decode(b"", final=True).encode()


def _undeclared(start: bytes) -> str | None:
    """Encoding of a document with a wrong declaration, such as that of text in memory, UTF-16, in a file in UTF-8."""
    if b"\x00" in start[:4] or start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return None
    declared = _DECLARED.match(start)
    name = b"utf-8" if declared is None else declared["encoding"].lower()
    if name not in (b"utf-8", b"utf8", b"utf-16", b"unicode"):
        return None
    actual = decoded(start)[1].removesuffix("-sig")
    return None if actual == "utf-8" and name in (b"utf-8", b"utf8") else actual


class _Handler(ContentHandler):
    """Fills logs from the events of a parser, whatever the elements' namespace."""

    def __init__(self, *, lines: bool) -> None:
        super().__init__()
        self.lines = lines
        self.log: LogObject | None = None
        self.curve: Curve | None = None
        self.text: list[str] | None = None
        self.rows: list[str] = []
        self.ready: list[tuple[LogObject, list[str]]] = []
        self.seen = False
        self.number, self.root = 0, ""

    def taken(self) -> list[tuple[LogObject, list[str]]]:
        """What has been completed since the last call."""
        if self.log is not None and len(self.rows) >= _LINES:
            self._hand_over(self.log)
        ready, self.ready = self.ready, []
        return ready

    def startElement(self, name: str, attrs: Any) -> None:
        """Start of an element."""
        local = name.rpartition(":")[2]
        self.root = self.root or local
        if local in _OF_VERSION_2:
            raise Unusable("is in version 2 of WITSML", "Export it as WITSML 1.4.1.1")
        if local == "log":
            self.number += 1
            self.log, self.seen = LogObject((self.number, 0), uid=attrs.get("uid", "")), False
        elif local == "logCurveInfo":
            self.curve = Curve(attrs.get("uid", ""))
        elif local == "indexCurve" and self.log is not None:
            self.log.index_column = int(attrs.get("columnIndex", "0") or 0) if "columnIndex" in attrs else 0
        self.text = []

    def characters(self, content: str) -> None:
        """Text of an element, in pieces."""
        if self.text is not None:
            self.text.append(content)

    def endElement(self, name: str) -> None:
        """End of an element."""
        local = name.rpartition(":")[2]
        text, self.text = "".join(self.text or ()), None
        if local.lower() == "xmlout" and text.strip():
            # the answer of a WITSML server holds the document as text
            inner = _parser(self)
            inner.feed(_DECLARATION.sub("", text, count=1).encode())
            inner.close()
        if self.log is not None:
            self._end_in(self.log, local, text.strip())

    def _end_in(self, log: LogObject, element: str, text: str) -> None:
        """End of an element of a log."""
        if element == "mnemonicList" and log.mnemonics:
            # further data of the log, which may list other curves
            self._hand_over(log)
            number, block = log.place
            log = self.log = replace(log, place=(number, block + 1), units=[])
            self.seen = False
        if element == "data":
            if self.lines:
                self.rows.append(text)
        elif element == "log":
            if self.rows or not self.seen:
                self._hand_over(log)
            self.log = None
        elif element == "logCurveInfo":
            if self.curve is not None:
                log.curves.append(self.curve)
            self.curve = None
        elif self.curve is not None:
            _fill_curve(self.curve, element, text)
        else:
            _fill_log(log, element, text)

    def _hand_over(self, log: LogObject) -> None:
        """Make what has been collected of a log ready to be taken."""
        self.ready.append((log, self.rows))
        self.rows, self.seen = [], True


def _parser(handler: _Handler) -> Any:
    """A parser that refuses documents with a DTD."""
    from defusedxml.expatreader import DefusedExpatParser

    parser = DefusedExpatParser(forbid_dtd=True)
    parser.setContentHandler(handler)
    return parser


def _fill_curve(curve: Curve, element: str, text: str) -> None:
    if element in _OF_CURVE:
        setattr(curve, _OF_CURVE[element], text)
    elif element == "columnIndex" and text.isdigit():
        curve.column = int(text)


def _listed(text: str) -> list[str]:
    """Cells of a list of names or units, which damage may spread over lines."""
    return [cell.strip() for cell in next(csv.reader([text.replace("\r", " ").replace("\n", " ")]), [])]


def _fill_log(log: LogObject, element: str, text: str) -> None:
    if element in _OF_LOG:
        setattr(log, _OF_LOG[element], text)
    elif element in _LISTS:
        setattr(log, _LISTS[element], _listed(text))
    elif element == "dataDelimiter" and text:
        log.delimiter = text
