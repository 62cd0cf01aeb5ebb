"""Files generated from the models and schemas, so that options, datasets and their documentation cannot disagree."""

import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import yaml
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from drillid.config import examples
from drillid.config.bounds import text_of_bounds
from drillid.config.rig import CHANNEL_UNITS, REQUIRED_CHANNELS, Rig
from drillid.config.settings import Settings
from drillid.config.sheets import LogRow, StartUpRow, WellRow
from drillid.datasets.declaration import DatasetSchema
from drillid.datasets.registry import CHANGE_COLUMNS, CHANGES, DATASETS

_NOTE = "Written by `make docs` from the models in drillid/; edit those instead."
_WIDTH = 110
_NOT_BY_DEFAULT = {"simulate", "fleet"}
"""Sections of the demo alone, and of profiles because they do not change results."""
_PYTHON = "3.11"
_DRIVERS = {"snakemake"}
"""Dependencies that drive the rules and are not used inside them."""
_CONDA_NAMES = {"dask": "dask-core", "matplotlib": "matplotlib-base"}
_DATASETS_HEAD = (
    "Every stage writes one zarr store for each dataset and well, `<results>/<stage>/<well>/<dataset>.zarr`, "
    "which `xarray.open_zarr(path)` opens. Variables named like a dimension are coordinates. "
    "Beside the datasets each folder holds problems.csv, one row for everything that was rejected, with reason and "
    "remedy, and key.json, the hashes of all inputs of the folder. fleet.zarr holds all wells."
)
_README_HEAD = """# Configuration

List wells in `wells.tsv`, their log files in `logs.tsv`, and describe each rig in `rigs/<rig>.yaml`; then start
`drillid run`. An unknown key is an error that names the key that was probably meant. Another configuration, such as
`config/demo/config.yaml`, contains only what differs: `drillid run --configfile <path>`. Profiles set the section
`fleet`, which spreads the work over processes and does not change results."""

_EXAMPLE = """name: Rig 7
time: {column: Time, zone: UTC, sample_rate: 50 Hz}
channels:
  torque_sweep: {column: SWEEP, unit: kN m}
  torque_command: {column: TQCMD, unit: kN m}
  speed: {column: RPM, unit: rpm}
  hole_depth: {column: DMEA, unit: ft}
  weight_on_bit: {column: WOB, unit: klbf}
controller: {proportional: 1500 N m s/rad, integral: 800 N m/rad}
drive_delay: {value: 40 ms, tolerance: 5 ms}
top_drive_inertia: {value: 1100 kg m^2, relative: 5 %}
pipe: {outer_diameter: 5.5 in, inner_diameter: 4.778 in}
collars:
  - {outer_diameter: 6.5 in, inner_diameter: 2.8125 in, length: 100 m, from_depth: 3000 m}"""


def documents(root: Path) -> dict[str, str]:
    """Text of every generated file, by its path below the repository's root."""
    return {
        "config/config.yaml": config_yaml(),
        "config/README.md": config_readme(),
        "docs/datasets.md": datasets_page(),
        "envs/drillid.yaml": environment(root),
        "workflow/schemas/config.schema.yaml": schema_yaml(Settings),
        "workflow/schemas/rig.schema.yaml": schema_yaml(Rig),
        "workflow/schemas/wells.schema.yaml": schema_yaml(WellRow),
        "workflow/schemas/logs.schema.yaml": schema_yaml(LogRow),
        "workflow/schemas/start_ups.schema.yaml": schema_yaml(StartUpRow),
    }


def write_documents(root: Path) -> None:
    """Write every generated file."""
    for name, text in documents(root).items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def schema_yaml(model: type[BaseModel]) -> str:
    """JSON schema of a model, in YAML."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **model.model_json_schema()}
    return f"# {_NOTE}\n" + yaml.safe_dump(schema, sort_keys=False, allow_unicode=True, width=_WIDTH)


def config_yaml() -> str:
    """The default configuration with a comment above every key."""
    return (
        "\n".join([f"# {_NOTE}", "# The choices that change results, each at its default.", *_keys(Settings(), "")])
        + "\n"
    )


def _keys(model: BaseModel, indent: str) -> Iterator[str]:
    for name, field in type(model).model_fields.items():
        value = getattr(model, name)
        if name in _NOT_BY_DEFAULT:
            continue
        if isinstance(value, BaseModel):
            yield ""
            yield from _comment(str(type(value).__doc__), indent)
            yield f"{indent}{name}:"
            yield from _keys(value, indent + "  ")
        else:
            yield from _comment(str(field.description), indent)
            yield f"{indent}{name}: {_scalar(value)}"


def _comment(text: str, indent: str) -> list[str]:
    return [f"{indent}# {line}" for line in textwrap.wrap(text, _WIDTH - len(indent) - 2)]


def _scalar(value: Any) -> str:
    return yaml.safe_dump(value, default_flow_style=True, width=1000).splitlines()[0]


def environment(root: Path) -> str:
    """Conda environment of the rules: the project's direct dependencies at the versions of the lock."""
    import tomllib

    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    names = [re.split(r"[^\w-]", requirement)[0] for requirement in project["dependencies"]]
    pins = _pins((root / "requirements.lock").read_text())
    lines = [f"  - {_CONDA_NAMES.get(name, name)}={pins[name]}" for name in names if name not in _DRIVERS]
    head = [f"# {_NOTE}", "channels:", "  - conda-forge", "  - nodefaults", "dependencies:", f"  - python={_PYTHON}"]
    return "\n".join([*head, *lines]) + "\n"


def _pins(lock: str) -> dict[str, str]:
    """Locked version of every package that the environment's Python takes."""
    from packaging.requirements import Requirement

    lines = re.findall(r"^([\w.-]+(?:\[.*?\])?==.*?) *\\\\?$", lock, re.MULTILINE)
    python = {"python_version": _PYTHON, "python_full_version": f"{_PYTHON}.0"}
    pins = [pin for pin in map(Requirement, lines) if pin.marker is None or pin.marker.evaluate(python)]
    return {pin.name: str(pin.specifier).removeprefix("==") for pin in pins}


def config_readme() -> str:
    """Page on the configuration: settings, sheets and rig descriptions."""
    lines = [f"<!-- {_NOTE} -->", *_README_HEAD.splitlines(), "", "## config.yaml", ""]
    lines += _table(Settings, only_scalars=True)
    for name, field in Settings.model_fields.items():
        model = _model(field.annotation)
        if model is not None:
            lines += _sections(name, model)
    for title, sheet in (("wells.tsv", WellRow), ("logs.tsv", LogRow), ("start_up_sheet", StartUpRow)):
        lines += ["", f"## {title}", "", "Columns are separated by tabs; lines that begin with '#' are left out.", ""]
        lines += _table(sheet)
    lines += [
        "",
        "## rigs/*.yaml",
        "",
        str(Rig.__doc__),
        "",
        "```yaml",
        *_EXAMPLE.splitlines(),
        "```",
        "",
        *_table(Rig),
    ]
    for name, field in Rig.model_fields.items():
        model = _model(field.annotation)
        if model is not None:
            lines += ["", f"### {name}", "", str(model.__doc__), "", *_table(model)]
    head = "| channel | SI unit inside the program | needed in the logs |"
    lines += ["", "### The channels", "", head, "|---|---|---|"]
    lines += [
        f"| {name} | {unit} | {'yes' if name in REQUIRED_CHANNELS else ''} |" for name, unit in CHANNEL_UNITS.items()
    ]
    lines += ["", "## Logs of other shapes", "", *textwrap.wrap(examples.FORMATS, _WIDTH)]
    for shape, keys in examples.SHAPES.items():
        lines += ["", f"{shape}:", "", "```yaml", *keys.splitlines(), "```"]
    return "\n".join(lines) + "\n"


def _sections(name: str, model: type[BaseModel]) -> Iterator[str]:
    """A settings model and those inside it."""
    yield from ("", f"### {name}", "", str(model.__doc__), "", *_table(model))
    for key, field in model.model_fields.items():
        inner = _model(field.annotation)
        if inner is not None:
            yield from _sections(f"{name}.{key}", inner)


def _model(annotation: Any) -> type[BaseModel] | None:
    """The settings model inside an annotation such as `Stated | None`, `tuple[Collars, ...]` or `dict[str, Column]`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for part in get_args(annotation) if (found := _model(part)) is not None), None)


def _table(model: type[BaseModel], only_scalars: bool = False) -> list[str]:
    rows = ["| key | default | values | meaning |", "|---|---|---|---|"]
    for name, field in model.model_fields.items():
        if only_scalars and _model(field.annotation) is not None:
            continue
        meaning = " ".join(str(field.description).replace("|", "/").split())
        rows.append(f"| {name} | {_default(field)} | {_values(field)} | {meaning} |")
    return rows


def _values(field: FieldInfo) -> str:
    """What may stand there, where that is limited."""
    for part in (field.annotation, *get_args(field.annotation)):
        if get_origin(part) is Literal:
            return ", ".join(f"`{value}`" for value in get_args(part))
    return text_of_bounds(field)


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "needed"
    value = field.get_default(call_default_factory=True)
    if isinstance(value, BaseModel):
        return "see below"
    return "" if value in (None, (), "") else f"`{_scalar(value)}`"


def datasets_page() -> str:
    """Page on every dataset's dimensions, units and meaning."""
    lines = [f"<!-- {_NOTE} -->", "# Datasets", "", *textwrap.wrap(_DATASETS_HEAD, _WIDTH)]
    for name, schema in DATASETS.items():
        lines += ["", f"## {name}", "", f"{schema.title}.", "", *_dataset_table(schema)]
    return "\n".join([*lines, *_changes_table()]) + "\n"


def _changes_table() -> list[str]:
    lines = ["", "## changes.csv", "", "What is new since the last report, one row for each change of a well."]
    for head, rows in (("column", CHANGE_COLUMNS), ("change", CHANGES)):
        lines += ["", f"| {head} | meaning |", "|---|---|", *(f"| {name} | {text} |" for name, text in rows.items())]
    return lines


def _dataset_table(schema: DatasetSchema) -> list[str]:
    rows = ["| variable | dimensions | type | unit | meaning |", "|---|---|---|---|---|"]
    for name, variable in schema.variables.items():
        meaning = variable.long_name
        if variable.flags is not None:
            codes = ", ".join(f"{int(code)} {str(code.name).lower().replace('_', ' ')}" for code in variable.flags)
            meaning += f" ({codes})"
        rows.append(f"| {name} | {', '.join(variable.dims)} | {variable.dtype} | {variable.units} | {meaning} |")
    return rows
