"""The JSON Schema of a problem file, for editors: the schema, and what is written out before it is looked at."""

from __future__ import annotations

from typing import Any

from pydantic.json_schema import GenerateJsonSchema

from ..schema.spec import Spec


class _Definitions(GenerateJsonSchema):
    """Definitions have the names that people know: Mesh, not MeshEntry."""

    def normalize_name(self, name: str) -> str:
        return super().normalize_name(name).removesuffix("Entry")


def _with_templates(node: Any, whole: bool = False) -> None:
    """Let entries be templates, see `language.loops`; node: of a JSON Schema; whole: the file itself is none."""
    if isinstance(node, list):
        for own in node:
            _with_templates(own)
    if not isinstance(node, dict):
        return
    for own in node.values():
        _with_templates(own)
    if isinstance(node.get("properties"), dict) and node.get("additionalProperties") is False and not whole:
        description = "i in 1..20: this is a template, an entry for each i, which stands in it as {i}"
        node["properties"]["for"] = {"type": ["string", "array"], "description": description}
    if isinstance(node.get("additionalProperties"), dict):
        node["patternProperties"] = {"^for ": {"type": "object"}}


def _with_vectors(result: dict[str, Any]) -> None:
    """Let names be vectors, see `vectors.write_out`: they have a size, and values are lists as well as expressions."""
    for kind in ("State", "Control", "Algebraic", "Static"):
        description = "of a vector: the number of its components, or rows and columns, [3, 3]"
        result["$defs"][kind]["properties"]["size"] = {
            "type": ["integer", "string", "array"],
            "description": description,
        }
    waiting: list[Any] = [result]
    while waiting:
        node = waiting.pop()
        if isinstance(node, dict) and node.get("type") == ["number", "string"]:
            node |= {"type": ["number", "string", "array"], "minItems": 1}
        if isinstance(node, dict) and node.get("type") == "array" and node.get("maxItems") == 2:  # a point of a drawing
            node["type"] = ["array", "string"]
        waiting += node.values() if isinstance(node, dict) else node if isinstance(node, list) else ()


def _with_conditions(result: dict[str, Any]) -> None:
    """Let a constraint and a link be a text, see `language.conditions`."""
    waiting: list[Any] = [result]
    while waiting:
        node = waiting.pop()
        items = node.get("items") if isinstance(node, dict) else None
        if isinstance(items, dict) and str(items.get("$ref", "")).endswith(("/Constraint", "/Link")):
            node["items"] = {"anyOf": [items, {"type": "string"}]}
        waiting += node.values() if isinstance(node, dict) else node if isinstance(node, list) else ()


def schema(methods: tuple[str, ...] = ()) -> dict[str, Any]:
    """JSON Schema of a problem file; `methods` are the names that a mesh entry may give."""
    result = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **Spec.model_json_schema(schema_generator=_Definitions),
    }
    _with_templates(result, whole=True)
    _with_vectors(result)
    _with_conditions(result)
    if methods:
        result["$defs"]["Mesh"]["properties"]["method"]["enum"] = list(methods)
    return result
