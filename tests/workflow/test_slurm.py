"""The workflow on a real Slurm of one node, this machine, from Debian's packages; only where asked for."""

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.workflow.toys import Checkout

PROGRAMS = ("slurmctld", "slurmd", "sbatch", "munged")
MISSING = [name for name in PROGRAMS if shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin") is None]

SLURM = Path("/etc/slurm/slurm.conf")
"""Where jobs look for it; their environment is Slurm's own."""

pytestmark = pytest.mark.skipif(
    "DRILLID_TEST_SLURM" not in os.environ or bool(MISSING) or os.geteuid() != 0 or SLURM.exists(),
    reason="needs DRILLID_TEST_SLURM in the environment, as it takes minutes, root, "
    "the packages slurmctld, slurmd, slurm-client and munge, and a machine of no other cluster",
)

CONFIGURATION = """
ClusterName=local
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmdPort={node_port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
SlurmUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/controller.pid
SlurmdPidFile={folder}/node.pid
SlurmctldLogFile={folder}/controller.log
SlurmdLogFile={folder}/node.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SlurmdParameters=config_overrides
NodeName={host} NodeAddr=127.0.0.1 CPUs=4 RealMemory=16000 State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def slurm(tmp_path: Path) -> Iterator[dict[str, str]]:
    """Environment of a running cluster; its daemons end with the test."""
    folder = tmp_path / "slurm"
    for name in ("state", "spool"):
        (folder / name).mkdir(parents=True)
    folder.chmod(0o755)
    key = folder / "munge.key"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o400)
    SLURM.parent.mkdir(exist_ok=True)
    SLURM.write_text(
        CONFIGURATION.format(
            host=socket.gethostname().split(".")[0], folder=folder, port=free_port(), node_port=free_port()
        )
    )
    environment = os.environ | {"PATH": os.environ["PATH"] + ":/usr/sbin"}
    commands = (
        [
            *("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket"),
            *(f"--pid-file={folder}/munge.pid", f"--log-file={folder}/munge.log", f"--seed-file={folder}/munge.seed"),
        ],
        ["slurmctld", "-D"],
        ["slurmd", "-D"],
    )
    daemons = []
    with (folder / "daemons.log").open("w") as log:
        try:
            for command in commands:
                daemons.append(subprocess.Popen(command, env=environment, stdout=log, stderr=log))
                time.sleep(1)
            until = time.monotonic() + 30
            while "idle" not in _output(["sinfo"], environment):
                assert time.monotonic() < until, "".join(path.read_text() for path in folder.glob("*.log"))
                time.sleep(0.5)
            yield environment
        finally:
            for daemon in reversed(daemons):
                daemon.terminate()
                daemon.wait(timeout=20)
            SLURM.unlink()


def _output(command: list[str], environment: dict[str, str]) -> str:
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False).stdout


def test_wells_go_through_the_cluster_by_the_profile_alone(checkout: Checkout, slurm: dict[str, str]) -> None:
    """The profile of the repository, without its account and partition, which this cluster does not have."""
    checkout.sheets({"W1": ["a.csv"], "W-2": ["b.csv"], "W3": ["bad.csv"]})
    (checkout.root / "raw/bad.csv").write_text("bad")
    profile = checkout.root / "workflow/profiles/cluster/config.yaml"
    dropped = ("slurm_account", "latency")
    kept = [line for line in profile.read_text().splitlines() if not line.strip().startswith(dropped)]
    # this cluster has no accounting, and its jobs take no time
    added = [
        "latency-wait: 20",
        "seconds-between-status-checks: 2",
        "slurm-init-seconds-before-status-checks: 2",
        "slurm-no-account: true",
    ]
    profile.write_text("\n".join([*kept, *added, "slurm-status-command: squeue", ""]))
    done = subprocess.run(
        [sys.executable, "-m", "drillid", "run", "--profile", "workflow/profiles/cluster", "--jobs", "4"],
        cwd=checkout.root,
        env=slurm | {"PYTHONPATH": str(checkout.root)},
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    assert done.returncode == 3, done.stdout + done.stderr
    assert "1 of 3 wells failed: W3" in done.stderr
    assert sum(line.startswith("records") for line in checkout.journal()) == 3
    assert (checkout.root / "results/main/report.html").exists()
