"""Numbers of several expressions: the bits that a walk over the trees gives, shared parts once, few values held."""

import random
import weakref

import numpy as np
import pytest

from trajopt.problems.expressions.evaluation import Walk
from trajopt.problems.expressions.expression import parse, together
from trajopt.problems.probe import depends_on, names_asked

from .texts import NAMES, random_text

ARRAYS = {name: value * np.linspace(0.5, 1.5, 7) for name, value in NAMES.items()}


class Counting:
    """NumPy, which counts how often a function is called."""

    def __init__(self):
        self.calls = []

    def __getattr__(self, name):
        self.calls.append(name)
        return getattr(np, name)


@pytest.mark.parametrize("seed", range(20))
def test_the_bits_of_a_walk(seed):
    rng = random.Random(seed)
    definitions = {"a": parse(random_text(rng, 3)), "b": parse(f"a*({random_text(rng, 2)})")}
    texts = [f"{random_text(rng, 3)} + b*a", "b", f"sin(b)/(3 + cos({random_text(rng, 3)}))", "x"]
    expressions = [parse(text).bind({"u_max": 2.5}, definitions) for text in texts]
    for values in (ARRAYS, {name: ARRAYS[name] for name in ("x", "y", "q1")}, NAMES):
        walked = [Walk(values, np).evaluate(own) for own in expressions]
        alone = [own(values, np) for own in expressions]
        for shared, own, value in zip(together(expressions)(values, np), alone, walked, strict=True):
            np.testing.assert_array_equal(shared, value)
            np.testing.assert_array_equal(own, value)


def test_a_part_that_several_need_is_computed_once():
    definitions = {"c": parse("cos(x)"), "d": parse("exp(c) + c**2")}
    expressions = [parse(text).bind({}, definitions) for text in ("d*sin(y)", "d/sin(y) + cos(x)", "c")]
    counting = Counting()
    together(expressions)(ARRAYS, counting)
    assert sorted(counting.calls) == ["cos", "exp", "sin"]


def test_functions_that_are_no_expressions_are_called_one_by_one():
    values = together([parse("2*x"), lambda own, functions: functions.sin(own["x"])])(NAMES, np)
    assert values == [2 * NAMES["x"], np.sin(NAMES["x"])]


def test_a_parameter_counts_unless_it_is_among_the_values():
    own = parse("k*x").bind({"k": 3.0}, {})
    assert (own({"x": 2.0}, np), own({"x": 2.0, "k": 5.0}, np)) == (6.0, 10.0)


@pytest.mark.parametrize("seed", range(10))
def test_the_names_that_are_asked_for_are_those_of_a_call(seed):
    """An expression has a list of them; of any other function they are found out by a call."""
    rng = random.Random(seed)
    definitions = {"a": parse(random_text(rng, 3)), "b": parse("a*q1 + 0*y")}
    for text in (random_text(rng, 3), "b[final] - x[initial]", "0*u_max + a", "2*pi"):
        own = parse(text).bind({"u_max": 2.5}, definitions)
        called = names_asked(lambda values, functions, own=own: own(values, functions))
        assert names_asked(own) == called
        assert not depends_on(own, {"absent", *NAMES} - called)


def test_values_are_not_held_when_nothing_needs_them_any_more():
    """Each of 40 functions of functions is an array that only the next one needs."""
    made, most = [], 0

    class Watching:
        def sin(self, value):
            nonlocal most
            made.append(weakref.ref(value))
            most = max(most, sum(own() is not None for own in made))
            return np.sin(value)

    text = "x"
    for _ in range(40):
        text = f"sin({text})"
    parse(text)({"x": np.ones(3)}, Watching())
    assert (len(made), most) == (40, 2)  # x, which is the caller's, and what is at work
