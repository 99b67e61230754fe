"""A vector of the wrong size is told once, at its size, and not wherever it stands."""

import pytest

from trajopt.problems.errors import SpecError
from trajopt.transcription.loading import load_yaml

FLIGHT = """\
trajopt: 1
time: {initial: 0, final: 1}
parameters: {g: [0, 0, -9.81], J: [[1, 0, 0], [0, 2, 0], [0, 0, 3]]}
states:
  r: {size: 3, rate: v, initial: 0, final: 1}
  v: {size: 3, rate: u + g, initial: 0, final: 0}
  w: {size: 3, rate: J @ u, initial: 0}
controls: {u: {size: 3}}
expressions: {power: "dot(u, v)"}
objective: {minimize: {integral: "dot(u, u)"}}
"""


def told(old, new):
    assert old in FLIGHT
    with pytest.raises(SpecError) as error:
        load_yaml(FLIGHT.replace(old, new))
    return [str(mistake) for mistake in error.value.mistakes]


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [("u: {size: 3}", "u: {size: 4}",
      "text:8: controls.u.size: u is a vector of 4, and stands with vectors of 3 in states.v.rate, states.w.rate, "
      "expressions.power; write size: 3"),
     ("v: {size: 3, rate: u + g", "v: {size: 2, rate: 3*v",
      "text:6: states.v.size: v is a vector of 2, and stands with vectors of 3 in states.r.rate, expressions.power; "
      "write size: 3"),
     ('{power: "dot(u, v)"}', '{power: "dot(k, v)", sum: k + v}\nalgebraic: {k: {size: 5}}\nresiduals: [k]',
      "text:10: algebraic.k.size: k is a vector of 5, and stands with vectors of 3 in expressions.power, "
      "expressions.sum; write size: 3")],
)  # fmt: skip
def test_a_wrong_size_is_told_once(old, new, says):
    assert told(old, new) == [f"{says}, or make the others as long as it is"]


def test_what_stands_once_is_told_where_it_stands():
    (found,) = told("g: [0, 0, -9.81]", "g: [0, -9.81]")
    assert 'states.v.rate: "u + g": a vector of 3 and a vector of 2 do not go together' in found


def test_a_list_that_stands_twice_is_told_at_its_values():
    (found,) = told("g: [0, 0, -9.81]", 'g: [0, -9.81], low: "J @ g"')
    assert (
        "text:3: parameters.g: g is a vector of 2, and stands with vectors of 3" in found
        and "give it 3 values" in found
    )


@pytest.mark.parametrize("rate", ["[u, v]", '"[u, v]"', "[u, 0]"])
def test_two_rates_of_one_value_are_told_once(rate):
    text = f"""\
trajopt: 1
time: {{initial: 0, final: 1}}
states: {{x: {{rate: {rate}, initial: 0, final: 1}}}}
controls: {{u: {{}}, v: {{}}}}
objective: {{minimize: {{integral: u**2 + v**2}}}}
"""
    with pytest.raises(SpecError, match=r"states.x.rate: x is one value, and .* of 2; write size: 2") as error:
        load_yaml(text)
    assert len(error.value.mistakes) == 1
