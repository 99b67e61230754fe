"""A file, a shipped name or a text -> a problem that is checked and ready to be solved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ...problems.errors import Mistake
from ...problems.lean.records import dataclass
from ...problems.problem import Problem
from ...problems.schema.spec import Spec
from ...problems.yaml.overrides import as_text
from ...transcription.loading import build_checked, load_file, load_yaml
from .messages import python_words

Overrides = Mapping[str, object] | Sequence[str]


@dataclass(frozen=True, repr=False, eq=False)
class LoadedProblem:
    """What `trajopt.load` gives and `trajopt.solve` takes.

    spec: the problem file with every default; `spec.model_dump()` gives it as plain data.
    stages: the continuous problem of each entry of the mesh schedule.
    """

    spec: Spec
    stages: tuple[Problem, ...]

    @property
    def name(self) -> str:
        """The name that the file gives the problem, or that of the file."""
        return self.spec.name

    @property
    def warnings(self) -> tuple[Mistake, ...]:
        """What is odd in the file but can be solved; `str()` of each is a sentence."""
        return self.spec.warnings

    def __repr__(self) -> str:
        return repr(self.spec).replace("<Spec ", "<Problem ", 1)


def load(source: str | Path, overrides: Overrides = ()) -> LoadedProblem:
    """Load a problem and check all of it.

    source: a file, the name of a shipped problem such as "cartpole", or the text of a problem file: a string with a
        line break in it.
    overrides: path -> value, such as {"parameters.u_max": 12, "mesh.*.segments": 50}, or texts such as
        "parameters.u_max=12", applied in turn as if they stood in the file. None as a value takes the key away.

    Raises FileError if there is no such file, and SpecError with all the mistakes in the problem and the overrides;
    both have `mistakes`, and `str()` gives their sentences.
    """
    with python_words():
        given = as_texts(overrides)
        is_text = isinstance(source, str) and "\n" in source
        spec = load_yaml(str(source), given) if is_text else load_file(str(source), given)
        (stages,) = build_checked([spec])
    return LoadedProblem(spec, tuple(stages))


def as_texts(overrides: Overrides) -> list[str]:
    """Overrides as "PATH=VALUE" each. Raises SpecError for a value that no problem file can hold."""
    if isinstance(overrides, Mapping):
        return as_text(overrides)
    return [overrides] if isinstance(overrides, str) else list(overrides)
