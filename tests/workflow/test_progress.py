"""What a run shows on a terminal: one line for each stage."""

import logging
import os
import pty
import re
import subprocess
from importlib import import_module
from types import SimpleNamespace

import pytest

from tests.workflow.killed import command, environment, write_wells
from tests.workflow.toys import ROOT, Checkout


def shown(checkout: Checkout, *words: str) -> tuple[int, str]:
    """Exit code of a run and what it leaves on a terminal, without colours."""
    ours, theirs = pty.openpty()
    size = {"COLUMNS": "100", "LINES": "40", "TERM": "xterm"}
    with subprocess.Popen(
        command(*words),
        cwd=checkout.root,
        env=environment(checkout) | size,
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
    ) as running:
        os.close(theirs)
        text = b""
        while True:
            try:
                piece = os.read(ours, 65536)
            except OSError:
                break
            text += piece
    os.close(ours)
    return running.returncode, re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", text.decode()).replace("\r", "\n")


def test_a_terminal_shows_a_line_for_each_stage_and_no_banners(checkout: Checkout) -> None:
    write_wells(checkout)
    (checkout.root / "raw/c.csv").write_text("bad")
    code, text = shown(checkout, "--until", "windows")
    assert code == 3, text
    last = [line for line in text.splitlines() if line.strip()][-3:]
    assert re.fullmatch(r"records +\S+ 3 of 3 \d:\d\d:\d\d 1 well\(s\) failed *", last[0])
    assert re.fullmatch(r"windows +\S+ 3 of 3 \d:\d\d:\d\d *", last[1])
    assert last[2].startswith("1 of 3 wells failed: W-2")
    assert "rule records" not in text
    assert "records: W1" not in text
    code, text = shown(checkout, "--until", "windows")
    assert "Nothing to be done" in text


def test_warnings_are_shown_but_for_those_of_folders_that_another_rule_made(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "workflow/plugins/progress")
    options = ("nocolor", "quiet", "show_failed_logs", "debug_dag", "verbose", "dryrun", "printshellcmds")
    common = SimpleNamespace(**dict.fromkeys(options, False) | {"quiet": set()})
    handler = import_module("snakemake_logger_plugin_drillid").LogHandler(common, None)
    for rule in ("figures_of_well", "fits"):
        text = (
            f"Warning: the following output files of rule {rule} were not present when the DAG was created:\n{{'W1'}}"
        )
        handler.emit(logging.LogRecord("snakemake", logging.WARNING, __file__, 1, text, None, None))
    shown = capsys.readouterr().err
    assert "rule fits were not present" in shown
    assert "figures_of_well" not in shown
