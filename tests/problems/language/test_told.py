"""What is said of vectors is said once, and in the words of the file: never of the scalars that they stand for."""

import re

import pytest

from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.problems.units.check import check_units

FILE = """\
trajopt: 1
parameters: {J: [1, 2, 3], m: 2, A: [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]}
time: {initial: 0, final: 1}
states:
  r: {size: 3, unit: m, rate: v, initial: 0, final: [1, 0, 0]}
  v: {size: 3, unit: m/s, rate: "F/m - A @ r", initial: 0, final: 0}
controls:
  F: {size: 3, lower: -10, upper: 10}
objective: {minimize: {integral: "dot(F, F)"}}
drawing: [{circle: "r[1..2]", radius: 0.1}]
constraints:
  path:
    - {name: near, expression: r/J, upper: 5}
"""
RATE = '"F/m - A @ r"'


def told(old: str, new: str) -> list[str]:
    """All that is said of the file with a change in it, mistakes and warnings, without the name of the file."""
    assert FILE.count(old) == 1
    try:
        spec = load_text(FILE.replace(old, new), "x.yaml", more=check_units)
    except SpecError as error:
        return [str(own).removeprefix("x.yaml:") for own in error.mistakes]
    return [str(own).removeprefix("x.yaml:") for own in spec.warnings]


CASES = [
    # One mistaken vector: its own mistake, and nothing that follows from it.
    ("r: {size: 3", "r: {size: M", ["5: states.r.size", "M is no parameter that is a whole number"]),
    ("v: {size: 3", "v: {size: 0", ["6: states.v.size", "the size is 0"]),
    ("F: {size: 3", "F: {size: true", ["8: controls.F.size", "this is no size"]),
    ("r: {size: 3", "r: {size: 4", ["5: states.r.rate", "r is a vector of 4, and its rate a vector of 3", "size: 3"]),
    ("r: {size: 3, ", "r: {", ["5: states.r.rate", "r is one value, and its rate a vector of 3", "size: 3 beside it"]),
    ("objective:", "optimize: {p: {size: N}}\nobjective:", ["9: optimize.p.size", "N is no parameter"]),
    ("lower: -10", "lower: 20", ["8: controls.F.lower: lower 20 is above upper 10"]),
    ("rate: v, ", "", ["5: states.r: nothing determines how r changes", "residuals: with r[rate] in one of them"]),
    ("final: [1, 0, 0]", "upper: 0.5, final: [1, 0, 0]", ["5: states.r.final.0", "0.5 of r[1]"]),
    # Names that are declared nowhere come before shapes that nobody knows.
    (RATE, '"F/m - A @ w"', ["6: states.v.rate", 'unknown name "w"']),
    (RATE, '"F/m - cross(F, w)"', ["6: states.v.rate", 'unknown name "w"']),
    ('"dot(F, F)"', '"dot(F, w) + m"', ["9: objective.minimize.integral", 'unknown name "w"']),
    # Functions that there are none of.
    (RATE, '"cros(F, r) - A @ r"', ["6: states.v.rate", '"cros(F, r)": there', "cros; did you mean cross?"]),
    (RATE, '"quat_rotate(F, r)"', ["6: states.v.rate", "did you mean rotate?"]),
    (RATE, '"matmul(A, r)"', ["6: states.v.rate", "there is no function matmul; write A @ x"]),
    ('"dot(F, F)"', '"dott(F, F)"', ["9: objective.minimize.integral", "did you mean dot?"]),
    # A matrix times a vector.
    (RATE, "F/m - A*r", ["6: states.v.rate", '"A*r": a matrix of 3 by 3 and a vector of 3', "; write A @ r"]),
    (RATE, "F/m - r*A", ["6: states.v.rate", '"r*A": a vector of 3', "; write r @ A"]),
    ("r/J", "m*A*v", ["13: constraints.path.0.expression", '"m*A*v"', "; write m*A @ v"]),
    # Units, in the words of the file.
    (RATE, '"F/m - r"', ["6: states.v.rate: the rate of v is in m/s^2, and \"F/m - r\" in m"]),
    ("unit: m, ", "unit: kg, ", ["5: states.r.rate: the rate of r is in kg/s, and \"v\" in m/s"]),
    ("rate: v,", 'rate: ["v[1]", "v[2]", "r[3]"],', ["5: states.r.rate.2", "the rate of r[3]", '"r[3]" in m']),
    # Drawings.
    ('"r[1..2]"', "r", ["10: drawing.0.circle: this is a vector of 3, and a point is a vector of 2; write r[1..2]"]),
    ('"r[1..2]"', '"k*r[1..2]"', ["10: drawing.0.circle", 'unknown name "k"']),
    ("radius: 0.1", "radius: F", ["10: drawing.0.radius: this is a vector of 3, and has to be one value"]),
    # What is used nowhere.
    ("r/J", "r", ["2: parameters.J: the parameter J is used nowhere"]),
    ("m: 2", "m: 2, B: [[1, 2], [3, 4]]", ["2: parameters.B: the parameter B is used nowhere"]),
    ("objective:", "optimize: {p: {size: 3}}\nobjective:", ["9: optimize.p: the static parameter p is used nowhere"]),
    # Lists by the names of what is no vector.
    ("objective:", "guess: {constants: {G: [0, 0, 1]}}\nobjective:", ["9: guess.constants.G: G is not a state"]),
    ("objective:", "scaling: {q: 3}\nobjective:", ["9: scaling.q", "those that have one are r, v[1], v[2], ..."]),
    ("objective:", "waypoints: [{s: [1, 2, 3]}]\nobjective:", ["9: waypoints.0.s: s is not a state", "are r, v"]),
    ("objective:", "expressions: {half(a): k*a, w: half(r)}\nobjective:", ["9: expressions.half(a)", 'name "k"']),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "says"), CASES, ids=lambda own: own if isinstance(own, str) else "")
def test_one_sentence_in_the_words_of_the_file(old, new, says):
    sentences = told(old, new)
    assert len(sentences) == 1, "\n".join(sentences)
    assert sentences[0].startswith(says[0])
    assert all(part in sentences[0] for part in says)
    assert not re.search(r"\b[rvFAJpB][1-9]+\b", sentences[0])


def test_mistakes_of_one_text_are_all_told():
    sentences = told(RATE, '"k*F - A*r"')
    assert len(sentences) == 2
    assert any("; write A @ r" in own for own in sentences) and any('unknown name "k"' in own for own in sentences)


def test_a_vector_of_which_one_component_is_used_is_used():
    assert not told("expression: r/J", 'expression: "r/J[1]"')
    assert not told("expression: r/J", 'expression: "r/J + A[1, 2]*r"')
    assert not told("upper: 5", 'upper: "J[2]"')


def test_a_function_of_a_file_without_vectors_is_not_proposed_one_of_vectors():
    text = (
        "trajopt: 1\ntime: {initial: 0, final: 1}\nstates: {x: {rate: crs(x)}}\nobjective: {minimize: {integral: x}}\n"
    )
    with pytest.raises(SpecError) as error:
        load_text(text, "x.yaml")
    assert "did you mean cross" not in str(error.value)
