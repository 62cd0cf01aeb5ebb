"""Frozen models that reject unknown keys and suggest the one that was probably meant."""

import difflib
from pathlib import Path
from typing import Any, Self

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

from drillid.errors import SettingsError


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

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

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
        """Read and check one YAML file."""
        try:
            content = yaml.safe_load(Path(path).read_text())
        except OSError as error:
            raise SettingsError(str(path), f"cannot be read ({error.strerror})", "Check the path") from error
        except yaml.YAMLError as error:
            raise SettingsError(str(path), f"is not valid YAML ({error})", "Correct the line it names") from error
        return cls.checked(content or {}, path)


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
    if not key:
        return f"top level: {what}", f"Write keys with their values; known keys are {', '.join(_known_keys(model, ()))}"
    return f"'{key}': {what}", f"Correct the value of '{key}'"


def _known_keys(model: type[BaseModel], path: tuple[int | str, ...]) -> list[str]:
    """Keys of the (possibly nested) model at `path`, from the JSON schema."""
    schema = model.model_json_schema()
    node: dict[str, Any] = schema
    for part in path:
        node = _resolved(schema, node)
        node = node.get("items", {}) if isinstance(part, int) else node.get("properties", {}).get(part, _values(node))
    return sorted(_resolved(schema, node).get("properties", {}))


def _values(node: dict[str, Any]) -> dict[str, Any]:
    values = node.get("additionalProperties", {})
    return values if isinstance(values, dict) else {}


def _resolved(schema: dict[str, Any], node: dict[str, Any]) -> dict[str, Any]:
    for branch in [node, *node.get("anyOf", [])]:
        if "$ref" in branch:
            definition: dict[str, Any] = schema["$defs"][branch["$ref"].rsplit("/", 1)[-1]]
            return definition
    return node
