"""Wells and starts of rotation as the sheets list them, and as stages receive them."""

import difflib
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from drillid.config.folders import folder_of
from drillid.config.rig import Rig
from drillid.errors import SettingsError
from drillid.formats.remote import url_of


@dataclass(frozen=True)
class Well:
    """One well with its rig description and logs, as a stage receives it."""

    name: str
    rig: Rig
    logs: tuple[Path, ...]


@dataclass(frozen=True)
class Listing:
    """One well as listed in the sheets; its rig description is not read yet, and may be missing.

    name : as people write it
    rig_file : description of its rig; the sheet itself where the well's row there cannot be used
    folder : of its results, and its name wherever the workflow needs one; by default made from the name
    section, tool : what it may have in common with other wells; empty where it has nothing
    faults : of its rows in the sheets, for which it fails
    """

    name: str
    rig_file: Path
    logs: tuple[Path, ...]
    description: str = ""
    folder: str = ""
    section: str = ""
    tool: str = ""
    faults: tuple[SettingsError, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "folder", self.folder or folder_of(self.name))

    @property
    def stated(self) -> dict[str, Any]:
        """What its rows of the sheets say that its results depend on, beside rig and logs."""
        return {"faults": list(map(str, self.faults))} if self.faults else {}

    def load(self) -> Any:
        """The well with its rig description.

        Raises
        ------
        SettingsError
            If it is missing, cannot be read or does not validate, or if the well has no logs.
        """
        rig = self.load_rig()
        if not self.logs:
            raise SettingsError("logs sheet", f"well '{self.name}' has no logs", "List its log files there")
        return Well(self.name, rig, self.logs)

    def load_rig(self) -> Rig:
        """The rig description alone.

        Raises
        ------
        SettingsError
            If it is missing, cannot be read or does not validate.
        """
        if not os.path.isfile(self.rig_file):
            raise self._without_rig()
        return Rig.from_yaml(self.rig_file)

    def _without_rig(self) -> SettingsError:
        """The error of a rig that is not described, with the one that was probably meant."""
        rig, known = self.rig_file.stem, sorted(path.stem for path in self.rig_file.parent.glob("*.yaml"))
        close = difflib.get_close_matches(rig, known, n=1)
        meant = f"Did you mean '{close[0]}'? Else write" if close else "Write"
        remedy = f"{meant} this file, or correct the rig of well '{self.name}' in the wells sheet"
        return SettingsError(str(self.rig_file), f"rig '{rig}' has no description", remedy)

    def absolute(self) -> "Listing":
        """The same with absolute paths, which hold in any working folder; URLs stay as they are."""
        logs = tuple(log if url_of(log) else log.absolute() for log in self.logs)
        return replace(self, rig_file=self.rig_file.absolute(), logs=logs)


@dataclass(frozen=True)
class StartUp:
    """One measured start of rotation with its files, as its stage receives it."""

    name: str
    description: Path
    survey: Path
    log: Path
    depth: float
    """m, of the bit along the hole."""
    fitted: tuple[str, ...]
    """What is fitted; empty where the usual is."""


@dataclass(frozen=True)
class StartUpListing(Listing):
    """One start of rotation as listed in its sheet; its description stands in the place of a rig's."""

    depth: float = 0.0
    fitted: tuple[str, ...] = ()

    @property
    def stated(self) -> dict[str, Any]:
        """Depth and what is fitted."""
        return super().stated | {"depth_m": self.depth, "fitted": list(self.fitted)}

    def load(self) -> StartUp:
        """The start with its files, none of which is read yet."""
        log, survey = self.logs
        return StartUp(self.name, self.rig_file, survey, log, self.depth, self.fitted)
