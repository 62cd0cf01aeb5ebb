"""Imports go one way, and cost no more than a stage needs."""

import ast
import subprocess
import sys

import pytest

from drillid.provenance import PACKAGE, direct_imports

LAYERS = (
    ("errors", "child", "compiled"),
    ("units", "strict", "provenance", "declaration"),
    ("schema_windows",),
    ("schema_discrepancy",),
    ("config", "rig", "schema"),
    ("store", "sheets"),
    ("stages",),
    ("batches",),
    ("physics.dual",),
    ("physics.damping",),
    ("physics.equipment",),
    ("fit_model",),
    ("physics",),
    ("statistics",),
    ("formats",),
    ("clock", "grid", "quality", "repair"),
    ("records",),
    ("states", "stretches"),
    ("windows",),
    ("cross_spectra", "lattice", "noise"),
    ("periodic", "local_polynomial", "channel_offset", "passive", "distortion_levels"),
    ("spectra",),
    ("mobility",),
    ("fit_solver", "fit_search"),
    ("fit_intervals",),
    ("starts",),
    ("estimation",),
    ("smoother",),
    ("joint_coordinates",),
    ("change_points",),
    ("joint_likelihood",),
    ("joint",),
    ("joint_stream",),
    ("joint_dataset",),
    ("fits",),
    ("discrepancy",),
    ("depth",),
    ("display", "figures_style", "figures_data"),
    ("figures_windows", "figures_joint", "figures_depth", "figures_tracks", "figures_verdicts", "figures_prediction"),
    ("figures",),
    ("report", "report_content", "report_verdicts"),
    ("bit_sensor",),
    ("excitation",),
    ("excitation_design", "distortion"),
    ("simulate_parts",),
    ("simulate_drive", "simulate_friction", "simulate_memory"),
    ("simulate_kernel", "simulate_grid", "simulate_start"),
    ("simulate",),
    ("field_well",),
    ("field_files",),
    ("field_log",),
    ("margins",),
    ("control",),
    ("stick_slip",),
    ("figures_control",),
    ("recorder", "operations"),
    ("demo_recorder",),
    ("demo",),
    ("fleet",),
    ("docs", "literate"),
    ("command_line",),
    ("__main__",),
)
"""From the bottom up; a package stands for all its modules, and modules of one layer may use each other."""

MODULES = sorted(
    ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__")
    for path in PACKAGE.rglob("*.py")
    if path.parent != PACKAGE or path.stem != "__init__"
)
DRAWING = ("figures", "report", "display")


def layer(module: str) -> int:
    """Number of the most specific layer that names the module."""
    places = {name: number for number, names in enumerate(LAYERS) for name in names}
    found = [name for name in places if module == name or module.startswith(f"{name}.")]
    if not found:
        pytest.fail(f"drillid.{module} has no layer: place it in LAYERS of this test")
    return places[max(found, key=len)]


@pytest.mark.parametrize("module", MODULES)
def test_a_module_imports_only_from_its_layer_and_below(module: str) -> None:
    for name in direct_imports(f"drillid.{module}") - {"drillid"}:
        assert layer(name.removeprefix("drillid.")) <= layer(module), f"drillid.{module} must not import {name}"


@pytest.mark.parametrize("module", [module for module in MODULES if module != "fleet"])
def test_only_fleet_knows_dask_distributed(module: str) -> None:
    path = PACKAGE.joinpath(*module.split("."))
    text = (path.with_suffix(".py") if path.with_suffix(".py").is_file() else path / "__init__.py").read_text()
    for node in ast.walk(ast.parse(text)):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        assert not [name for name in names if name.split(".")[0] == "distributed"], f"drillid.{module}"


def test_importing_the_library_does_not_import_what_only_some_stages_need() -> None:
    modules = [module for module in MODULES if not module.startswith(DRAWING)]
    code = f"import importlib, sys\nfor name in {modules!r}: importlib.import_module('drillid.' + name)\n"
    code += "print(' '.join(sorted({'matplotlib', 'distributed', 'snakemake', 'jinja2'} & sys.modules.keys())))"
    done = subprocess.run([sys.executable, "-c", code], cwd=PACKAGE.parent, capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
