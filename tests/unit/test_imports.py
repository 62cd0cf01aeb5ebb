"""Importing the library costs no more than a stage needs."""

import pkgutil
import subprocess
import sys

import drillid
from drillid.fleet.provenance import PACKAGE

DRAWING = ("drillid.figures", "drillid.report")
MODULES = sorted(module.name for module in pkgutil.walk_packages(drillid.__path__, "drillid."))


def test_importing_the_library_does_not_import_what_only_some_stages_need() -> None:
    modules = [module for module in MODULES if not module.startswith(DRAWING)]
    code = f"import importlib, sys\nfor name in {modules!r}: importlib.import_module(name)\n"
    code += "print(' '.join(sorted({'matplotlib', 'distributed', 'snakemake', 'jinja2'} & sys.modules.keys())))"
    done = subprocess.run([sys.executable, "-c", code], cwd=PACKAGE.parent, capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_the_package_itself_is_imported_in_less_than_half_a_second() -> None:
    code = "import time; before = time.process_time(); import drillid; print(time.process_time() - before)"
    done = subprocess.run([sys.executable, "-c", code], cwd=PACKAGE.parent, capture_output=True, text=True, check=True)
    assert float(done.stdout) < 0.5
