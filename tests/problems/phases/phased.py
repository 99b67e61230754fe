"""A move of the double integrator in phases."""

from pathlib import Path

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.results.file.write import image_of
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve

MOVE = """
trajopt: 1
name: move
states:
  x: {rate: v, unit: m, initial: 0, final: 1}
  v: {rate: u, unit: m/s, initial: 0, final: 0}
controls: {u: {unit: m/s^2}}
time: {initial: 0, final: 1}
phases:
  first: {}
  second: {time: {initial: {lower: 0.2, upper: 0.8}}}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 6}]
"""


CURVE = 12.0  # the exact least integral of u**2 for x: 0 -> 1 in a time of 1, which no waypoint on it changes


def loaded(text: str, *overrides: str):
    return load_text(text, "x.yaml", overrides)


def solved(text: str, *overrides: str, **options):
    spec = loaded(text, *overrides)
    solution = solve(build(spec), schedule_of(spec), options.pop("settings", settings_of(spec)), **options)
    assert solution.solved, solution.status
    return solution


def written(solution, spec, folder) -> Path:
    path = folder / "a.h5"
    path.write_bytes(image_of(solution, spec.text, spec.model_dump_json(), "test"))
    return path
