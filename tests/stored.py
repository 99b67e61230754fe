"""Result files of shipped problems, each solved once."""

from functools import cache

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.results.store import write
from trajopt.transcription.settings import Settings, steps
from trajopt.transcription.solve import solve


@cache
def solved(name: str, **options):
    spec = load(shipped()[name])
    return spec, solve(build(spec), steps(spec.mesh), Settings(options))


def save(path, name: str = "shot_put", **options):
    spec, solution = solved(name, **options)
    write(path, solution, spec.text, spec.model_dump_json(), "trajopt solve it")
    return path
