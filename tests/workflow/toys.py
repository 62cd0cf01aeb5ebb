"""A checkout with toy stages: the real Snakefile, rules, scripts, sheets and fleet, and stages that take no time."""

import os
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from drillid.fleet.stages import ALL_STAGES, STAGES
from tests.workflow.forked import snakemake

ROOT = Path(__file__).resolve().parents[2]
SHARED = (
    "commands",
    "config",
    "datasets",
    "fleet",
    "formats",
    "__init__.py",
    "__main__.py",
    "units",
    "arrays.py",
    "errors.py",
    "physics/parameters.py",
)
"""Rooms and modules of the library that are not replaced by toys."""
READ = {dataset for stage in STAGES.values() for dataset in stage.reads}
DATASETS = {name: sorted({name} | {dataset for stage, dataset in READ if stage == name}) for name in ALL_STAGES}

STAGE = '''
"""A toy stage: one line in the journal for each well, and a folder with a file for each dataset."""

import errno
import os
import signal
import time
from pathlib import Path

from drillid.errors import LogError
from drillid.datasets.store import Problem
{imports}

def process(well, folders, settings):
    with Path("journal.txt").open("a") as journal:
        journal.write("{stage} " + well.name + " " + str(os.getpid()) + "\\n")
    if "{stage}" == "start_ups" and not os.path.exists(well.log):
        raise LogError(str(well.log), "does not exist", "Check the path in its sheet")
    if "{stage}" == "records":
        # a missing log is a fault of the input, as the real readers say; any other OSError is one of the machine
        for log in well.logs:
            if not os.path.exists(log):
                raise LogError(str(log), "does not exist", "Check the path in the logs sheet")
        text = "".join(log.read_text() for log in well.logs)
        if "die" in text:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(60 if "slow" in text else 0.2)
        if "full" in text:
            raise OSError(errno.ENOSPC, "No space left on device", str(folders.stage("records")))
        if "memory" in text:
            raise MemoryError("too little of it")
        if "crash" in text:
            raise RuntimeError("nobody foresaw this")
        if "bad" in text:
            raise LogError(well.logs[0].name, "is bad", "Mend it")
    for name in {datasets}:
        store = folders.stage("{stage}") / (name + ".zarr")
        store.mkdir(parents=True)
        (store / "zarr.json").write_text("toy")
    if "{stage}" == "figures":
        (folders.stage("figures") / "figure_6.png").write_bytes(b"picture")
    return [Problem("sample 3", "is a spike", "None needed")] if "{stage}" == "windows" else []

'''

FLEET = '''
"""Toy tables of the fleet."""

from pathlib import Path


def write_fleet(results, wells):
    (Path(results) / "fleet.zarr").mkdir(exist_ok=True)
    (Path(results) / "verdicts.csv").write_text("well,verdict\\n")
'''

COMMON_CAUSES = '''
"""Toy tables of what wells have in common."""

from pathlib import Path


def write_common_causes(results, wells, settings):
    (Path(results) / "common_causes.csv").write_text("shared,name\\n")
    (Path(results) / "well_standings.csv").write_text("well,standing\\n")
    return 0
'''

LEARNT = '''
"""A toy table of what was learnt."""

from pathlib import Path


def write_learnt(results, wells):
    (Path(results) / "learnt.csv").write_text("well,resembles\\n")
'''

CHANGES = '''
"""A toy table of changes."""

from pathlib import Path


def write_changes(results, wells, problems, failed):
    (Path(results) / "changes.csv").write_text("well,change\\n" + "".join(f"{well},failed\\n" for well in failed))


def mark_reported(results):
    (Path(results) / "reported.json").write_text("{}")
'''

REPORT = '''
"""A toy report."""


def write_report(settings, results, wells):
    (results / "report").mkdir(exist_ok=True)
    for well in wells:
        (results / "report" / (well + ".html")).write_text(well)
    (results / "report.html").write_text(" ".join(wells))
    return dict.fromkeys(wells, 0.0)
'''

RIG = """
name: toy
channels:
  torque_sweep: {column: SWEEP, unit: kN m}
  speed: {column: RPM, unit: rpm}
  hole_depth: {column: DMEA, unit: m}
controller: {proportional: 1500 N m s/rad}
"""


@dataclass(frozen=True)
class Checkout:
    """A copy of the workflow with toy stages and sheets of its own."""

    root: Path

    def sheets(self, wells: dict[str, list[str]], rigs: dict[str, str] | None = None) -> None:
        """Write both sheets, and those log files that are not there yet."""
        rows = [f"{well}\t{(rigs or {}).get(well, 'toy')}\ta toy" for well in wells]
        (self.root / "config/wells.tsv").write_text("\n".join(["well\trig\tdescription", *rows]) + "\n")
        logs = [f"{well}\traw/{log}" for well, names in wells.items() for log in names]
        (self.root / "config/logs.tsv").write_text("\n".join(["well\tlog", *logs]) + "\n")
        for name in [name for names in wells.values() for name in names]:
            path = self.root / "raw" / name
            path.parent.mkdir(exist_ok=True)
            if not path.exists():
                path.write_text("samples")

    def run(self, *arguments: str, expect: int = 0) -> str:
        """Run Snakemake in the checkout; its output on both streams."""
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        code, output = snakemake(self.root, ["--cores", "2", "--scheduler", "greedy", *arguments], environment)
        assert code == expect, output
        return output

    def would_run(self, *arguments: str) -> list[str]:
        """Jobs that a dry run would run: 'rule', or 'rule batch' and 'rule well' where the rule has such a wildcard."""
        return jobs_in(self.run("--dry-run", *arguments))

    def journal(self) -> list[str]:
        """Lines 'stage well' that the stages wrote since the last call."""
        return [line.rpartition(" ")[0] for line in self.pids()]

    def pids(self) -> list[str]:
        """The same with the number of the process that did the work."""
        path = self.root / "journal.txt"
        lines = path.read_text().splitlines() if path.exists() else []
        path.unlink(missing_ok=True)
        return lines

    def edit(self, module: str, text: str) -> None:
        """Append a line to a module of the copied library."""
        path = self.root / "drillid" / f"{module}.py"
        path.write_text(path.read_text() + text)


def jobs_in(output: str) -> list[str]:
    """Jobs that Snakemake's output tells of, as `Checkout.would_run` names them."""
    blocks = re.findall(r"^(?:local)?rule (\S+):\n((?: +.*\n)*)", output, re.MULTILINE)
    found = [(rule, re.search(r"wildcards: .*?(?:batch|well|start_up)=([^,\s]+)", block)) for rule, block in blocks]
    return [f"{rule} {wildcard[1]}" if wildcard else rule for rule, wildcard in found]


def write_library(folder: Path) -> None:
    """A library whose stages are toys, in the same rooms as the real ones."""
    for name in SHARED:
        copy = shutil.copytree if (ROOT / "drillid" / name).is_dir() else shutil.copy
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        copy(ROOT / "drillid" / name, folder / name)
    texts = {
        f"{name}/stage.py": STAGE.format(
            stage=name,
            imports="from drillid.shared import USED_BY_FITS\n" if name == "fits" else "",
            datasets=DATASETS[name],
        )
        for name in ALL_STAGES
    }
    texts |= {
        "shared.py": "USED_BY_FITS = 1\n",
        "depth/fleet.py": FLEET,
        "depth/changes.py": CHANGES,
        "discrepancy/learning/__init__.py": "",
        "discrepancy/learning/fleet.py": LEARNT,
        "common_causes/stage.py": COMMON_CAUSES,
        "report/page.py": REPORT,
        "report/templates/report.html.j2": "",
    }
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    for room in (folder, *(path for path in folder.iterdir() if path.is_dir())):
        (room / "__init__.py").touch()


def new_checkout(tmp_path: Path) -> Checkout:
    """The workflow copied into a folder, with toy stages and no wells yet."""
    write_library(tmp_path / "drillid")
    for name in ("workflow", "scripts", "envs"):
        shutil.copytree(ROOT / name, tmp_path / name)
    shutil.copy(ROOT / "Snakefile", tmp_path)
    (tmp_path / "config/rigs").mkdir(parents=True)
    shutil.copy(ROOT / "config/config.yaml", tmp_path / "config")
    (tmp_path / "config/rigs/toy.yaml").write_text(RIG)
    found = Checkout(tmp_path)
    found.sheets({})
    return found
