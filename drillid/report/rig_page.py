"""A page for each rig, hole section and tool that several wells have in common: what they share, well by well."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup

import drillid
from drillid.config.folders import as_seen, folder_apart, folder_of
from drillid.datasets.tables import read_table
from drillid.discrepancy.catalogue import CATALOGUE, words_of
from drillid.fleet.manifest import write_whole
from drillid.report.quantities import digits
from drillid.report.rendering import render
from drillid.report.verdicts import capitalised, headline, percent, signed_size, size_name

COMMON_CAUSES, STANDINGS = "common_causes.csv", "well_standings.csv"
_TEXTS = ("shared", "name", "verdict", "family", "cause", "unit", "well", "standing", "reason")
"""Columns of both tables that are texts, even where they look like numbers."""


def write_rig_pages(results: Path, pages: Path, folders: Mapping[str, str]) -> list[dict[str, Any]]:
    """Write a page for each group of wells; what the fleet's page tells of each: heading, file and text.

    Without the tables of common causes there is none.

    Parameters
    ----------
    folders : of the wells that have pages, by their names
    """
    if not (results / COMMON_CAUSES).exists():
        return []
    groups, standings = _read(results / COMMON_CAUSES), _read(results / STANDINGS)
    links, taken = [], {as_seen(folder) for folder in folders.values()}
    for group in groups.to_dict("records"):
        named = {str(name): value for name, value in group.items()}
        own, apart = (f"{named['shared']}-{folder(named['name'])}" for folder in (folder_of, folder_apart))
        stem = apart if as_seen(own) in taken else own
        taken.add(as_seen(stem))
        file = f"{stem}.html"
        rows = standings[(standings["shared"] == named["shared"]) & (standings["name"] == named["name"])]
        page = render(
            "rig.html.j2",
            group=named,
            text=common_text(named),
            heading=heading(named),
            p_values={name: digits(float(named[name]), 2) for name in ("p_value", "heterogeneity_p_value")},
            standings=rows.to_dict("records"),
            folders=folders,
            version=drillid.__version__,
        )
        write_whole(pages / file, page)
        links.append({"heading": heading(named), "file": file, "text": common_text(named)})
    return links


def _read(path: Path) -> pd.DataFrame:
    return read_table(path, dtype=dict.fromkeys(_TEXTS, str), keep_default_na=False, na_values=[""])


def heading(group: Mapping[str, Any]) -> str:
    """Kind and name of a group, the kind once: 'Rig 7', 'Tool motor 5'."""
    kind, name = str(group["shared"]), str(group["name"])
    named = re.match(rf"{re.escape(kind)}(?![^\W\d_])", name, re.IGNORECASE)
    return name if named else f"{kind.capitalize()} {name}"


def common_text(group: dict[str, Any]) -> Markup:
    """What the wells of a group have in common, as a driller would say it, with size and doubt."""
    wells = f"{int(group['wells'])} wells of this {group['shared']}"
    if int(group["sharing"]) not in (0, int(group["wells"])):
        wells = f"{int(group['sharing'])} of {wells}"
    if not isinstance(group["cause"], str):
        return Markup("{}, taken together, show nothing that they all have in common.").format(wells)
    cause = CATALOGUE[group["cause"]]
    size, low, high = (signed_size(group[name], cause.size.unit) for name in ("size", "size_low", "size_high"))
    others = [words_of(name) for name in str(group["verdict"]).split("|") if name != group["cause"]]
    more = f" These data cannot tell it from {' or '.join(others)}." if others else ""
    told = Markup("{} have in common that {}. {}: {} (95 % interval {} to {}); the probability is {}.{}")
    lead = headline({**group, "location_m": np.nan, "evidence": ""}, group["cause"])
    return told.format(wells, lead, capitalised(size_name(cause)), size, low, high, percent(group["probability"]), more)
