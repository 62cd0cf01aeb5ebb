"""What dask's workers on a cluster are asked for, and what is said where there is none."""

import subprocess
from pathlib import Path
from typing import Any

import pytest
from kubernetes import client as kubernetes

from drillid.config.settings import FleetSettings, KubernetesWorkers, Settings, SlurmWorkers
from drillid.errors import SettingsError
from drillid.fleet import workers
from drillid.fleet.provenance import PACKAGE
from drillid.fleet.workers import client_of, kubernetes_specification, slurm_options

SLURM = {"jobs": 3, "processes": 4, "memory_mb": 8000, "runtime": 150, "partition": "main", "account": "drilling"}


def fleet(**scheduler: Any) -> FleetSettings:
    return Settings.checked({"fleet": {"scheduler": scheduler}}, "config.yaml").fleet


def test_a_job_of_slurm_asks_for_what_the_settings_say(tmp_path: Path) -> None:
    from dask_jobqueue import SLURMCluster

    with SLURMCluster(**slurm_options(SlurmWorkers(**SLURM, directives=("--qos=long",)))) as cluster:
        script = cluster.job_script()
    directives = {line.removeprefix("#SBATCH ") for line in script.splitlines() if line.startswith("#SBATCH")}
    assert directives == {
        *("-J drillid", "-p main", "-A drilling", "-n 1", "--cpus-per-task=4", "--mem=8G", "-t 02:30:00", "--qos=long")
    }
    command = script.splitlines()[-1]
    assert "--nthreads 1 " in command
    assert "--nworkers 4 " in command
    assert f"export PYTHONPATH='{PACKAGE.parent}'" in script
    (tmp_path / "job.sh").write_text(script)
    subprocess.run(["bash", "-n", str(tmp_path / "job.sh")], check=True)


def as_kubernetes_reads(part: Any, kind: str) -> Any:
    """An object as Kubernetes' own client understands it: keys that it does not know are lost."""
    api = kubernetes.ApiClient()
    return api.sanitize_for_serialization(api._ApiClient__deserialize(part, kind))


def test_the_pods_of_kubernetes_are_valid_and_mount_the_volumes() -> None:
    settings = KubernetesWorkers(workers=8, memory_mb=3000, volumes={"drilling": "/data"})
    found = kubernetes_specification(settings, 5, "drillid-1")
    assert found["spec"]["worker"]["replicas"] == 5
    for part in ("scheduler", "worker"):
        pod = found["spec"][part]["spec"]
        assert as_kubernetes_reads(pod, "V1PodSpec") == pod
        assert pod["volumes"] == [{"name": "drilling", "persistentVolumeClaim": {"claimName": "drilling"}}]
        (container,) = pod["containers"]
        assert container["volumeMounts"] == [{"name": "drilling", "mountPath": "/data"}]
        assert container["resources"]["limits"] == {"memory": "3000M", "cpu": "1"}
        assert {"name": "OPENBLAS_NUM_THREADS", "value": "1"} in container["env"]
    assert found["spec"]["worker"]["spec"]["containers"][0]["args"][:3] == ["dask-worker", "--nthreads", "1"]


@pytest.mark.parametrize(
    ("scheduler", "package"),
    [({"slurm": SLURM}, "dask-jobqueue"), ({"kubernetes": {"workers": 2}}, "dask-kubernetes")],
)
def test_a_package_that_is_not_installed_is_named(
    scheduler: dict[str, Any], package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(workers.importlib, "import_module", missing)
    remedy = r"Install it: pip install 'drillid\[cluster\]'"
    with pytest.raises(SettingsError, match=f"{package} is not installed. {remedy}"):
        client_of(fleet(**scheduler), 2).__enter__()


def test_slurm_is_asked_for_where_there_is_none(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SettingsError, match="there is no sbatch here"):
        client_of(fleet(slurm=SLURM), 2).__enter__()


@pytest.mark.parametrize("scheduler", [{}, {"address": "tcp://host:8786", "slurm": SLURM}])
def test_a_scheduler_is_one_thing(scheduler: dict[str, Any]) -> None:
    with pytest.raises(SettingsError, match=r"'fleet\.scheduler': gives") as error:
        fleet(**scheduler)
    assert "address of a scheduler" in error.value.remedy
