"""A problem file -> Spec, or every mistake in it at once, each with its line, its path and a remedy."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from .checks.phases import check_spec
from .checks.repair import repair
from .errors import FileError, Mistake, SpecError
from .files import PIPES, reason_of
from .language.conditions import write_conditions
from .loading.left_out import empty_bounds
from .loading.options import OptionCheck, refused_options, unsafe_options
from .loading.stages import without_loops, without_vectors, written_out
from .phases.order import own_entries
from .phases.short_forms import is_static
from .schema import messages
from .schema.fields import CALLED, STORED
from .schema.spec import Spec
from .schema.tables import called_names
from .tables.files import read_files
from .yaml.document import MAX_BYTES, decode, dotted, read_document
from .yaml.document import Path as Place
from .yaml.locations import UNUSED, Finding, Locations

MoreChecks = Callable[[Spec], tuple[list[Finding], list[Finding]]]
"""A spec, in which other mistakes may be left -> mistakes and warnings that only some ask for."""


def load(
    source: Path,
    overrides: Sequence[str] = (),
    methods: Sequence[str] = (),
    options: OptionCheck | None = None,
    more: MoreChecks | None = None,
) -> Spec:
    """The spec of a problem file.

    source: its path.
    overrides: "PATH=VALUE" each, such as "parameters.u_max=15" or "mesh.*.segments=50", applied in turn and checked
        as if they stood in the file.
    methods: the names that a mesh entry may give; none means any.
    options: asked about the options of the engine, which only the engine knows; None asks nobody.
    more: asked about the whole file, such as `units.check.check_units`; None asks nobody.

    What is odd but not wrong is in `spec.warnings`.

    Raises FileError if the file cannot be read, and SpecError with all the mistakes in the file and the overrides.
    """
    source = Path(source)
    return load_text(read_text(source), str(source), overrides, methods, options, source.parent, more)


def load_text(
    text: str,
    file: str,
    overrides: Sequence[str] = (),
    methods: Sequence[str] = (),
    options: OptionCheck | None = None,
    folder: Path | None = None,
    more: MoreChecks | None = None,
) -> Spec:
    """As `load`, from a text.

    text: YAML.
    file: the name used in messages; without its suffix, the name of a problem that gives none.
    overrides, methods, options, more: as `load` takes them.
    folder: that the CSV files of its tables are in; None if it may have none.
    """
    document, numbers, overrides, repeated = without_loops(read_document(text, file), overrides)
    write_conditions(document.data, is_static(document.data))
    document, given, overrides, made = without_vectors(document, overrides, numbers)
    data, locations, early = written_out(document, file, overrides, given, made, repeated)
    early += [*repeated.findings, *made.findings]
    if options and isinstance(data.get("solver"), dict):
        early += refused_options(data["solver"], options, {str(finding.path[-1]) for finding in early})
    context = {"methods": tuple(methods), CALLED: called_names(data)}
    unread = read_files(data, folder)
    early += unread
    try:
        spec = Spec.model_validate(data, context=context)
    except ValidationError as error:
        rest = repair(data, error)
        early += messages.findings(error, locations)
        raise SpecError(locations.mistakes(early + (_checked(rest, early, more)[0] if rest else []))) from None
    errors, warnings = _checked(spec, early, more)
    if errors or early:
        raise SpecError(locations.mistakes(early + errors))
    unused = {("parameters", name) for name in repeated.counted | made.counted}
    told = [w for w in (*warnings, *empty_bounds(data)) if w.path not in unused or w.kind != UNUSED]
    return spec.attach(text, locations, told)


def _checked(spec: Spec, early: Sequence[Finding], more: MoreChecks | None) -> tuple[list[Finding], list[Finding]]:
    """The mistakes and warnings of `check_spec` and of more checks, which need phases without mistakes.

    early: what is known to be wrong, with whose values the spec was mended.
    """
    errors, warnings = check_spec(spec, not early)
    if more is not None and not (errors and own_entries(spec)):
        own, odd = more(spec)
        before = [finding.path for finding in (*early, *errors)]
        errors += [finding for finding in own if not _of_mistaken(finding.path, before)]
        warnings = warnings + odd
    return errors, warnings


def _of_mistaken(path: Place, mistaken: Sequence[Place]) -> bool:
    """Whether a path is of measurements in which something is mistaken: what they add up to is not known then."""
    return path[-2:-1] == ("measurements",) and any(own[: len(path)] == path for own in mistaken)


def load_stored(data: Mapping[str, Any], file: str) -> Spec:
    """The spec that a result holds, full; a result is foreign data, so it is checked as a problem file is.

    data: plain, nested no deeper than Python can follow.
    file: the result, for messages.

    What only the command line may set is left out: nobody has given it on this one. Raises FileError if it is no spec
    of this version.
    """
    solver, locations = data.get("solver"), Locations(file, dict.fromkeys(_paths(data), 1))
    if unsafe := {finding.path[1] for finding in unsafe_options(solver, locations)}:
        data = {**data, "solver": {name: value for name, value in (solver or {}).items() if name not in unsafe}}
    try:
        spec = Spec.model_validate(data, context={STORED: True, CALLED: called_names(data)})
        errors, _ = check_spec(spec)
    except ValidationError as error:
        raise _unreadable(messages.findings(error, locations)[0], file) from error
    if errors:
        raise _unreadable(errors[0], file)
    return spec.attach(spec.model_dump_json(), Locations(file, {}), [])


def _paths(node: Any, path: Place = ()) -> Iterator[Place]:
    """The paths of all that stands in plain data."""
    yield path
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in items:
        yield from _paths(value, (*path, key))


def _unreadable(first: Finding, file: str) -> FileError:
    told = ": ".join(filter(None, [dotted(first.path), first.what]))
    what = f"the problem that it holds cannot be read ({told})"
    return FileError(Mistake(file, what, "solve the problem anew with this version of trajopt"))


def read_text(path: Path) -> str:
    """The text of a problem file. Raises FileError with the reason, SpecError if it is not text."""
    if not path.exists():
        where = "it is not in this folder" if path.parent == Path() else f"look into {path.parent}"
        raise FileError(Mistake(str(path), "there is no such file", f"check the name: {where}"))
    if path.is_dir():
        raise FileError(Mistake(str(path), "this is a folder", "give a problem file in it"))
    if not path.is_file() and not str(path).startswith(PIPES):
        raise FileError(Mistake(str(path), "this is not an ordinary file", "give a YAML problem file"))
    try:
        with path.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except OSError as error:
        what = f"the file cannot be read ({reason_of(error)})"
        raise FileError(Mistake(str(path), what, "check its permissions")) from error
    if content.startswith(b"\x89HDF"):
        what = "this is a result, not a problem file"
        remedy = (
            f"give its problem file, which trajopt export {path} out.yaml writes; trajopt show, plot and verify read it"
        )
        raise SpecError(Mistake(str(path), what, remedy))
    return decode(content, str(path))
