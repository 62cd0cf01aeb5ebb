"""Jobs run on Kubernetes, sharing a volume with Snakemake itself.

Snakemake's executor for Kubernetes assumes that nothing is shared, and copies declared outputs through a store. Here
the wells' folders are on a volume that all pods mount, as the stages rename whole folders and lock files.
"""

import shlex
from dataclasses import replace

import snakemake_executor_plugin_kubernetes as kubernetes
from snakemake_interface_executor_plugins.jobs import JobExecutorInterface

ExecutorSettings = kubernetes.ExecutorSettings
common_settings = replace(
    kubernetes.common_settings,
    implies_no_shared_fs=False,
    job_deploy_sources=False,
    pass_default_storage_provider_args=False,
    auto_deploy_default_storage_provider=False,
)


class Executor(kubernetes.Executor):
    """Starts each job in the folder of the run."""

    def get_job_exec_prefix(self, job: JobExecutorInterface) -> str:
        """Shell command that enters the folder of the run, which lies on the volume."""
        return f"cd {shlex.quote(self.workflow.workdir_init)}"
