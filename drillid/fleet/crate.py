"""The run as an RO-Crate, `<results>/ro-crate-metadata.json`: which workflow made which results from which inputs.

It follows RO-Crate 1.1 (Sefton et al., https://w3id.org/ro/crate/1.1) and the profile Workflow Run Crate 0.5
(Leo et al., PLoS ONE 19, 2024, https://w3id.org/ro/wfrun/workflow/0.5).
"""

from __future__ import annotations

import datetime
import itertools
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import drillid
from drillid.config.sheets import read_sheets, read_start_ups
from drillid.datasets.store import WellFolders
from drillid.errors import SettingsError
from drillid.fleet.explain import inputs_behind, inputs_of
from drillid.fleet.manifest import KEY, stored, write_whole
from drillid.fleet.provenance import numerical_versions
from drillid.fleet.stages import STAGES, START_UPS

if TYPE_CHECKING:
    from drillid.config.settings import Settings

CRATE = "ro-crate-metadata.json"
TABLES = {
    "report.html": "the fleet's report",
    "problems.csv": "whatever was rejected, with its remedy",
    "verdicts.csv": "what the simulation gets wrong",
    "learnt.csv": "what was learnt where no cause explains the data",
    "changes.csv": "what is new since the last report",
    "common_causes.csv": "what wells of a rig, a hole section or a tool have in common",
    "well_standings.csv": "each well compared with the others",
    "fleet.zarr/": "the parameters of all wells",
}
"""Results over all wells and what they hold."""
_PROFILES = (
    "https://w3id.org/ro/wfrun/process/0.5",
    "https://w3id.org/ro/wfrun/workflow/0.5",
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0",
)

_CONFIGURATION = "#configuration"

Entity = dict[str, Any]


def settings_of(results: Path) -> Settings:
    """Settings with which the results in a folder were made; paths of sheets are where the run found them.

    Raises
    ------
    SettingsError
        If the folder has no description of a run, or one of another version.
    """
    from drillid.config.settings import Settings

    path = results / CRATE
    try:
        content = json.loads(path.read_bytes())["@graph"]
        (text,) = (entity["value"] for entity in content if entity["@id"] == _CONFIGURATION)
        stated = json.loads(text)
    except (OSError, ValueError, KeyError, TypeError) as error:
        remedy = "Name the configuration of the run instead"
        raise SettingsError(str(results), f"holds no results of a finished run ({error})", remedy) from None
    return Settings.checked({**stated, "results": str(results)}, str(path))


def write_crate(settings: Settings, results: Path, wells: Sequence[str], workflow: Path) -> None:
    """Describe the run beside its results; dates differ from run to run, everything else follows from the inputs.

    Parameters
    ----------
    results : folder of the results, which becomes the crate
    wells : folders of the wells
    workflow : the Snakefile

    Raises
    ------
    SettingsError
        If a sheet cannot be read.
    """
    listings, start_ups = read_sheets(settings), read_start_ups(settings)
    sheets = [settings.wells, settings.logs, *filter(None, [settings.start_up_sheet])]
    behind = {path: digest for path, (_, digest) in inputs_of(list(map(Path, sheets))).items()}
    made = [{"@id": name, "@type": _kind(name), "name": meaning} for name, meaning in TABLES.items()]
    for well in wells:
        folders = WellFolders(results, well)
        behind |= inputs_behind(folders)
        made += _of_well(f"the well {listings[well].name}", folders, STAGES)
    for start_up, listing in start_ups.items():
        folders = WellFolders(results, start_up)
        behind |= inputs_behind(folders, START_UPS.name)
        made += _of_well(f"the start of rotation {listing.name}", folders, [START_UPS.name])
    inputs = {entity["@id"]: entity for entity in itertools.starmap(_file, behind.items())}
    content = [*_crate(settings, results, workflow, list(inputs.values()), made), *inputs.values(), *made]
    context = "https://w3id.org/ro/crate/1.1/context"
    write_whole(results / CRATE, json.dumps({"@context": context, "@graph": content}, indent=1, ensure_ascii=False))


def _crate(settings: Settings, results: Path, workflow: Path, inputs: list[Entity], made: list[Entity]) -> list[Entity]:
    """Descriptor, root, workflow with its requirements, and the run itself."""
    packages = {"drillid": drillid.__version__, **numerical_versions()}
    needed = [
        {"@id": f"#{name}", "@type": "SoftwareApplication", "name": name, "softwareVersion": version}
        for name, version in packages.items()
    ]
    keys = [path.stat().st_mtime for path in results.glob(f"*/*/{KEY}")]
    main, configuration = workflow.resolve().as_uri(), _CONFIGURATION
    return [
        {
            "@id": CRATE,
            "@type": "CreativeWork",
            "about": {"@id": "./"},
            "conformsTo": _references("https://w3id.org/ro/crate/1.1", _PROFILES[-1]),
        },
        {
            "@id": "./",
            "@type": "Dataset",
            "name": settings.report.title,
            "description": "Torsional dynamics identified while drilling, by the workflow drillid",
            "datePublished": _time(max(keys, default=0.0)),
            "license": "The data's owner decides who may use these results",
            "conformsTo": _references(*_PROFILES),
            "mainEntity": {"@id": main},
            "hasPart": _references(main, *(entity["@id"] for entity in [*inputs, *made])),
            "mentions": {"@id": "#run"},
        },
        *({"@id": profile, "@type": "CreativeWork", "name": profile.split("/")[-2]} for profile in _PROFILES),
        {
            "@id": main,
            "@type": ["File", "SoftwareSourceCode", "ComputationalWorkflow"],
            "name": "drillid",
            "programmingLanguage": {"@id": "#snakemake"},
            "softwareRequirements": _references(*(entity["@id"] for entity in needed)),
        },
        {
            "@id": "#snakemake",
            "@type": "ComputerLanguage",
            "name": "Snakemake",
            "url": "https://snakemake.readthedocs.io",
        },
        *needed,
        {
            "@id": configuration,
            "@type": "PropertyValue",
            "name": "configuration",
            "value": json.dumps(settings.model_dump(mode="json", exclude={"fleet"}), sort_keys=True),
        },
        {
            "@id": "#run",
            "@type": "CreateAction",
            "name": f"Run of drillid {drillid.__version__}",
            "instrument": {"@id": main},
            "startTime": _time(min(keys, default=0.0)),
            "endTime": _time(max(keys, default=0.0)),
            "object": _references(configuration, *(entity["@id"] for entity in inputs)),
            "result": _references(*(entity["@id"] for entity in made)),
        },
    ]


def _of_well(called: str, folders: WellFolders, stages: Iterable[str]) -> list[Entity]:
    """The folder of a well, or start of rotation, of each stage, with the keys of what it was made from."""
    keys = {stage: stored(folders.stage(stage)) for stage in stages}
    return [
        {
            "@id": f"{stage}/{folders.well}/",
            "@type": "Dataset",
            "name": f"{stage} of {called}",
            "identifier": key["key"],
            "version": key["source"],
        }
        for stage, key in keys.items()
        if key
    ]


def _file(path: str, digest: str) -> Entity:
    name = path if "://" in path else Path(path).absolute().as_uri()
    return {"@id": name, "@type": "File", "name": path.rpartition("/")[2], "sha256": digest}


def _kind(name: str) -> str:
    return "Dataset" if name.endswith("/") else "File"


def _references(*names: str) -> list[dict[str, str]]:
    return [{"@id": name} for name in names]


def _time(seconds: float) -> str:
    return datetime.datetime.fromtimestamp(seconds, datetime.UTC).isoformat(timespec="seconds")
