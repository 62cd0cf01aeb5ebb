"""What was learnt becomes a module of the catalogue, whose cause at size one is the extension and at zero nothing."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import drillid.discrepancy.catalogue
from drillid.commands import app
from drillid.discrepancy.catalogue import Cause, OperatingPoint, WindowModel
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.learning.elements import TERMS
from drillid.discrepancy.learning.promotion import module_source
from drillid.errors import SettingsError
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive
from drillid.physics.gaussian_process import COUNT
from drillid.physics.responses import laplace
from drillid.physics.sensor import Recording

S = laplace(np.geomspace(0.05, 4.0, 40))
POINT = OperatingPoint(*(np.array([[value]]) for value in (10.0, 5e3, 2000.0)))
MOUNTED = {"mount_inertia": (0.5, 20.0), "mount_frequency": (0.0, 1.5), "mount_loss": (0.0, 0.3)}
PROCESS = {f"drive_process_{number}": (40.0, 0.3 * (-1) ** number) for number in range(COUNT)}


def model() -> WindowModel:
    pipe = Section(POINT.length, 1.6e-5, 100.0, 3e8)
    return WindowModel(
        DrillingSystem(TopDrive(1000.0, 0.03, Controller(1500.0, 800.0)), (pipe,), Bit(50.0, 60.0)), Recording()
    )


def loaded(path: Path) -> Cause:
    spec = importlib.util.spec_from_file_location("promoted", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (cause,) = module.CAUSES
    found: Cause = cause()
    return found


@pytest.mark.parametrize(("learnt", "family"), [(MOUNTED, "string"), (PROCESS, "drive")])
def test_the_generated_cause_is_what_was_learnt(
    tmp_path: Path, learnt: dict[str, tuple[float, float]], family: str
) -> None:
    names, values = list(learnt), list(learnt.values())
    dataset = xr.Dataset(
        {
            "extension_set": ("extension", np.zeros(len(names), dtype=int)),
            "extension_cause": ("extension", np.array(names, dtype=object)),
            "extension_shape": ("extension", [shape for shape, _ in values]),
            "extension_size": ("extension", [size for _, size in values]),
        }
    )
    dataset.to_zarr(tmp_path / "examination.zarr", consolidated=False, zarr_format=3)
    path = tmp_path / "shaker.py"
    result = CliRunner().invoke(app, ["promote", str(tmp_path / "examination.zarr"), "shaker", "--output", str(path)])
    assert result.exit_code == 0, result.output
    cause, extended = loaded(path), model()
    for name, (shape, size) in learnt.items():
        extended = TERMS[name].extend(extended, size, shape, POINT)
    np.testing.assert_allclose(cause.extend(model(), 1.0, 0.0, POINT).mobility(S), extended.mobility(S))
    np.testing.assert_allclose(cause.extend(model(), 0.0, 0.0, POINT).mobility(S), model().mobility(S))
    assert cause.name == "shaker"
    assert cause.family == family
    assert cause.is_linear


@pytest.mark.parametrize("name", ["true", "none_", "_1"])
def test_a_name_whose_class_would_be_no_python_is_refused(name: str) -> None:
    with pytest.raises(SettingsError, match="cannot name a cause"):
        module_source(name, [Extension(TERMS["learnt_inertia"], 0.5)], np.array([30.0]), "W1")


def test_what_is_no_examination_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    xr.Dataset({"kappa": ("window", np.ones(2))}).to_zarr(tmp_path / "fits.zarr", consolidated=False, zarr_format=3)
    for folder in ("absent", "empty", "fits.zarr"):
        result = CliRunner().invoke(app, ["promote", str(tmp_path / folder), "shaker", "--output", str(tmp_path / "o")])
        assert result.exit_code == 1
        assert "Give the examination.zarr of a well" in result.output
        assert isinstance(result.exception, SystemExit)


def test_the_module_joins_the_catalogue_without_a_circle(tmp_path: Path) -> None:
    package = Path(drillid.discrepancy.catalogue.__file__)
    shutil.copytree(package.parents[2], tmp_path / "drillid", ignore=shutil.ignore_patterns("__pycache__"))
    source = module_source("soft_joint", [Extension(TERMS["learnt_joint"], 0.5)], np.array([1e-5]), "a well")
    catalogue = tmp_path / "drillid/discrepancy/catalogue"
    (catalogue / "soft_joint.py").write_text(source)
    text = (catalogue / "__init__.py").read_text()
    for before, after in (
        ("import bit, sensor", "import bit, sensor, soft_joint"),
        ("string, bit, time)", "string, bit, time, soft_joint)"),
    ):
        assert before in text
        text = text.replace(before, after)
    (catalogue / "__init__.py").write_text(text)
    told = subprocess.run(
        [sys.executable, "-c", "from drillid.discrepancy import CATALOGUE; print(CATALOGUE['soft_joint'].name)"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert told.stdout.strip() == "soft_joint", told.stderr


def test_a_name_that_is_none_and_a_set_without_anything_learnt_are_refused() -> None:
    extension = Extension(TERMS["learnt_joint"], 0.5)
    for name in ("Soft Joint", "class", "_"):
        with pytest.raises(SettingsError, match="cannot name"):
            module_source(name, [extension], np.array([1e-5]), "a well")
    for name in ("drive_lag", "unknown"):
        with pytest.raises(SettingsError, match=f"'{name}' is a verdict already"):
            module_source(name, [extension], np.array([1e-5]), "a well")
    with pytest.raises(SettingsError, match="no learnt extension"):
        module_source("soft_joint", [], np.empty(0), "a well")
