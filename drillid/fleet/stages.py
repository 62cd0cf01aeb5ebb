"""What every stage reads, as data: earlier datasets, sections of the settings, parts of the rig description."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from drillid.fleet.provenance import file_manifest, source_hash, yaml_digest

if TYPE_CHECKING:
    from drillid.config.listing import Listing
    from drillid.config.settings import Settings


@dataclass(frozen=True)
class Stage:
    """A processing step taken well by well; it is redone when anything named here changes."""

    name: str
    """Name of the stage and of its subpackage, rule, script, section of the settings and results folder."""
    reads: tuple[tuple[str, str], ...]
    """Datasets without which there is nothing to do, as (stage, dataset)."""
    settings: tuple[str, ...]
    """Sections of the settings, or one key of a section as `section.key`."""
    rig: tuple[str, ...]
    """Parts of the rig description; empty where it is not used."""

    @property
    def module(self) -> str:
        """Import name of the module that takes a well through the stage."""
        return f"drillid.{self.name}.stage"

    @property
    def sections(self) -> dict[str, set[str] | bool]:
        """Sections of the settings with the keys that count, or True if all do."""
        chosen: dict[str, set[str] | bool] = {}
        for section, _, key in (name.partition(".") for name in self.settings):
            chosen[section] = {key} if key else True
        return chosen

    @property
    def upstream(self) -> tuple[str, ...]:
        """The earlier stages whose datasets it reads, each once."""
        return tuple(dict.fromkeys(stage for stage, _ in self.reads))


_RECORDS = ("records", "records")
_WINDOWS = ("windows", "windows")
_SPECTRA = ("spectra", "spectra")
_MOBILITY = (("mobility", "mobility"), ("mobility", "stacks"))
_FITS = (("fits", "fits"), ("fits", "stack_fits"))
_JOINT = ("fits", "joint")
_DISCREPANCY = (("discrepancy", "discrepancy"), ("discrepancy", "examination"))
_DATA_SHEET = (
    *("name", "controller", "control_interval", "drive_delay", "top_drive_inertia"),
    *("pipe", "collars", "hole_sections"),
)
_ENGINE = ("spectra", "mobility", "fits", "discrepancy")

STAGES: dict[str, Stage] = {
    stage.name: stage
    for stage in (
        Stage("records", (), ("records",), ("time", "channels", "file", "other_logs")),
        Stage("windows", (_RECORDS, ("records", "logs")), ("windows",), ("collars",)),
        Stage("spectra", (_RECORDS, _WINDOWS), ("spectra",), ()),
        Stage("mobility", (_SPECTRA,), ("mobility",), ()),
        Stage("fits", (_WINDOWS, _SPECTRA, *_MOBILITY), ("fits",), _DATA_SHEET),
        Stage(
            "discrepancy",
            (_RECORDS, _WINDOWS, _SPECTRA, *_MOBILITY, *_FITS),
            (*_ENGINE, "common_causes.enabled"),
            _DATA_SHEET,
        ),
        Stage(
            "depth",
            (_RECORDS, _WINDOWS, ("windows", "states"), _SPECTRA, *_MOBILITY, *_FITS, _JOINT, *_DISCREPANCY),
            (*_ENGINE, "depth"),
            _DATA_SHEET,
        ),
        Stage(
            "figures",
            (_RECORDS, _WINDOWS, _SPECTRA, *_MOBILITY, *_FITS, _JOINT, *_DISCREPANCY, ("depth", "depth")),
            (*_ENGINE, "figures"),
            _DATA_SHEET,
        ),
    )
}
"""The stages in the order in which data flow."""

START_UPS = Stage(
    "start_ups",
    (),
    ("start_ups", "figures"),
    ("top_drive", "pipe", "pipe_shear_modulus", "assembly", "assembly_shear_modulus", "mud_density", "friction"),
)
"""The only stage for a measured start of rotation, whose description takes the place of a rig's."""
ALL_STAGES = {**STAGES, START_UPS.name: START_UPS}


def failed_on(listing: "Listing") -> str:
    """Hash of everything that may make a well fail: its whole rig description and its logs, as they are now."""
    return file_manifest([listing.rig_file, *listing.logs])


def fingerprint(stage: Stage, listing: "Listing", settings: "Settings", simulated: bool = False) -> dict[str, Any]:
    """Everything from outside the results that one well's stage depends on.

    Parameters
    ----------
    stage : the stage
    listing : the well's rows of the sheets
    settings : all settings, of which the stage's sections are taken
    simulated : whether the logs are simulated; they do not exist yet when the workflow is laid out, so
        they are left to its own comparison of time stamps
    """
    # datasets and tables contain the well's name, which may change without its folder: only here is that noticed
    name = {} if listing.name == listing.folder else {"name": listing.name}
    # the rig description is passed to a stage, so its module need not appear among the stage's imports
    own = name | ({"stated": listing.stated} if listing.stated else {})
    return own | {
        "source": source_hash(stage.module, *(["drillid.config.rig"] if stage.rig else [])),
        "settings": settings.model_dump(mode="json", include=stage.sections),
        "rig": yaml_digest(listing.rig_file, stage.rig) if stage.rig else "",
        "logs": "" if stage.reads else "simulated" if simulated else file_manifest(listing.logs),
    }
