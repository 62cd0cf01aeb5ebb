"""Charts as one JSON document for a page, the same for the same charts, and the script that draws it."""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

_IDENTIFIER = re.compile(r'"id":"(p\d+)"')


def document(charts: Mapping[str, Any], named: Mapping[str, Any], prefix: str) -> str:
    """All charts with their data, each once.

    Parameters
    ----------
    charts : by the identifiers of the elements of the page that they are drawn in
    named : models that the page's script looks up by these names
    prefix : of the identifiers of models, another one for each document of a page

    Returns
    -------
    JSON that is safe within an element <script>: the document, and identifiers in it by elements and by names.
    """
    from bokeh.core.json_encoder import serialize_json
    from bokeh.core.serialization import Serializer
    from bokeh.document import Document

    # a document that has charts collects their models over and over, and would write the same
    with _defaults_not_found_out():
        roots = Serializer(deferred=False).encode(list(charts.values()))
    text = serialize_json({**Document().to_json(deferred=False), "roots": roots})
    # Bokeh counts models through the life of a process
    names = {name: f"{prefix}{number}" for number, name in enumerate(dict.fromkeys(_IDENTIFIER.findall(text)))}
    text = _IDENTIFIER.sub(lambda match: f'"id":"{names[match[1]]}"', text)
    found = {"roots": charts, "named": named}
    looked_up = {kind: {name: names[model.id] for name, model in models.items()} for kind, models in found.items()}
    return f'{{"document":{text},"looked_up":{json.dumps(looked_up)}}}'.replace("<", "\\u003c")


@contextlib.contextmanager
def without_idle_parts() -> Iterator[None]:
    """Let Bokeh make no part of a model before somebody asks for it, such as the box that a tool may draw.

    It makes parts that nobody asks for, which takes more than half of the time of a page, and writes them into the
    document, though its script makes the same of a model that lacks them.
    """
    from bokeh.core.has_props import HasProps
    from bokeh.core.property.singletons import Intrinsic, Undefined

    models: Any = HasProps
    original = models.__init__

    def begin(model: Any, **properties: Any) -> None:
        super(models, model).__init__()
        model._property_values, model._unstable_default_values, model._unstable_themed_values = {}, {}, {}
        for name, value in properties.items():
            if value is not Undefined and value is not Intrinsic:
                setattr(model, name, value)
        model._initialized = True

    models.__init__ = begin
    try:
        yield
    finally:
        models.__init__ = original


@contextlib.contextmanager
def _defaults_not_found_out() -> Iterator[None]:
    """Let Bokeh look at no property that has its default value, which it leaves out of a document in the end.

    It finds out the values of all properties first, which takes half of the time of a page's documents.
    """
    from bokeh.core.has_props import HasProps
    from bokeh.core.property.wrappers import PropertyValueContainer

    models: Any = HasProps
    original = models.query_properties_with_values

    def query(model: Any, chosen: Callable[[Any], bool], *, include_defaults: bool = True, **options: Any) -> Any:
        if include_defaults:
            return original(model, chosen, include_defaults=True, **options)
        own, themed = model._unstable_default_values, model.themed_values() or {}
        names = model._property_values.keys() | own.keys() | themed.keys()
        descriptors = [model.lookup(name) for name in model.properties(_with_props=True) if name in names]
        values = {each.name: each.get_value(model) for each in descriptors if chosen(each)}

        def unchanged(name: str) -> bool:
            """A container that the model has made by itself; Bokeh leaves it out as well."""
            return name in own and name not in themed and isinstance(values[name], PropertyValueContainer)

        return {name: value for name, value in values.items() if not unchanged(name)}

    models.query_properties_with_values = query
    try:
        yield
    finally:
        models.query_properties_with_values = original


def bokeh_script() -> tuple[str, bytes]:
    """Name and content of the script that all pages share; it comes with the installed Bokeh."""
    import bokeh

    content = (Path(bokeh.__file__).parent / "server/static/js/bokeh.min.js").read_bytes()
    return f"bokeh-{bokeh.__version__}.min.js", content
