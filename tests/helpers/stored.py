"""Result files of shipped problems, each solved once, and one without finite values."""

from functools import cache

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.results.file.write import write
from trajopt.transcription.settings import Settings, settings_of, steps
from trajopt.transcription.solve import solve


@cache
def solved(name: str, **options):
    spec = load(shipped()[name])
    return spec, solve(build(spec), steps(spec.mesh), Settings(options))


def save(path, name: str = "shot_put", **options):
    spec, solution = solved(name, **options)
    write(path, solution, spec.text, spec.model_dump_json(), "trajopt solve it")
    return path


NOT_FINITE = """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: log(x - 5) + u + v, initial: 0, final: 1}}
controls: {u: {}, v: {}}
objective: {minimize: {integral: u**2 + v**2}}
solver: {engine: newton}
mesh: [{method: hermite-simpson, segments: 5}]
"""


def save_not_finite(path):
    """The rate has no value at the guess, so the Newton engine ends before it has an objective."""
    spec = load_text(NOT_FINITE, "not_finite.yaml")
    solution = solve(build(spec), steps(spec.mesh), settings_of(spec))
    write(path, solution, spec.text, spec.model_dump_json(), "trajopt solve it")
    return path
