"""The dask workers of a job: of this machine, of a running scheduler, or started on a cluster for the job."""

from __future__ import annotations

import contextlib
import importlib
import os
import shutil
import uuid
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from drillid.config.settings import FleetSettings, KubernetesWorkers, SlurmWorkers
from drillid.errors import SettingsError
from drillid.fleet.provenance import PACKAGE

if TYPE_CHECKING:
    from distributed import Client

THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_IDLE_S = 600
"""Time after which dask's operator removes the pods of a killed job."""


@contextlib.contextmanager
def client_of(fleet: FleetSettings, tasks: int) -> Iterator[Client]:
    """A client whose workers take these tasks, each one at a time; whatever was started for it ends with it.

    Parameters
    ----------
    fleet : where the workers are
    tasks : number of tasks, beyond which no workers are started

    Raises
    ------
    SettingsError
        If a scheduler does not answer, a cluster refuses workers, or a package for it is not installed.
    """
    from distributed import Client

    scheduler = fleet.scheduler
    if scheduler is not None and scheduler.address is not None:
        with _connected(scheduler.address) as client:
            yield client
        return
    if scheduler is not None and scheduler.slurm is not None:
        cluster = _on_slurm(scheduler.slurm, tasks)
    elif scheduler is not None and scheduler.kubernetes is not None:
        cluster = _on_kubernetes(scheduler.kubernetes, tasks)
    else:
        cluster = _on_this_machine(min(fleet.processes, tasks))
    with cluster, Client(cluster) as client:
        yield client


def _connected(address: str) -> Client:
    from distributed import Client

    try:
        return Client(address)
    except (OSError, TimeoutError, ValueError) as error:
        what = f"no dask scheduler answers at {address} ({error})"
        raise SettingsError("fleet.scheduler", what, "Start it, or correct the address") from error


def _on_this_machine(processes: int) -> Any:
    from distributed import LocalCluster

    return LocalCluster(n_workers=processes, threads_per_worker=1, memory_limit=0, dashboard_address=None)


def _on_slurm(workers: SlurmWorkers, tasks: int) -> Any:
    place = "fleet.scheduler.slurm"
    jobqueue = _imported("dask_jobqueue", place)
    if shutil.which("sbatch") is None:
        raise SettingsError(place, "there is no sbatch here", "Run on a machine that submits jobs to Slurm")
    cluster = jobqueue.SLURMCluster(**slurm_options(workers))
    cluster.scale(jobs=min(workers.jobs, -(-tasks // workers.processes)))
    try:
        cluster.sync(_submitted, cluster)
    except (OSError, RuntimeError, ValueError) as error:
        with contextlib.suppress(AssertionError):  # an error of dask, which expects every job to have been submitted
            cluster.close()
        said = " ".join(str(error).split())
        raise SettingsError(place, f"Slurm refuses the workers' jobs ({said})", "Correct the keys there") from error
    return cluster


async def _submitted(cluster: Any) -> None:
    """Wait until all jobs are submitted; otherwise that happens in the background, with its errors unseen."""
    await cluster
    for job in cluster.workers.values():
        await job


def slurm_options(workers: SlurmWorkers) -> dict[str, Any]:
    """Arguments of `dask_jobqueue.SLURMCluster`."""
    hours, minutes = divmod(workers.runtime, 60)
    environment = worker_environment() | {"NUMBA_CACHE_DIR": os.environ.get("NUMBA_CACHE_DIR", "")}
    return {
        "cores": workers.processes,
        "processes": workers.processes,
        "memory": f"{workers.memory_mb}MB",
        "walltime": f"{hours:02d}:{minutes:02d}:00",
        "queue": workers.partition,
        "account": workers.account,
        "interface": workers.interface,
        "job_extra_directives": list(workers.directives),
        "job_name": "drillid",
        "job_script_prologue": [f"export {name}='{value}'" for name, value in environment.items() if value],
        "worker_extra_args": ["--no-dashboard"],
        "scheduler_options": {"dashboard_address": None},
    }


def _on_kubernetes(workers: KubernetesWorkers, tasks: int) -> Any:
    place = "fleet.scheduler.kubernetes"
    operator = _imported("dask_kubernetes.operator", place)
    specification = kubernetes_specification(workers, min(workers.workers, tasks), f"drillid-{uuid.uuid4().hex[:8]}")
    try:
        return operator.KubeCluster(custom_cluster_spec=specification, namespace=workers.namespace, quiet=True)
    except Exception as error:  # its packages raise errors of their own
        said = " ".join(str(error).split())
        remedy = "Check kubectl's context and dask's operator, then run again"
        raise SettingsError(place, f"Kubernetes did not start any workers ({said})", remedy) from error


def kubernetes_specification(workers: KubernetesWorkers, pods: int, name: str) -> dict[str, Any]:
    """The DaskCluster resource of dask's operator: a scheduler and a number of workers, which mount the volumes."""
    operator = _imported("dask_kubernetes.operator", "fleet.scheduler.kubernetes")
    amount = {"memory": f"{workers.memory_mb}M", "cpu": "1"}
    specification: dict[str, Any] = operator.make_cluster_spec(
        name,
        image=workers.image,
        n_workers=pods,
        resources={"requests": amount, "limits": amount},
        env=worker_environment(),
        worker_command="dask-worker --nthreads 1 --memory-limit 0",
        idle_timeout=_IDLE_S,
    )
    volumes = [{"name": claim, "persistentVolumeClaim": {"claimName": claim}} for claim in workers.volumes]
    mounts = [{"name": claim, "mountPath": path} for claim, path in workers.volumes.items()]
    for part in ("scheduler", "worker"):
        pod = specification["spec"][part]["spec"]
        pod["volumes"] = volumes
        for container in pod["containers"]:
            container["volumeMounts"] = mounts
    return specification


def worker_environment() -> dict[str, str]:
    """Variables by which a worker finds this checkout's library, at the same path, and uses one thread."""
    return {"PYTHONPATH": str(PACKAGE.parent), **dict.fromkeys(THREAD_VARIABLES, "1")}


def _imported(module: str, place: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0].replace("_", "-")
        raise SettingsError(
            place, f"{package} is not installed", "Install it: pip install 'drillid[cluster]'"
        ) from error
