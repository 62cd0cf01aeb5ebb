"""The Dockerfile's steps, carried out as a script in a folder; what they would download is stood in for.

With DRILLID_TEST_IMAGE in the environment, packages and kernels are installed for real, which takes minutes.
"""

import fnmatch
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.workflow.toys import ROOT

FOR_REAL = "DRILLID_TEST_IMAGE" in os.environ
PYTHON3 = f"""#!/bin/sh
# python3 -m venv FOLDER
mkdir -p "$3/bin"
cat > "$3/bin/python" <<'END'
#!/bin/sh
case "$2" in
  pip) printf '#!/bin/sh\\nexit 0\\n' > "$(dirname "$0")/uv"; chmod 755 "$(dirname "$0")/uv" ;;
  scripts.compile_kernels) ;;
  *) exec "{sys.executable}" "$@" ;;
esac
END
chmod 755 "$3/bin/python"
"""


def instructions() -> list[tuple[str, str]]:
    text = re.sub(r"\\\n", " ", (ROOT / "Dockerfile").read_text())
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return [(word, rest) for word, _, rest in (line.partition(" ") for line in lines)]


def copied(sources: list[str], target: Path) -> None:
    """What COPY copies of the files under version control."""
    kept = [re.sub(r"^\*\*/", "", line) for line in (ROOT / ".dockerignore").read_text().split()]
    files = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    for name in filter(None, files):
        ignored = any(fnmatch.fnmatch(part, pattern) for part in name.split("/")[:1] for pattern in kept)
        if not ignored and (sources == ["."] or name in sources) and (ROOT / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target / name)


@pytest.fixture(scope="module")
def image(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, str]]:
    """Root of the image and the environment of its commands."""
    root = tmp_path_factory.mktemp("image")
    stubs = root / "stubs"
    stubs.mkdir()
    for name, text in {"apt-get": "#!/bin/sh\n", **({} if FOR_REAL else {"python3": PYTHON3})}.items():
        (stubs / name).write_text(text)
        (stubs / name).chmod(0o755)
    environment = {"PATH": f"{stubs}:{os.environ['PATH']}", "HOME": os.environ["HOME"]}
    folder = root
    for instruction, rest in instructions():
        if instruction == "WORKDIR":
            folder = root / rest.lstrip("/")
            folder.mkdir(parents=True)
        elif instruction == "COPY":
            *sources, target = rest.split()
            copied(sources, folder / target)
        elif instruction == "RUN":
            # paths of the image are below its root
            command = re.sub(r"(?<=\s)/(?=var/)", f"{root}/", rest)
            done = subprocess.run(
                ["sh", "-c", command], cwd=folder, env=environment, capture_output=True, text=True, check=False
            )
            assert done.returncode == 0, done.stdout + done.stderr
        elif instruction == "ENV":
            name, _, value = rest.partition("=")
            environment[name] = value.replace("/opt/", f"{root}/opt/").replace("$PATH", environment[name])
        else:
            assert instruction in ("FROM", "CMD")
    return root, environment


def test_the_command_of_the_image_plans_a_run_in_another_folder(
    image: tuple[Path, dict[str, str]], tmp_path: Path
) -> None:
    root, environment = image
    (word, command) = instructions()[-1]
    assert (word, command) == ("CMD", '["drillid", "--help"]')
    assert shutil.which("drillid", path=environment["PATH"]) == str(root / "opt/drillid/.venv/bin/drillid")
    shutil.copytree(ROOT / "config", tmp_path / "config")
    done = subprocess.run(
        ["drillid", "run", "--dry-run", "--configfile", "config/demo/config.yaml"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    output = done.stdout + done.stderr
    assert done.returncode == 0, output
    assert re.search(r"^records +3$", output, re.MULTILINE)
    assert str(ROOT / "Snakefile") not in output
