"""Identification while drilling: torsional dynamics of the drilling system from rig logs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from drillid.identification import Identification as Identification
    from drillid.identification import identify as identify

__version__ = "0.1.0"
__all__ = ["Identification", "identify"]


def __getattr__(name: str) -> Any:
    """What the library offers first, imported when it is first used: `import drillid` alone costs nothing."""
    if name not in __all__:
        raise AttributeError(f"module 'drillid' has no attribute '{name}'")
    from drillid import identification

    return getattr(identification, name)
