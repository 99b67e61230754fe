"""A problem file -> Spec, or every mistake in it at once, each with its line, its path and a remedy."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from .chains.write import write_out as write_out_chain
from .checks.phases import check_spec
from .checks.repair import repair
from .checks.values import NO_STATES
from .errors import FileError, Mistake, SpecError
from .files import PIPES
from .language import loops
from .language.conditions import write_conditions
from .names.symbols import UNKNOWN
from .phases.short_forms import default_mesh, exact_mesh, is_discrete, is_static, write_out
from .schema import messages
from .schema.declarations import Time
from .schema.fields import CALLED, STORED
from .schema.solving import ENGINES, Solver
from .schema.spec import Spec
from .schema.tables import called_names
from .tables.files import read_files
from .text import brief, printable
from .vectors import write_out as vectors
from .wishes.keys import meant
from .yaml.document import MAX_BYTES, Document, decode, dotted, read_document, scalar
from .yaml.document import Path as Place
from .yaml.locations import Finding, Locations
from .yaml.overrides import override

_LOADS = "makes the solver load a library"
_UNSAFE: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "hsllib": (_LOADS, lambda value: True),
    "pardisolib": (_LOADS, lambda value: True),
    "linear_solver": (_LOADS, lambda value: str(value).lower() != "mumps"),
    "linear_system_scaling": (_LOADS, lambda value: str(value).lower() == "mc19"),
    "output_file": ("makes the solver write a file", lambda value: True),
    "print_level": ("makes the solver print all that it has", lambda value: _above(value, LOUDEST)),
    "print_options_documentation": ("makes the solver print a book", lambda value: True),
}
"""What only the command line may set: option -> what it does, and whether a value does that."""

LOUDEST = 5  # of IPOPT's 12 levels: a line for each iteration

_OPTION_FILE = "option_file_name"
"""What nothing may set: options of a file of IPOPT's own would stand in no message, no check and no result."""

OptionCheck = Callable[[str, Mapping[str, Any]], Sequence[Mistake]]
"""(engine, options) -> what the engine does not take, each mistake at solver.NAME."""

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
    return load_text(_read(source), str(source), overrides, methods, options, source.parent, more)


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
    document, numbers, overrides, (mistaken, counted) = _without_loops(read_document(text, file), overrides)
    write_conditions(document.data, is_static(document.data))
    document, given, overrides, (origin, wrong, sizes) = _without_vectors(document, overrides, numbers)
    data, locations, early = _written_out(document, file, overrides, given, origin)
    early += mistaken + wrong
    if options and isinstance(data.get("solver"), dict):
        early += _refused_options(data["solver"], options, {str(finding.path[-1]) for finding in early})
    context = {"methods": tuple(methods), CALLED: called_names(data)}
    unread = read_files(data, folder)
    early += unread
    try:
        spec = Spec.model_validate(data, context=context)
    except ValidationError as error:
        rest = repair(data, error)
        found = early + messages.findings(error, locations) + (_checked(rest, False, more)[0] if rest else [])
        raise SpecError(locations.mistakes(found)) from None
    errors, warnings = _checked(spec, not early, more)
    if errors or early:
        raise SpecError(locations.mistakes(early + errors))
    unused = {("parameters", name) for name in counted | sizes}
    told = [w for w in (*warnings, *_empty(data)) if w.path not in unused or "nowhere" not in w.what]
    return spec.attach(text, locations, told)


def _without_loops(
    document: Document, overrides: Sequence[str]
) -> tuple[Document, dict[Place, str], Sequence[str], tuple[list[Finding], frozenset[str]]]:
    """The document with its templates written out, by parameters that are overridden before.

    Also the paths of these, the overrides that remain, the mistakes in templates, and the parameters that these go by.
    """
    if not loops.has_loops(document.data):
        return document, {}, overrides, ([], frozenset())
    numbers = [text for text in overrides if text.strip().startswith("parameters.")]
    data, given = override(document, numbers)
    expanded = loops.written_out(data, document.lines)
    rest = [text for text in overrides if text not in numbers]
    return Document(expanded.data, expanded.lines, document.blocks), given, rest, (expanded.findings, expanded.counted)


def _without_vectors(
    document: Document, overrides: Sequence[str], before: dict[Place, str]
) -> tuple[Document, dict[Place, str], Sequence[str], tuple[dict[Place, Place], list[Finding], frozenset[str]]]:
    """The document with its vectors written out, by what is overridden in it before.

    before: the paths of earlier overrides.

    Also the paths of all overrides so far, those that remain, where what is made comes from, the mistakes in vectors,
    and the parameters that sizes go by.
    """
    if not vectors.has_vectors(document.data):
        return document, before, overrides, ({}, [], frozenset())
    now = [text for text in overrides if vectors.concerns(text.partition("=")[0].strip(), document.data)]
    data, given = override(document, now)
    made = vectors.written_out(data)
    rest = [text for text in overrides if text not in now]
    document = Document(made.data, document.lines, document.blocks)
    return document, before | given, rest, (made.origin, made.findings, made.counted)


def _written_out(
    document: Document, file: str, overrides: Sequence[str], before: dict[Place, str], made: dict[Place, Place]
) -> tuple[dict[str, Any], Locations, list[Finding]]:
    """The data of a file as the schema knows it: overrides applied, short forms written out, what is left out chosen.

    Also where each value was given, and what is wrong so far. before: the overrides that templates and vectors were
    made by. made: where the components of vectors come from.
    """
    chosen = default_mesh()
    asked = [(key,) for key in ("mesh", "refine") if document.data.get(key) is not None]
    if document.data.get("mesh") is None:
        document.data["mesh"] = chosen  # so that an override finds its entries
    data, given = override(document, overrides)
    if data.get("mesh") is None:
        data["mesh"] = chosen
    wrong = _default_tolerance(data) if data["mesh"] is chosen else []
    static = is_static(data)
    if static or is_discrete(data):
        wrong += exact_mesh(data, asked, given)
    elif data["mesh"] is chosen and data.get("refine") is None and not _meshes_of_phases(data):
        data["refine"] = {}
    of_chain, mistaken = write_out_chain(data)
    wrong += mistaken
    made |= {path: path for path in given}
    locations = Locations(file, document.lines, before | given, document.blocks, of_chain | write_out(data), made)
    data.setdefault("name", printable(Path(file).stem))
    early = wrong + _unsafe_options(data.get("solver"), locations)
    _measured_objective(data)
    if static:
        return data, locations, early
    if data.get("phases") or data.get("waypoints"):
        _shared_objective(data)
        return data, locations, early
    early += _missing(data)
    if not (data.get("states") or data.get("model") or _meant("states", data, Spec.model_fields)):
        early.append(NO_STATES)
    return data, locations, early


def _checked(spec: Spec, whole: bool, more: MoreChecks | None) -> tuple[list[Finding], list[Finding]]:
    """The mistakes and warnings of `check_spec` and of more checks, which need phases without mistakes."""
    errors, warnings = check_spec(spec, whole)
    if more is not None and not (errors and (spec.phases or spec.waypoints)):
        own, odd = more(spec)
        errors, warnings = errors + own, warnings + odd
    return errors, warnings


def _missing(data: dict[str, Any]) -> list[Finding]:
    """The times that a file without phases does not give; something that no check says anything of takes their place.

    With phases these may stand in the first and in the last of them.
    """
    if data.get("time") is None:
        data["time"] = {"initial": UNKNOWN, "final": UNKNOWN}
        if _meant("time", data, Spec.model_fields):
            return []
        return [Finding(("time",), "time is missing", f"add {messages.how_written(('time',))}")]
    found = []
    time = data.get("time")
    if not isinstance(time, dict):
        return []
    given = dict(time)
    for end in ("initial", "final"):
        if time.get(end) is not None:
            continue
        time[end] = UNKNOWN
        if not _meant(end, given, Time.model_fields, ("time",)):
            remedy = f"add {messages.how_written(('time', end))}"
            found.append(Finding(("time", end), f"{end} is missing", remedy))
    return found


def _empty(data: Any, path: Place = ()) -> Iterator[Finding]:
    """Bounds and ends without a value, which count as left out."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        if value is None and key in ("lower", "upper", "equals", "initial", "final") and len(path) > 1:
            yield Finding((*path, key), f"{key}: is empty, and counts as left out", f"write a value, or remove {key}:")
        if isinstance(value, dict | list):
            yield from _empty(value, (*path, key))


def _meant(key: str, given: Mapping[str, Any], known: Mapping[str, Any], path: Place = ()) -> bool:
    """Whether a key that is none, with a value, is a misspelt one that is missing."""
    others = (other for other, value in given.items() if other not in known and value is not None)
    return any(meant((*path, other), known) == key for other in others)


def _measured_objective(data: dict[str, Any]) -> None:
    """With measurements, their residuals are an objective by themselves."""
    phases = data.get("phases")
    owners = [data, *(phases.values() if isinstance(phases, dict) else ())]
    owners = [own for own in owners if isinstance(own, dict)]
    if any(own.get("measurements") for own in owners) and not any(own.get("objective") for own in owners):
        data["objective"] = {"minimize": {}}


def _shared_objective(data: dict[str, Any]) -> None:
    """An objective that stands in phases alone: the file's is of the same sense, without terms."""
    phases = data.get("phases")
    if data.get("objective") is not None or not isinstance(phases, dict):
        return
    for own in phases.values():
        objective = own.get("objective") if isinstance(own, dict) else None
        for sense in ("minimize", "maximize"):
            if isinstance(objective, dict) and sense in objective:
                data["objective"] = {sense: {}}
                return


def _meshes_of_phases(data: dict[str, Any]) -> bool:
    """Whether a phase says what its mesh is."""
    phases = data.get("phases")
    return isinstance(phases, dict) and any(isinstance(own, dict) and own.get("mesh") for own in phases.values())


def _default_tolerance(data: dict[str, Any]) -> list[Finding]:
    """Without `mesh:`, `solver: {tol: ...}` is the tolerance of the mesh that a file gets; what is wrong with it."""
    solver = data.get("solver")
    if not isinstance(solver, dict) or "tol" not in solver:
        return []
    data["solver"] = {name: value for name, value in solver.items() if name != "tol"}
    tolerance = solver["tol"]
    if isinstance(tolerance, bool) or not isinstance(tolerance, int | float) or not 0 < tolerance < 1:
        what = f"the tolerance of the solver is {brief(tolerance)}"
        return [Finding(("solver", "tol"), what, "write a number between 0 and 1, such as 1.0e-8")]
    data["mesh"][0]["tolerance"] = tolerance
    return []


def load_stored(data: Mapping[str, Any], file: str) -> Spec:
    """The spec that a result holds, full; a result is foreign data, so it is checked as a problem file is.

    data: plain, nested no deeper than Python can follow.
    file: the result, for messages.

    What only the command line may set is left out: nobody has given it on this one. Raises FileError if it is no spec
    of this version.
    """
    solver, locations = data.get("solver"), Locations(file, dict.fromkeys(_paths(data), 1))
    if unsafe := {finding.path[1] for finding in _unsafe_options(solver, locations)}:
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


def _unsafe_options(solver: Any, locations: Locations) -> list[Finding]:
    """Options that a file may not set; IPOPT also knows them in capitals, and behind a prefix such as "resto."."""
    found = []
    for name in solver if isinstance(solver, dict) else ():
        plain = name.lower().rpartition(".")[2]
        if plain == _OPTION_FILE:
            what = f"{brief(name)} makes the solver read options that trajopt cannot check and the result does not tell"
            remedy = "remove it, and write each of its options as solver.NAME, in the file or with --set"
            found.append(Finding(("solver", name), what, remedy))
        does, unsafe = _UNSAFE.get(plain, ("", bool))
        if does and unsafe(solver[name]) and not locations.overridden(("solver", name)):
            what = f"{brief(name)} {does}, which a problem file may not do: it is data, never code"
            remedy = f"remove it, and give it on the command line: --set solver.{brief(name)}=..."
            found.append(Finding(("solver", name), what, remedy))
    return found


def _above(value: Any, most: float) -> bool:
    number = scalar(value) if isinstance(value, str) else value
    return isinstance(number, int | float) and number > most


def _refused_options(solver: dict[str, Any], options: OptionCheck, known: set[str]) -> list[Finding]:
    """What the engine itself says of the options that the schema has nothing to say of."""
    own = {*Solver.model_fields, "tol", *known}
    plain = {name: value for name, value in solver.items() if name not in own and isinstance(value, int | float | str)}
    plain = {name: _yes_or_no(value) if isinstance(value, bool) else value for name, value in plain.items()}
    engine = solver.get("engine", "ipopt")
    mistakes = options(engine, plain) if engine in ENGINES else ()
    return [Finding(("solver", m.where.removeprefix("solver.")), m.what, m.remedy) for m in mistakes]


def _yes_or_no(value: bool) -> str:
    return "yes" if value else "no"


def _read(path: Path) -> str:
    """The text of the file. Raises FileError with the reason, SpecError if it is not text."""
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
        reason = (error.strerror or str(error)).lower()
        raise FileError(Mistake(str(path), f"the file cannot be read ({reason})", "check its permissions")) from error
    if content.startswith(b"\x89HDF"):
        what = "this is a result, not a problem file"
        remedy = f"give its problem file; the result is read by trajopt show {path}, plot, table and verify"
        raise SpecError(Mistake(str(path), what, remedy))
    return decode(content, str(path))
