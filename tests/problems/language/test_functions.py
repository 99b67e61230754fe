"""Functions of the file: what a call means, in every place where an expression may stand."""

import numpy as np
import pytest

import trajopt
from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load, load_stored, load_text

HEAD = "trajopt: 1\ntime: {initial: 0, final: 2}\ncontrols: {u: {}}\n"
PLAIN = (
    HEAD
    + """\
parameters: {k: 0.3, H: 5}
expressions: {power: {value: (0.5*k*v**2*exp(-x/H))*v, unit: W}}
states:
  x: {rate: v, initial: 0, final: 1}
  v: {rate: u - 0.5*k*v**2*exp(-x/H), initial: 0.5}
objective: {minimize: {integral: u**2 + (0.1*u**2)**2, terminal: "0.5*k*v[final]**2*exp(-x[final]/H) + power[final]"}}
constraints: {path: [{expression: 0.5*k*(v + 1)**2*exp(-2/H), upper: 2.0}]}
"""
)
CALLED = (
    HEAD
    + """\
parameters: {k: 0.3, H: 5}
expressions:
  drag(v, h): 0.5*k*sq(v)*exp(-h/H)
  sq(a): a**2
  power: {value: "drag(v, x)*v", unit: W}
  own(v): {value: "drag(v, x)", note: at the height that the state has}
states:
  x: {rate: v, initial: 0, final: 1}
  v: {rate: "u - drag(v, x)", initial: 0.5}
objective: {minimize: {integral: sq(u) + sq(0.1*sq(u)), terminal: "own(v[final]) + power[final]"}}
constraints: {path: [{expression: "drag(v + 1, 2)", upper: 2.0}]}
"""
)


def functions(text):
    problem = build(load_text(text, "x.yaml"))
    phase = problem.phases[0]
    return [*phase.over_time, *phase.at_ends, *(output.function for output in phase.outputs.values())]


def test_a_call_has_the_value_of_what_it_stands_for():
    random = np.random.default_rng(3)
    values = {name: random.uniform(0.2, 1.5, 7) for name in ("t", "x", "v", "u", "x[final]", "v[final]", "u[final]")}
    pairs = list(zip(functions(PLAIN), functions(CALLED), strict=True))
    assert len(pairs) == 6
    for plain, called in pairs:
        np.testing.assert_allclose(called(values, np), plain(values, np), rtol=1e-14)


def test_it_is_solved_as_what_it_stands_for():
    plain, called = (trajopt.solve(trajopt.load(text)) for text in (PLAIN, CALLED))
    assert plain.solved and called.solved
    assert called.objective == pytest.approx(plain.objective, rel=1e-10)


def test_a_function_of_a_phase_takes_the_place_of_the_shared_one():
    spec = load(shipped()["headwind_ride"], ["phases.back.expressions={'drag(b)': 7*b}"])
    out, back = build(spec).phases
    values = {"t": 0.0, "x": 1.0, "v": 5.0}
    assert out.lagrange(values, np) == pytest.approx(0.2 * 8**2 * 5 / 1000)
    assert back.lagrange(values, np) == pytest.approx(7 * 2 * 5 / 1000)


def test_a_link_takes_the_phase_of_the_arguments():
    """`w` and the state x are those of the phase that v is of."""
    link = "links=[{expression: 'gust(out.v[final]) - gust(back.v[initial])', equals: 0}]"
    text = shipped()["headwind_ride"].read_text().replace("  effort:", "  gust(v): drag(v + w)*x\n  effort:")
    spec = load_text(text, "ride.yaml", [link])
    function = build(spec).links[-1].function
    values = {"out.v[final]": 2.0, "out.x[final]": 10.0, "back.v[initial]": 8.0, "back.x[initial]": 4.0}
    assert function(values, np) == pytest.approx(0.2 * 5**2 * 10 - 0.2 * 5**2 * 4)


def test_its_body_can_be_set():
    spec = load(shipped()["headwind_ride"], ["expressions.drag(a)=a"])
    assert build(spec).phases[0].lagrange({"t": 0.0, "x": 0.0, "v": 1.0}, np) == pytest.approx(4 / 1000)


def test_a_result_holds_it():
    spec = load_text(CALLED, "x.yaml")
    again = load_stored(spec.model_dump(mode="json"), "x.h5")
    assert again.expressions["drag(v, h)"].value.text == "0.5*k*sq(v)*exp(-h/H)"
    assert build(again).phases[0].states[1].rate.text == "u - drag(v, x)"


def test_one_that_is_not_called_is_told_of():
    spec = load_text(CALLED.replace("own(v[final]) + ", ""), "x.yaml")
    assert ["expressions.own(v)" in str(w) and "used nowhere" in str(w) for w in spec.warnings] == [True]


@pytest.mark.parametrize(
    ("body", "call"),
    [("a*a", "sq(" * 20 + "u" + ")" * 20), ("-(-(-(-(-(-(-(-(-(-a)))))))))", "sq(" * 20 + "u" + ")" * 20)],
    ids=["size", "depth"],
)
def test_what_would_be_too_large_is_told(body, call):
    """A function of a function of a function doubles with each, written out; nothing of that is built."""
    with pytest.raises(SpecError) as error:
        load_text(CALLED.replace("sq(a): a**2", f"sq(a): {body}").replace("sq(u) + sq", f"{call} + sq"), "x.yaml")
    assert [str(m) for m in error.value.mistakes if "objective.minimize.integral" in str(m) and "too large" in str(m)]


@pytest.mark.parametrize("signature", ["drag(v, )", "drag(v, 2h)", "drag(v, pi)"])
def test_calls_of_a_function_with_a_mistaken_argument_bring_no_mistakes_of_their_own(signature):
    text = CALLED.replace("drag(v, h): 0.5*k*sq(v)*exp(-h/H)", f'"{signature}": 0.5*k*sq(v)')
    with pytest.raises(SpecError) as error:
        load_text(text.replace("drag(v, x)", "drag(v)"), "x.yaml")
    assert all(f"x.yaml:6: expressions.{signature}: argument 2" in str(own) for own in error.value.mistakes)
