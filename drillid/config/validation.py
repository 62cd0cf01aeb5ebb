"""Frozen models that reject unknown keys and suggest the one that was probably meant."""

import difflib
import unicodedata
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

from drillid.config.files import read_yaml
from drillid.errors import SettingsError

_BEYOND_BOUNDS = {"greater_than", "greater_than_equal", "less_than", "less_than_equal", "finite_number"}


def in_one_form(text: str) -> str:
    """The text with each accented letter as one character, as not all keyboards and programs write it."""
    return unicodedata.normalize("NFC", text)


Name = Annotated[str, AfterValidator(in_one_form)]
"""A text by which things are recognised as the same."""


class KeyFault(ValueError):
    """What a validator finds wrong with one key of its model.

    Parameters
    ----------
    key : the key, below the model that is validated
    what : what is wrong with it
    remedy : what the user can do about it
    """

    def __init__(self, key: str, what: str, remedy: str) -> None:
        self.key, self.what, self.remedy = key, what, remedy
        super().__init__(key, what, remedy)


class Strict(BaseModel):
    """Base of all settings: immutable, no unknown keys, every field described."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)

    @classmethod
    def checked(cls, content: Any, where: str | Path) -> Self:
        """Build the model from parsed YAML.

        Raises
        ------
        SettingsError
            With `where`, the offending key and, for a misspelt key, the likely one.
        """
        try:
            return cls.model_validate(content)
        except ValidationError as error:
            what, remedy = _explain(cls, error)
            raise SettingsError(str(where), what, remedy) from error

    @classmethod
    def from_yaml(cls, path: str | Path) -> Self:
        """Read and check one YAML file.

        Raises
        ------
        SettingsError
            As `read_yaml` and `checked`.
        """
        content = read_yaml(path)
        return cls.checked({} if content is None else content, path)


def _explain(model: type[BaseModel], error: ValidationError) -> tuple[str, str]:
    """What is wrong with each key, and the remedies, each once."""
    faults = [_explain_key(model, details) for details in error.errors()]
    return "; ".join(what for what, _ in faults), ". ".join(dict.fromkeys(remedy for _, remedy in faults))


def _explain_key(model: type[BaseModel], details: ErrorDetails) -> tuple[str, str]:
    key = ".".join(str(part) for part in details["loc"])
    cause = details.get("ctx", {}).get("error")
    if isinstance(cause, KeyFault):
        return f"'{'.'.join(filter(None, [key, cause.key]))}': {cause.what}", cause.remedy
    if details["type"] == "extra_forbidden":
        known = _known_keys(model, details["loc"][:-1])
        close = difflib.get_close_matches(str(details["loc"][-1]), known, n=1)
        return f"unknown key '{key}'", f"Did you mean '{close[0]}'?" if close else f"Known keys are {', '.join(known)}"
    if details["type"] == "missing":
        return f"the key '{key}' is missing", f"Add '{key}'"
    what = details["msg"].removeprefix("Value error, ")
    if details["type"] == "string_type" and key:
        return f"'{key}': {details['input']!r} is not text", "Put it in quotation marks"
    if details["type"] in _BEYOND_BOUNDS:
        what = f"{details['input']} should be {what.removeprefix('Input should be ')}"
        return f"'{key}': {what}", f"Correct the value of '{key}' ({_description(model, details['loc'])})"
    if not key:
        return f"top level: {what}", f"Write keys with their values; known keys are {', '.join(_known_keys(model, ()))}"
    return f"'{key}': {what}", f"Correct the value of '{key}'"


def _description(model: type[BaseModel], path: tuple[int | str, ...]) -> str:
    """The sentence on a key, which says its unit as well; on an item, that of the key that holds it."""
    schema = model.model_json_schema()
    for end in range(len(path), 0, -1):
        properties = _resolved(schema, _node(schema, path[: end - 1])).get("properties", {})
        if path[end - 1] in properties:
            return " ".join(str(properties[path[end - 1]].get("description", "")).split()).rstrip(".")
    return ""


def _known_keys(model: type[BaseModel], path: tuple[int | str, ...]) -> list[str]:
    """Keys of the (possibly nested) model at `path`, from the JSON schema."""
    schema = model.model_json_schema()
    return sorted(_resolved(schema, _node(schema, path)).get("properties", {}))


def _node(schema: dict[str, Any], path: tuple[int | str, ...]) -> dict[str, Any]:
    node = schema
    for part in path:
        node = _resolved(schema, node)
        node = node.get("items", {}) if isinstance(part, int) else node.get("properties", {}).get(part, _values(node))
    return node


def _values(node: dict[str, Any]) -> dict[str, Any]:
    values = node.get("additionalProperties", {})
    return values if isinstance(values, dict) else {}


def _resolved(schema: dict[str, Any], node: dict[str, Any]) -> dict[str, Any]:
    for branch in [node, *node.get("anyOf", [])]:
        if "$ref" in branch:
            definition: dict[str, Any] = schema["$defs"][branch["$ref"].rsplit("/", 1)[-1]]
            return definition
    return node
