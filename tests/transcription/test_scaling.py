"""Automatic scaling: the documented rule, the same answers, and help where units are bad."""

import json

import h5py
import numpy as np
import pytest
from named import share

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.results.file.write import write
from trajopt.transcription.layout import bounded_start
from trajopt.transcription.program.compiler import compile_model
from trajopt.transcription.scaling import scale
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import transcribe

BAD_UNITS = """
trajopt: 1
name: block in bad units
parameters: {micro: 1.0e-6, mega: 1.0e+6}
time: {initial: 0, final: 1}
states:
  x: {rate: v*mega, initial: 0, final: 1}
  v: {rate: u*1.0e-3, initial: 0, final: 0}
  s: {rate: (u*1.0e-3*mega)**2/100 - s, initial: 0}
controls:
  u: {lower: -20*1.0e-3, upper: 20*1.0e-3}
objective: {minimize: {integral: "(u*1.0e-3*mega)**2*mega"}}
guess: {constants: {v: 1.0e-6}}
mesh: [{method: hermite-simpson, segments: 20}]
"""


def compiled(name: str):
    spec = load(shipped()[name])
    (problem,) = build_all(spec)[-1:]
    transcription = transcribe(problem, [steps(spec.mesh)[-1].mesh()])
    return transcription, compile_model(transcription.model, transcription.variables), bounded_start(transcription)[0]


def run(spec):
    return solve(build_all(spec), steps(spec.mesh), settings_of(spec))


def test_sizes_follow_the_rule():
    transcription, nlp, z = compiled("cartpole")
    scaling = scale(transcription, nlp, z, {})
    assert scaling.sizes["q1"] == pytest.approx(2)  # half of -2 .. 2
    assert scaling.sizes["q2"] == pytest.approx(2 * np.pi)
    assert scaling.sizes["u"] == pytest.approx(20)
    assert scaling.sizes["v1"] == 1  # no bounds, and zero along the guess
    (layout,) = transcription.phases
    assert scaling.z[layout.u[0]] == pytest.approx(1 / 20)
    for family in transcription.families:
        assert scaling.g[family.rows(nlp)] == pytest.approx(1 / scaling.sizes[family.name])


def test_given_sizes_count():
    transcription, nlp, z = compiled("cartpole")
    scaling = scale(transcription, nlp, z, {"v2": 8.0})
    (layout,) = transcription.phases
    assert scaling.z[layout.x[3]] == pytest.approx(1 / 8)


def test_a_steep_objective_is_flattened():
    spec = load_text(BAD_UNITS.replace("1.0e-3*mega)**2*mega", "1.0e-3*mega)**2*mega + 1.0e+9*x"), "bad.yaml")
    (problem,) = build_all(spec)
    transcription = transcribe(problem, [steps(spec.mesh)[0].mesh()])
    nlp, z = compile_model(transcription.model, transcription.variables), bounded_start(transcription)[0]
    scaling = scale(transcription, nlp, z, {})
    assert np.abs(scaling.objective * nlp.gradient(z) / scaling.z).max() == pytest.approx(100)


SCALED = ["brachistochrone", "cartpole", "bryson_denham", "biped", "van_der_pol", "shot_put"]


@pytest.mark.parametrize("name", share(SCALED, 2))
def test_the_answer_does_not_depend_on_scaling(name):
    plain, scaled = (run(load(shipped()[name], [f"scaling={choice}"])) for choice in ("none", "auto"))
    assert plain.solved
    assert scaled.solved
    assert scaled.objective == pytest.approx(plain.objective, rel=1e-6)
    for a, b in zip(plain.trajectories, scaled.trajectories, strict=True):
        scale = np.abs(a.point_costate).max()
        assert b.x == pytest.approx(a.x, abs=2e-4)
        assert b.point_costate == pytest.approx(a.point_costate, abs=1e-2 * scale)


def test_bad_units_are_mended():
    """The minimum-force block with velocities in 1e-6 and forces in 1e-3 units: as many iterations as in good ones."""
    spec = load_text(BAD_UNITS, "bad.yaml", ["scaling={u: 0.006, v: 1.5e-6}"])
    scaled = run(spec)
    assert scaled.solved
    assert scaled.objective == pytest.approx(12e6, rel=1e-6)


def test_the_choice_is_stored(tmp_path):
    spec = load(shipped()["cartpole"], ["scaling={v2: 8}"])
    write(tmp_path / "a.h5", run(spec), spec.text, spec.model_dump_json(), "test")
    with h5py.File(tmp_path / "a.h5") as file:
        sizes = json.loads(file["solver"].attrs["scaling"])
        assert sizes["v2"] == 8
        assert sizes["u"] == 20
        assert json.loads(file["spec/full"].asstr()[()])["scaling"] == {"v2": 8.0}
