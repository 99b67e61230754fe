"""`dataclass` of problems/lean beside that of the standard library."""

import copy
import dataclasses
import pickle
from dataclasses import field

import pytest

from trajopt.problems.lean import records


@records.dataclass(frozen=True)
class Point:
    """Frozen."""

    x: float
    y: list = field(default_factory=list, compare=False)
    name: str = field(default="p", repr=False)


@records.dataclass(frozen=True)
class Mass(Point):
    """A subclass with a keyword of its own, and what is computed from it."""

    kg: float = field(kw_only=True, default=1)

    def __post_init__(self):
        object.__setattr__(self, "x", self.x * self.kg)


def own_and_library(body: dict, **options):
    """The same class, made by either."""
    made = []
    for make in (records.dataclass, dataclasses.dataclass):
        kind = type("Pair", (), {"__doc__": "Pair.", "__annotations__": {"a": int, "b": object}, "b": 2, **body})
        made.append(make(**options)(kind))
    return made


OPTIONS = [
    {},
    {"frozen": True},
    {"frozen": True, "eq": False},
    {"frozen": True, "repr": False, "eq": False},
    {"eq": False},
]


@pytest.mark.parametrize("options", OPTIONS)
@pytest.mark.parametrize("body", [{}, {"__repr__": lambda self: "mine", "__eq__": lambda self, other: True}])
def test_it_is_told_compared_and_hashed_as_by_the_library(options, body):
    ours, theirs = own_and_library(body, **options)
    seen = []
    for kind in (ours, theirs):
        one, same, other = kind(1), kind(1), kind(1, b=[3])
        shown = repr(one) if type(one).__repr__ is not object.__repr__ else "address"
        alike = (one == same, one == other, one == (1, 2), one != same)
        hashes = kind.__hash__ and (hash(one) == hash(same))
        seen.append((shown, alike, hashes, kind.__match_args__))
    assert seen[0] == seen[1]


@pytest.mark.parametrize("options", OPTIONS)
def test_what_is_frozen_stays(options):
    for kind in own_and_library({}, **options):
        one = kind(1)
        for change in (lambda: setattr(one, "a", 5), lambda: setattr(one, "c", 5), lambda: delattr(one, "b")):  # noqa: B023
            if options.get("frozen"):
                with pytest.raises(dataclasses.FrozenInstanceError):
                    change()
                assert vars(one) == {"a": 1, "b": 2}
            else:
                change()


def test_a_hash_needs_hashable_fields():
    ours, theirs = own_and_library({}, frozen=True)
    for kind in (ours, theirs):
        with pytest.raises(TypeError, match="unhashable"):
            hash(kind(1, []))


def test_fields_have_their_say():
    assert Point(1, [2]) == Point(1, [3]) and Point(1) != Point(1, name="q") and hash(Point(1, [2])) == hash(Point(1))
    assert repr(Point(1, [2])) == "Point(x=1, y=[2])" and Point(1).y is not Point(1).y


def test_a_subclass_is_another():
    mass = Mass(1, kg=3)
    assert mass != Point(3) and mass.x == 3 and repr(mass) == "Mass(x=3, y=[], kg=3)"
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot assign to field 'kg'"):
        mass.kg = 4


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_it_is_copied_and_replaced(again):
    point = Point(1, [2], "q")
    assert again(point) == point and again(point).y == [2]
    assert dataclasses.replace(point, x=4) == Point(4, name="q") and dataclasses.is_dataclass(point)


def test_one_that_holds_itself_is_told():
    point = Point(1, [])
    point.y.append(point)
    assert repr(point) == "Point(x=1, y=[...])"


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ((), {}),
        ((1, 2, 3), {}),
        ((1,), {"a": 2}),
        ((1,), {"c": 3}),
        ((), {"b": 1}),
        ((1, 2), {"a": 1, "b": 2}),
        ((), {"c": 3}),
        ((), {"b": 1, "c": 3}),
        ((1, 2), {"c": 3}),
    ],
)
def test_wrong_arguments_are_refused_as_by_the_library(values, named):
    for kind in own_and_library({}, frozen=True):
        with pytest.raises(TypeError):
            kind(*values, **named)


@pytest.mark.parametrize(("values", "named"), [((1,), {}), ((1, 5), {}), ((), {"b": 5, "a": 1}), ((1,), {"b": 5})])
def test_fields_are_given_by_place_or_by_name(values, named):
    ours, theirs = own_and_library({})
    assert vars(ours(*values, **named)) == vars(theirs(*values, **named))


def test_a_field_by_name_alone():
    assert Mass(1, [], "q", kg=2).kg == 2
    with pytest.raises(TypeError, match="has the fields x, y, name, kg"):
        Mass(1, [], "q", 2)
