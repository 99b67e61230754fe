"""No message is in pydantic's words: every value of a full file is replaced by values of the wrong kind or range."""

import copy
import json
import re
from functools import reduce

import broken
import pytest

from trajopt.cli.common import load_all
from trajopt.problems import yamltext
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.problems.messages import EXAMPLES
from trajopt.problems.spec import Spec

# Every section and every key that the good file leaves out, so that the walk meets it.
FULL = {
    "name": "full",
    "source": "a book",
    "note": "a remark",
    "nonsmooth": {"tanh": [0.01]},
    "scaling": {"u": 5},
    "refine": {"tolerance": 1e-3, "max_meshes": 2},
    "residuals": ["m*v[rate] - F", {"name": "force", "expression": "F - u + c*v"}],
    "algebraic": {"F": {"unit": "N", "lower": -9, "upper": 9, "note": "a force"}},
    "mesh": [
        {"method": "radau", "segments": [1, 2], "tolerance": 1e-6, "degree": [3, 4], "form": "integral"},
        {"method": "runge-kutta-4", "segments": 10, "substeps": 2, "control": "linear"},
    ],
    "solver": {"engine": "ipopt", "accept": "optimal", "coarse_start": True, "max_iter": 100},
    "reference": {"objective": 6.0, "tolerance": 1e-6, "source": "a book"},
}
WRONG = {
    "a list": [[1, "x"]], "no items": [], "a mapping": {"a": {"b": 1}}, "nothing in it": {}, "text": "no such thing",
    "true": True, "negative": -1, "zero": 0, "broken": 1.5, "huge": 1e300, "infinite": float("inf"),
    "NaN": float("nan"), "null": None,
}  # fmt: skip
FOREIGN = re.compile(
    r"Input should|valid (integer|number|boolean|string|dictionary|list)|unable to|Value error|union|validation|"
    r"pydantic|should have|at most \d+ after|Field |NoneType|<class|Traceback|\b(dict|str|bool|float|int)\b|"
    r"\b(Spec|Terms|Entry|EndValue|TimeEnd|Static|PlainValidator|function-)\b"
)


def full_data():
    data = yamltext.read(broken.IMPLICIT, "full.yaml").data | copy.deepcopy(FULL)
    data["time"]["final"] = {"lower": 1, "upper": 3, "guess": 2}
    data["states"]["p"] = {
        "unit": "rad", "accel": "u - p", "note": "an angle", "initial": {"lower": 0, "upper": 1}, "final": {"value": 1},
        "velocity": {"name": "w", "unit": "rad/s", "lower": -9, "upper": 9, "initial": 0, "final": 0, "note": "speed"},
    }  # fmt: skip
    return data


def paths(node, path=()):
    """The path of every value."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in items:
        yield (*path, key)
        yield from paths(value, (*path, key))


def value_at(path):
    return reduce(lambda node, key: node[key], path, full_data())


def replaced(path, value):
    data = full_data()
    node = data
    for key in path[:-1]:
        node = node[key]
    node[path[-1]] = value
    return data


def written(data) -> str:
    """The data as YAML; JSON writes infinity and NaN in words of its own."""
    return re.sub(r"-?\b(Infinity|NaN)\b", lambda m: {"NaN": ".nan"}.get(m[0], ".inf"), json.dumps(data))


def place(mistake) -> tuple:
    """The path that a mistake names, in full.yaml."""
    shown = re.fullmatch(r"full\.yaml:\d+(?:: (.*))?", mistake.where)
    assert shown, mistake
    return tuple(shown[1].split(".")) if shown[1] else ()


def test_the_walk_meets_every_field():
    data = full_data()
    assert load_text(written(data), "full.yaml", (), broken.METHODS).reference.source == "a book"
    keys = {path[-1] for path in paths(data)}
    assert Spec.model_fields.keys() - keys == {"model"}


@pytest.mark.parametrize("value", WRONG.values(), ids=WRONG.keys())
def test_no_message_is_foreign(value):
    for path in paths(full_data()):
        data = replaced(path, value)
        try:
            load_text(written(data), "full.yaml", (), broken.METHODS)
        except SpecError as error:
            known = {tuple(map(str, known)) for known in paths(data)} | {()}
            for mistake in error.mistakes:
                assert mistake.what and mistake.remedy, mistake
                assert not FOREIGN.search(f"{mistake.what}; {mistake.remedy}"), (path, str(mistake))
                where = place(mistake)
                assert where in known or ("missing" in mistake.what and where[:-1] in known), (path, str(mistake))


@pytest.mark.parametrize("key", EXAMPLES)
def test_an_example_is_right(key):
    """As a value of every field of that name and kind it makes no mistake of form."""
    for example in EXAMPLES[key].split(", or "):
        new = yamltext.value(example, key)
        for path in paths(full_data()):
            if path[-1] == key and isinstance(value_at(path), type(new)):
                try:
                    load_text(written(replaced(path, new)), "full.yaml", (), broken.METHODS)
                except SpecError as error:
                    assert not [m for m in error.mistakes if m.what.startswith("this must be")]


def test_the_mistakes_of_all_files_go_through_the_command_line(tmp_path):
    path = tmp_path / "full.yaml"
    path.write_text(written(full_data()))
    (spec,) = load_all([str(path)])
    assert spec.name == "full"
