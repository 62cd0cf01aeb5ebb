"""Templates of the pages, with what they need to show numbers and texts."""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import numpy as np

from drillid.discrepancy.catalogue import words_of
from drillid.figures.captions import DISPLAYED_PARAMETERS, FIGURES, share
from drillid.report.attention import URGENCY, interval_explanation, interval_gain, interval_lead, interval_text
from drillid.report.content import joined
from drillid.report.quantities import MISSING, QUANTITIES, both, number
from drillid.report.sentences import (
    data_sheet_verdict,
    deviations_text,
    error_text,
    estimate_text,
    rejections_text,
    spread_text,
    unit_text,
)

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

TEMPLATES = Path(__file__).parent / "templates"


@functools.cache
def _environment() -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "spread": spread_text,
        "parameter_error": error_text,
        "parameter_unit": unit_text,
        "estimate": estimate_text,
        "number": number,
        "share": share,
        "depths": depths,
        "quantity": quantity_text,
        "quantity_number": quantity_number,
        "quantity_unit": quantity_unit,
        "data_sheet": deviations_text,
        "data_sheet_verdict": data_sheet_verdict,
        "rejections": rejections_text,
        "joined": joined,
        "interval_lead": interval_lead,
        "interval_text": interval_text,
        "interval_gain": interval_gain,
        "interval_explanation": interval_explanation,
        "words_of": words_of,
        "address": quote,
        "bar_length": bar_length,
    }
    environment.globals |= {"parameters": DISPLAYED_PARAMETERS, "figures": FIGURES, "urgency": URGENCY}
    return environment


def render(template: str, **values: Any) -> str:
    """A page as text; it depends on its arguments alone."""
    return _environment().get_template(template).render(**values)


def depths(place: Any) -> Markup | str:
    """From and to of anything that has them, a dash for NaN."""
    return QUANTITIES["depth"].text(place.from_m, place.to_m) if np.isfinite(place.from_m) else MISSING


def quantity_text(value: float, name: str, more: int = 0) -> Markup:
    """An SI value of a quantity in both units."""
    return QUANTITIES[name].text(value, more=more)


def bar_length(evidence: float) -> float:
    """Length of a bar of evidence, rem: linear to 10, beyond that by its logarithm."""
    size = abs(evidence)
    return round(max(0.1, min(size, 10) * 0.2 + 2 * math.log10(max(size / 10, 1))), 1)


def quantity_number(value: float, name: str) -> Markup:
    """An SI value of a quantity in both units, without their names."""
    return QUANTITIES[name].number(value)


def quantity_unit(name: str) -> Markup:
    """The quantity's units."""
    return both(*(scale.shown for scale in (QUANTITIES[name].metric, QUANTITIES[name].oilfield)))
