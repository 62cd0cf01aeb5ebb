"""The faults that `python -m tests.mutants` puts into a copy of the library, spread over all of its rooms."""

from tests.mutants.fault import Fault
from tests.mutants.faults_in_data import IN_DATA
from tests.mutants.faults_in_models import IN_MODELS

FAULTS: tuple[Fault, ...] = (*IN_DATA, *IN_MODELS)
