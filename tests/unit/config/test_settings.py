"""Every number of settings and descriptions has bounds, and what lies beyond them is refused with its unit."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import annotated_types
import pytest
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from drillid.config.bounds import Between
from drillid.config.described_well import DescribedWell
from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.errors import SettingsError


def numbers(model: type[BaseModel], place: str = "") -> Iterator[tuple[str, FieldInfo]]:
    """All fields of a model and of those inside it that hold a number."""
    for name, field in model.model_fields.items():
        parts = list(_parts(field.annotation))
        if not {int, float}.isdisjoint(parts):
            yield f"{place}{name}", field
        for part in parts:
            if isinstance(part, type) and issubclass(part, BaseModel):
                yield from numbers(part, f"{place}{name}.")


def _parts(annotation: Any) -> Iterator[Any]:
    inner = get_args(annotation)
    if not inner:
        yield annotation
    for part in inner:
        yield from _parts(part)


def _metadata(field: FieldInfo) -> list[Any]:
    parts = list(_annotations(field.annotation))
    inside = [each for part in parts if isinstance(part, FieldInfo) for each in part.metadata]
    return [*field.metadata, *inside, *(part for part in parts if isinstance(part, Between))]


def _annotations(annotation: Any) -> Iterator[Any]:
    yield annotation
    for part in [*get_args(annotation), *getattr(annotation, "__metadata__", ())]:
        yield from _annotations(part)


@pytest.mark.parametrize("model", [Settings, Rig, DescribedWell])
def test_every_number_has_two_bounds(model: type[BaseModel]) -> None:
    found = dict(numbers(model))
    assert found
    for name, field in found.items():
        kinds = {type(each) for each in _metadata(field)}
        below = kinds & {annotated_types.Gt, annotated_types.Ge, Between}
        above = kinds & {annotated_types.Lt, annotated_types.Le, Between}
        assert below, f"{model.__name__}.{name} has no lower bound"
        assert above, f"{model.__name__}.{name} has no upper bound"


NUMBERS = sorted(name for name, _ in numbers(Settings))


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0])
@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_that_are_not_finite_or_negative_are_refused(name: str, value: float) -> None:
    content: Any = value
    for part in reversed(name.split(".")):
        content = {part: content}
    with pytest.raises(SettingsError) as error:
        Settings.checked(content, "config.yaml")
    assert f"'{name}'" in error.value.what


@pytest.mark.parametrize(
    ("content", "what", "remedy"),
    [
        (
            {"windows": {"length_s": 600000}},
            "'windows.length_s': 600000 should be less than or equal to 86400",
            "Correct the value of 'windows.length_s' (Length of a window, in s)",
        ),
        (
            {"spectra": {"frequency_minimum_hz": 6}},
            "'spectra.frequency_minimum_hz': 6.0 Hz is not below the highest frequency, 5.0 Hz",
            "raise 'frequency_maximum_hz'",
        ),
        (
            {"depth": {"step_duration_s": 1, "step_interval_s": 2}},
            "'depth.step_interval_s': 2.0 s is longer",
            "Lower it",
        ),
        ({"fits": {"starts": "many"}}, "'fits.starts': Input should be a valid integer", "Correct the value"),
        ({"fits": {"start": 3}}, "unknown key 'fits.start'", "Did you mean 'starts'?"),
        ({"wells": 3}, "'wells': 3 is not text", "Put it in quotation marks"),
        (
            {"discrepancy": {"cause_weights": {"unknown": 0}}},
            "'discrepancy.cause_weights.unknown': 0 should be greater than 0",
            "(How much more common a cause, or `unknown`, is than another",
        ),
    ],
)
def test_a_setting_beyond_its_bounds_is_named_with_its_meaning(content: Any, what: str, remedy: str) -> None:
    with pytest.raises(SettingsError) as error:
        Settings.checked(content, "config.yaml")
    assert what in error.value.what
    assert remedy in error.value.remedy


def test_a_run_merges_its_configuration_over_that_of_the_folder_key_by_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    other = tmp_path / "other.yaml"
    other.write_text("fits: {starts: 3}\n")
    assert Settings.of_run(other) == Settings(fits={"starts": 3}), "a folder needs no configuration of its own"
    (tmp_path / "config").mkdir()
    own = tmp_path / "config/config.yaml"
    own.write_text("fits: {starts: 5, error_rate: 0.01}\nlogs: there.tsv\n")
    merged = Settings(fits={"starts": 3, "error_rate": 0.01}, logs="there.tsv")
    assert Settings.of_run(other) == merged
    assert Settings.of_run("config/config.yaml").fits.starts == 5
    own.write_text("fit: {starts: 5}\n")
    with pytest.raises(SettingsError, match=r"config/config\.yaml, .*other\.yaml: unknown key 'fit'"):
        Settings.of_run(other)
    with pytest.raises(SettingsError, match=r"none\.yaml: cannot be read"):
        Settings.of_run(tmp_path / "none.yaml")
