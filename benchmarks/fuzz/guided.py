"""`python -m benchmarks.fuzz.guided`: files that Atheris changes towards lines of the readers not reached before.

Only the formats that are read by code of drillid itself: of others libraries in C do the work, which shows it no lines.
"""

import logging
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import typer

from drillid.errors import DrillidError

FORMATS = (".csv", ".las", ".xml")
_LONGEST_S, _LARGEST_MB, _LARGEST_FILE = 20, 4000, 4096
_ROWS = 8
"""Of the logs that are changed: enough for their times and units, and quickly read."""


def main(
    suffix: Annotated[str, typer.Option(help=f"One of {', '.join(FORMATS)}.")] = ".las",
    files: Annotated[int, typer.Option(help="Changed files.")] = 20_000,
    folder: Annotated[Path, typer.Option(help="Folder for files that reach new lines, and one that fails.")] = Path(
        "results/fuzz/guided"
    ),
) -> None:
    """Read changed files until so many are read or one fails: with another exception than drillid's, slow, or large."""
    import atheris

    with atheris.instrument_imports(include=["drillid.formats"]):
        import drillid.formats.readers.csv
        import drillid.formats.readers.las
        import drillid.formats.readers.witsml  # noqa: F401
        from drillid.formats import headers, read_log
    # lasio's remarks on lines
    logging.disable()
    corpus = folder / suffix.lstrip(".")
    corpus.mkdir(parents=True, exist_ok=True)
    write_seeds(corpus, suffix)
    limits = (f"-runs={files}", f"-timeout={_LONGEST_S}", f"-rss_limit_mb={_LARGEST_MB}", f"-max_len={_LARGEST_FILE}")
    words = [sys.argv[0], str(corpus), *limits, "-seed=1", f"-artifact_prefix={folder}/failed_{suffix.lstrip('.')}_"]
    with TemporaryDirectory() as place:
        atheris.Setup(words, reading(Path(place, f"log{suffix}"), headers, read_log))
        atheris.Fuzz()


def write_seeds(corpus: Path, suffix: str) -> None:
    """Logs in good order, of all writers of the format."""
    from benchmarks.fuzz import seeds

    for number, write in enumerate(seeds.writers(suffix)):
        (corpus / f"seed_{number}").write_bytes(write(seeds.logs()[0].head(_ROWS)))


def reading(path: Path, headers: Callable[..., Any], read_log: Callable[..., Any]) -> Callable[[bytes], None]:
    """A function that reads a file of these bytes, and lets no exception pass but those of drillid."""

    def read(content: bytes) -> None:
        path.write_bytes(content)
        try:
            for header in headers(path):
                log = read_log(path, None, header.columns[-1:])
                log.pop(header.columns[-1])
        except DrillidError:
            return

    return read


if __name__ == "__main__":
    typer.run(main)
