"""Every module that is run by `python -m` describes itself and its options."""

import ast
import runpy
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def command_modules() -> list[str]:
    """Import names of all modules of benchmarks and scripts that end in a command; rules run the other scripts."""
    files = [path for folder in ("benchmarks", "scripts") for path in sorted((ROOT / folder).rglob("*.py"))]
    names = [path.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".") for path in files if is_command(path)]
    return [name.removesuffix(".__main__") for name in names]


def is_command(path: Path) -> bool:
    """Whether a file does something when it is run, and no rule of the workflow runs it."""
    text = path.read_text()
    return 'if __name__ == "__main__"' in text and not takes_a_job(text)


def takes_a_job(text: str) -> bool:
    """Whether a script uses the name under which Snakemake hands it its job."""
    return any(isinstance(node, ast.Name) and node.id == "snakemake" for node in ast.walk(ast.parse(text)))


@pytest.mark.parametrize("name", command_modules())
def test_a_command_explains_itself(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", [name, "--help"])
    for loaded in (name, f"{name}.__main__"):
        monkeypatch.delitem(sys.modules, loaded, raising=False)
    with pytest.raises(SystemExit) as end:
        runpy.run_module(name, run_name="__main__", alter_sys=True)
    assert end.value.code == 0
    said = capsys.readouterr().out
    assert "Usage:" in said
    described = [line.strip(" │*") for line in said.splitlines() if "--" in line and "Options" not in line]
    assert all(len(line.split()) > 2 for line in described), said


def test_those_that_readme_and_makefile_name_are_commands() -> None:
    assert {"benchmarks.blind", "benchmarks.discoveries", "benchmarks.field.start_up", "scripts.write_tutorial"} <= set(
        command_modules()
    )
