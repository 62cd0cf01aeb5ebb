"""Well B of Aarsnes and Shor (2018): its description beside this file, and its survey."""

from dataclasses import replace
from pathlib import Path

from drillid.config.described_well import DescribedWell
from drillid.physics.soft_string import Survey

_DESCRIBED = DescribedWell.from_yaml(Path(__file__).with_suffix(".yaml"))

EQUIPMENT = _DESCRIBED.described_equipment
PUBLISHED = replace(EQUIPMENT, pipe_shear_modulus=61e9)
"""With the published stiffness of the pipe; see `benchmarks.field.transfer`."""
FRICTION = _DESCRIBED.described_friction
SURVEY = Survey.from_degrees([0, 300, 700, 1250, 1300, 2700], [0, 0, 40, 40, 45, 45])
"""3° per 30 m below 300 m to 40°, held to 1250 m, then to 45° and held."""
