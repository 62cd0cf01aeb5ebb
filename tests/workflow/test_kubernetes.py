"""The profile for Kubernetes: the manifests that it submits, which a stand-in for its API checks and carries out."""

import json
import subprocess
import sys
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
import yaml
from kubernetes import client as kubernetes

from tests.workflow import killed
from tests.workflow.toys import ROOT, Checkout

PROFILE = ROOT / "workflow/profiles/kubernetes"


def as_kubernetes_reads(manifest: Any, kind: str) -> Any:
    """A manifest as Kubernetes' own client understands it: keys that it does not know are lost, needed ones missed."""
    api = kubernetes.ApiClient()
    return api.sanitize_for_serialization(api._ApiClient__deserialize(manifest, kind))


class Cluster(ThreadingHTTPServer):
    """Takes jobs as Kubernetes' API does, and runs each one's command on this machine."""

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Api)
        self.jobs: dict[str, dict[str, Any]] = {}
        self.ended: dict[str, int] = {}

    def start(self, job: dict[str, Any]) -> None:
        """Run a job's command as its pod would, in the background."""
        name = job["metadata"]["name"]
        self.jobs[name] = job
        (container,) = job["spec"]["template"]["spec"]["containers"]

        def carry_out() -> None:
            environment = {"PATH": f"{Path(sys.executable).parent}:/usr/bin:/bin"}
            command = [*container["command"], *container["args"]]
            done = subprocess.run(command, cwd="/", env=environment, capture_output=True, text=True, check=False)
            self.ended[name] = done.returncode

        threading.Thread(target=carry_out, daemon=True).start()

    def status(self, name: str) -> dict[str, int]:
        """State of a job."""
        if name not in self.ended:
            return {"active": 1}
        return {"failed": 1} if self.ended[name] else {"succeeded": 1}


class _Api(BaseHTTPRequestHandler):
    """What the executor asks of Kubernetes' API."""

    server: Cluster

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        if self.path == "/apis/batch/v1/namespaces/drillid/jobs":
            self.server.start(body)
        else:
            assert self.path == "/api/v1/namespaces/drillid/secrets"
        self.answer(body)

    def do_GET(self) -> None:
        if "/pods" in self.path:
            self.answer({"kind": "PodList", "items": []})
        else:
            name = self.path.split("/")[-2]
            self.answer({"metadata": {"name": name}, "status": self.server.status(name)})

    def do_DELETE(self) -> None:
        self.rfile.read(int(self.headers.get("Content-Length", 0)))
        self.answer({"kind": "Status", "status": "Success"})

    def answer(self, content: Any) -> None:
        text = json.dumps(content).encode()
        self.send_response(200)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(text)))
        self.end_headers()
        self.wfile.write(text)

    def log_message(self, format: str, *_: object) -> None:
        return


@pytest.fixture
def cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Cluster]:
    with Cluster() as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_port}"
        content = {
            "apiVersion": "v1",
            "kind": "Config",
            "current-context": "here",
            "contexts": [{"name": "here", "context": {"cluster": "here", "user": "me"}}],
            "clusters": [{"name": "here", "cluster": {"server": address}}],
            "users": [{"name": "me", "user": {}}],
        }
        (tmp_path / "kubeconfig").write_text(yaml.safe_dump(content))
        monkeypatch.setenv("KUBECONFIG", str(tmp_path / "kubeconfig"))
        yield server
        server.shutdown()


def test_the_profile_runs_each_job_in_a_pod_that_mounts_the_volume(checkout: Checkout, cluster: Cluster) -> None:
    checkout.sheets({"W1": ["a.csv"], "W-2": ["b.csv"]})
    profile = checkout.root / "workflow/profiles/kubernetes/config.yaml"
    profile.write_text(profile.read_text().replace("drilling:/data", f"drilling:{checkout.root}"))
    (checkout.root / "profile").symlink_to(profile.parent)
    # as a process of its own, which finds the profile's plugin when it loads Snakemake
    running = killed.started(checkout, "--until", "records", "--seconds-between-status-checks", "1")
    output, _ = running.communicate()
    assert running.returncode == 0, output
    assert sorted(checkout.journal()) == ["records W-2", "records W1"]
    assert len(cluster.jobs) == 1
    for job in cluster.jobs.values():
        assert as_kubernetes_reads(job, "V1Job") == job
        pod = job["spec"]["template"]["spec"]
        assert {"name": "drilling", "persistentVolumeClaim": {"claimName": "drilling"}} in pod["volumes"]
        (container,) = pod["containers"]
        assert container["image"] == "drillid"
        assert {"name": "drilling", "mountPath": str(checkout.root)} in container["volumeMounts"]
        # two wells: as many processes, with their memory
        assert container["resources"]["requests"]["cpu"] == "1900m"
        assert int(container["resources"]["requests"]["memory"].removesuffix("M")) >= 2000


KINDS = {"Job": "V1Job", "ServiceAccount": "V1ServiceAccount", "Role": "V1Role", "RoleBinding": "V1RoleBinding"}


def test_the_run_itself_is_a_job_with_the_rights_that_it_needs() -> None:
    manifests = {manifest["kind"]: manifest for manifest in yaml.safe_load_all((PROFILE / "run.yaml").read_text())}
    assert manifests.keys() == KINDS.keys()
    for kind, manifest in manifests.items():
        assert as_kubernetes_reads(manifest, KINDS[kind]) == manifest
    pod = manifests["Job"]["spec"]["template"]["spec"]
    profile = yaml.safe_load((PROFILE / "config.yaml").read_text())
    (container,) = pod["containers"]
    assert container["image"] == profile["container-image"]
    (mount,) = container["volumeMounts"]
    assert f"{mount['name']}:{mount['mountPath']}" == profile["kubernetes-volume-persistent-volumes"]
    assert pod["serviceAccountName"] == manifests["ServiceAccount"]["metadata"]["name"]
