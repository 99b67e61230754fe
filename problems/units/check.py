"""The units of a whole file: of each phase by itself, and of what connects them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..expressions.tree import Name
from ..language.plain import shared_in_plain
from ..phases.merge import home, phases_in_plain
from ..phases.order import expression_links, passages
from ..schema.phases import LinkEntry
from ..schema.sections import ConstraintEntry
from ..schema.spec import Spec
from ..text import brief
from ..yaml.document import Path, dotted
from ..yaml.locations import Finding
from .chains import in_chain
from .infer import Reader, Value, mended
from .measure import Measure, same
from .phase import PhaseUnits, TermUnit


def check_units(spec: Spec) -> tuple[list[Finding], list[Finding]]:
    """What does not fit together in the units of a file, and the units that are none.

    spec: of a file whose phases and links are what they should be; other mistakes in it make values unknown.
    """
    if spec.units == "off" or not _has_units(spec):
        return [], []
    phases = {name: PhaseUnits(own) for name, own in phases_in_plain(spec, marked=True).items()}
    terms = [term._replace(path=home(spec, name, term.path)) for name, own in phases.items() for term in own.check()]
    told = {name: in_chain(own.spec, own, own.findings) for name, own in phases.items()}
    errors = [f._replace(path=home(spec, name, f.path)) for name, own in told.items() for f in own]
    unknown = {home(spec, name, path): text for name, own in phases.items() for path, text in own.unknown.items()}
    if len(phases) > 1:
        across = _Across(shared_in_plain(spec, marked=True)[0], phases)
        terms += across.check()
        errors += [*across.reader.findings, *_passages(spec, phases)]
    errors += _objective(terms)
    return list(dict.fromkeys(errors)), [_unreadable(path, text) for path, text in unknown.items()]


def _has_units(spec: Spec) -> bool:
    """Whether a file gives a unit to anything but the time, which has one by default."""
    for own in (spec, *spec.phases.values()):
        for group in ("parameters", "expressions", "tables", "states", "controls", "algebraic", "optimize"):
            for entry in getattr(own, group, {}).values():
                if entry.unit or getattr(entry, "units", None) or getattr(getattr(entry, "velocity", None), "unit", ""):
                    return True
    return False


class _Across:
    """What is said of the ends of several phases, and of the whole trajectory."""

    def __init__(self, spec: Spec, phases: Mapping[str, PhaseUnits]):
        self.spec, self.phases = spec, phases
        self.shared = PhaseUnits(spec)
        symbols = self.shared.symbols
        shared = self.shared.reader
        self.reader = Reader(self._of, shared.tables, shared.functions, symbols.constant_value, symbols.is_constant)

    def check(self) -> list[TermUnit]:
        """Look at everything. Returns the term of the objective that is of the whole trajectory."""
        for i, link in expression_links(self.spec):
            self._condition(("links", i), link)
        for i, entry in enumerate(self.spec.constraints.boundary):
            self._condition(("constraints", "boundary", i), entry)
        for name, row in self.spec.guess.keyframes.items():
            wanted = self.shared.time if name == "time" else self._of(Name(0, 0, name, None))
            for i, value in enumerate(row):
                self.reader.agree(("guess", "keyframes", name, i), value, wanted, f"{name} is")
        terminal = self.spec.objective.terms.terminal
        path: Path = ("objective", self.spec.objective.sense, "terminal")
        return [] if terminal is None else [TermUnit(path, self.reader.read(path, terminal))]

    def _condition(self, path: Path, entry: LinkEntry | ConstraintEntry) -> None:
        if entry.expression is not None:
            value = self.reader.read((*path, "expression"), entry.expression)
            self.reader.bounds(path, entry, value, "the expression")

    def _of(self, name: Name) -> Value:
        """The unit of a name, which may be that of a phase, a point, and a name in it; see `phases.between`."""
        phase, dot, inner = name.name.partition(".")
        if dot:
            return self.phases[phase].of(inner) if phase in self.phases else None
        if phase in self.spec.parameters or phase in self.spec.optimize:
            return self.shared.of(phase)
        owners = [own for own in self.phases.values() if phase in own.symbols.roles]
        return owners[-1 if name.end == "final" else 0].of(phase) if owners else None


def _passages(spec: Spec, phases: Mapping[str, PhaseUnits]) -> Iterator[Finding]:
    """States that go on from phase to phase keep their unit."""
    for own in passages(spec):
        before, after = phases[own.source], phases[own.target]
        for state in before.symbols.states:
            a, b = before.of(state.name), after.of(state.name)
            if state.name not in own.left_out and isinstance(a, Measure) and isinstance(b, Measure) and not same(a, b):
                path: Path = ("links", own.number) if own.number is not None else ("phases", own.target)
                what = f"{state.name} goes on from {own.source}, {a.told}, to {own.target}, {b.told}"
                remedy = f"give it one unit, or write except: [{state.name}] and a link that converts it"
                yield Finding(path, what, remedy)


def _objective(terms: list[TermUnit]) -> Iterator[Finding]:
    """The terms of the objective, which are added, are in one unit."""
    known = [(path, value) for path, value in terms if isinstance(value, Measure)]
    for path, value in known[1:]:
        first, of_first = known[0]
        if not same(value, of_first):
            of = " over time" if path[-1] == "integral" else ""
            what = f"this term is{of} {value.told}, and is added to that of {dotted(first)}, which is {of_first.told}"
            yield Finding(
                path, what, "give it a weight, a parameter with the unit that is missing: " + mended(value, of_first)
            )


def _unreadable(path: Path, text: str) -> Finding:
    what = f'"{brief(text)}" is no unit that can be checked, so nothing is said of what has it'
    return Finding(path, what, "write one such as m/s^2, kg*m^2 or 1/day, or units: off")
