"""A document as it is written -> plain data as the schema knows it, step by step, with overrides where they belong."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..chains.write import write_out_chain
from ..checks.values import NO_STATES
from ..language import loops
from ..phases.short_forms import default_mesh, exact_mesh, is_discrete, is_static, write_out
from ..schema.spec import Spec
from ..text import printable
from ..vectors import write_out as vectors
from ..vectors.presence import concerns, has_vectors
from ..yaml.document import Document
from ..yaml.document import Path as Place
from ..yaml.locations import Finding, Locations
from ..yaml.overrides import override
from .left_out import (
    default_tolerance,
    is_misspelt,
    measured_objective,
    meshes_of_phases,
    missing_times,
    shared_objective,
)
from .options import unsafe_options


def without_loops(
    document: Document, overrides: Sequence[str]
) -> tuple[Document, dict[Place, str], Sequence[str], loops.Expanded]:
    """The document with its templates written out, by parameters that are overridden before.

    document: as it is written.
    overrides: "PATH=VALUE" each.

    Also the paths of these, the overrides that remain, and what else there is to know of what is made.
    """
    if not loops.has_loops(document.data):
        return document, {}, overrides, loops.Expanded(document.data, document.lines)
    numbers = [text for text in overrides if text.strip().startswith("parameters.")]
    data, given = override(document, numbers)
    expanded = loops.templates_written_out(data, document.lines)
    rest = [text for text in overrides if text not in numbers]
    return Document(expanded.data, expanded.lines, document.blocks), given, rest, expanded


def without_vectors(
    document: Document, overrides: Sequence[str], before: dict[Place, str]
) -> tuple[Document, dict[Place, str], Sequence[str], vectors.WrittenOut]:
    """The document with its vectors written out, by what is overridden in it before.

    document: without templates.
    overrides: that remain.
    before: the paths of earlier overrides.

    Also the paths of all overrides so far, those that remain, and what else there is to know of what is made.
    """
    if not has_vectors(document.data):
        return document, before, overrides, vectors.WrittenOut(document.data)
    now = [text for text in overrides if concerns(text.partition("=")[0].strip(), document.data)]
    data, given = override(document, now)
    made = vectors.vectors_written_out(data)
    rest = [text for text in overrides if text not in now]
    document = Document(made.data, document.lines, document.blocks)
    return document, before | given, rest, made


def written_out(
    document: Document,
    file: str,
    overrides: Sequence[str],
    before: dict[Place, str],
    made: vectors.WrittenOut,
    repeated: loops.Expanded,
) -> tuple[dict[str, Any], Locations, list[Finding]]:
    """The data of a file as the schema knows it: overrides applied, short forms written out, what is left out chosen.

    document: without templates and vectors.
    file: its name, for messages.
    overrides: that remain.
    before: the overrides that templates and vectors were made by.
    made: of vectors.
    repeated: of templates.

    Also where each value was given, and what is wrong so far.
    """
    chosen = default_mesh()
    asked = [(key,) for key in ("mesh", "refine") if document.data.get(key) is not None]
    if document.data.get("mesh") is None:
        document.data["mesh"] = chosen  # so that an override finds its entries
    data, given = override(document, overrides)
    if data.get("mesh") is None:
        data["mesh"] = chosen
    wrong = default_tolerance(data) if data["mesh"] is chosen else []
    static = is_static(data)
    if static or is_discrete(data):
        wrong += exact_mesh(data, asked, given)
    elif data["mesh"] is chosen and data.get("refine") is None and not meshes_of_phases(data):
        data["refine"] = {}
    of_chain, mistaken = write_out_chain(data)
    wrong += mistaken
    origin = {**made.origin, **{path: path for path in given}}
    short = of_chain | write_out(data)
    locations = Locations(
        file, document.lines, before | given, document.blocks, short, origin, made.in_words, repeated.of_templates
    )
    data.setdefault("name", printable(Path(file).stem))
    early = wrong + unsafe_options(data.get("solver"), locations)
    measured_objective(data)
    if static:
        return data, locations, early
    if data.get("phases") or data.get("waypoints"):
        shared_objective(data)
        return data, locations, early
    early += missing_times(data)
    if not (data.get("states") or data.get("model") or is_misspelt("states", data, Spec.model_fields)):
        early.append(NO_STATES)
    return data, locations, early
