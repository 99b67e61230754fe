"""No message is in pydantic's words: every value of a full file is replaced by values of the wrong kind or range."""

import copy
import json
import re
from functools import reduce
from typing import get_args

import broken
import pytest
from named import share
from pydantic import BaseModel

from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.problems.schema.messages import EXAMPLES, how_written
from trajopt.problems.schema.spec import Spec
from trajopt.problems.yaml.document import read_document, value_of
from trajopt.transcription.loading import load_all

# Every section and every key that the good file leaves out, so that the walk meets it.
FULL = {
    "name": "full",
    "source": "a book",
    "note": "a remark",
    "tags": ["free-time", "smooth"],
    "units": "off",
    "nonsmooth": {"tanh": [0.01]},
    "scaling": {"u": 5},
    "refine": {"tolerance": 1e-3, "max_meshes": 2, "objective": 1e-4},
    "residuals": ["m*v[rate] - F", {"name": "force", "expression": "F - u + c*v"}],
    "algebraic": {"F": {"unit": "N", "lower": -9, "upper": 9, "note": "a force"}},
    "integrals": {"work": {"value": "u*v", "unit": "J", "note": "by the control"}},
    "mesh": [
        {"method": "radau", "segments": [1, 2], "tolerance": 1e-6, "degree": [3, 4], "form": "integral"},
        {"method": "runge-kutta-4", "segments": 10, "substeps": 2, "control": "linear"},
    ],
    "solver": {
        "library": "bundled",
        "engine": "ipopt",
        "accept": "optimal",
        "coarse_start": True,
        "seconds": 60,
        "starts": 2,
        "seed": 1,
        "max_iter": 100,
    },
    "drawing": [
        {"line": [["0", "0"], ["x", "1"]], "color": "green", "dashed": True, "name": "rod"},
        {"point": ["x", "0"], "trail": True},
        {"circle": ["x", "0"], "radius": 0.1, "trail": "whole"},
        {"box": ["x", "0"], "width": 0.1, "height": 0.2, "angle": "x", "obstacle": True},
        {"ground": 0},
    ],
    "continuation": {"parameters.m": [3, 2.5]},
    "reference": {"objective": 6.0, "tolerance": 1e-6, "source": "a book"},
    "sweep": {"over": {"parameters.c": "1:2:3"}, "zip": False, "sample": 4, "seed": 1, "chain": False},
}
PHASES = {
    "phases": {
        "near": {
            "note": "the first", "time": {"initial": {"value": 0}, "final": {"lower": 0.5, "upper": 2, "guess": 1}},
            "parameters": {"extra": {"value": 0.2, "unit": "1", "note": "another"}}, "expressions": {"twice": "2*v"},
            "states": {"x": {"final": {"lower": 0, "upper": 1}}}, "controls": {"u": {"upper": 4}},
            "algebraic": {"F": {"upper": 8}}, "residuals": ["m*v[rate] - F", "F - u"], "without": ["p"],
            "integrals": {"work": "u"},
            "objective": {"minimize": {"integral": "u**2 + v**2"}}, "guess": {"constants": {"u": 1}},
            "constraints": {"path": [{"expression": "v", "upper": 9}]}, "mesh": [{"method": "radau", "segments": 3}],
        },
        "far": {},
    },
    "links": [
        {"from": "near", "to": "far", "except": ["p"]},
        {"name": "kept", "expression": "far.v[initial] - near.v[final]", "lower": -1, "upper": 1},
        {"expression": "far.p[initial]", "equals": 0.5},
    ],
    "constraints": {"boundary": [{"expression": "near.x[final]", "upper": 3}]},
}  # fmt: skip
WAYPOINTS = {
    "waypoints": [{"name": "gate", "time": {"lower": 0.5, "upper": 2, "guess": 1}, "states": {"x": {"value": 0.5}}}],
    "constraints": {},
}
MEASURED = {
    "measurements": {
        "run": {"data": {"time": [0.5, 1], "x": [0.1, None], "v": [1, 2]}, "source": "a book", "note": "the first",
                "compare": {"x": "x + c"}, "weights": {"x": 2}},
        "again": {"data": {"time": [0.5, 1], "x": [0.1, 0.2]}, "deviations": 0.1},
    },
    "guess": {"formulas": {"u": "1 - t"}, "data": {"time": [0, 2], "x": [0, 1]}},
}  # fmt: skip
PAIRS = {"complementarity": [{"name": "contact", "a": "x + 2", "b": "u + 9", "relax": [0.1, 0.01]}]}
CHAIN = {
    "model": {
        "kind": "chain", "base": "cart", "gravity": 9.8, "angles": "relative", "zero": "up",
        "cart": {"mass": "m", "motor": "u", "force": "-dx"},
        "links": [
            {"name": "arm", "mass": 1, "length": "d", "com": 0.5, "inertia": 0.1, "motor": True, "zero": "left"},
            {"parent": "arm", "at": 0.4, "mass": 1, "length": 1, "torque": "-q2", "angle": "q2"},
            {"joint": "fixed", "turn": 0.1, "mass": 1, "length": 1},
            {"joint": "prismatic", "distance": "slid", "mass": 1, "length": 1},
        ],
        "forces": [{"link": "arm", "at": 0.2, "x": "u", "y": 1}],
        "loops": [{"link": "link4", "at": 0.5, "to": "base", "x": 1, "y": 0.5}],
    },
    "states": {"v": {"unit": "m/s", "rate": "u - c*v", "initial": 0}},
    "residuals": ["F - u"],
}  # fmt: skip
WALKER = {
    "model": {
        "kind": "chain", "zero": "up", "step": {"foot": "b", "swap": [["a", "b"]]},
        "links": [{"name": "a", "mass": 1, "length": 1}, {"name": "b", "mass": 1, "length": 1, "zero": "down"}],
    },
    "states": {"x": {"rate": "v"}, "v": {"unit": "m/s", "rate": "u - c*v", "initial": 0}},
    "residuals": ["F - u"],
}  # fmt: skip
PINNED = {
    **WALKER,
    "model": {
        "kind": "chain", "loops": [{"link": "arm", "at": 0.5, "to": "last", "to_at": 0.5}],
        "links": [{"name": name, "mass": 1, "length": 1} for name in ("arm", "middle", "last")],
    },
}  # fmt: skip
# Keys that exclude others of the full file.
OTHERS = {
    "phases": PHASES,
    **dict.fromkeys(("model", "cart", "links"), CHAIN),
    "step": WALKER,
    "to_at": PINNED,
    **dict.fromkeys(("complementarity", "relax"), PAIRS),
    "measurements": MEASURED,
    "waypoints": WAYPOINTS,
    "maximize": {"objective": {"maximize": {"integral": "u**2", "terminal": "x[final]"}}},
    "sqrt": {"nonsmooth": {"sqrt": [0.01]}},
}
WRONG = {
    "a list": [[1, "x"]], "no items": [], "a mapping": {"a": {"b": 1}}, "nothing in it": {}, "text": "no such thing",
    "true": True, "negative": -1, "zero": 0, "broken": 1.5, "huge": 1e300, "infinite": float("inf"),
    "NaN": float("nan"), "null": None,
}  # fmt: skip
OF_THE_FILE = re.compile(
    "unknown name|already declared|as many residuals as|everything in it is fixed|no phase|is not a state"
)
FOREIGN = re.compile(
    r"Input should|valid (integer|number|boolean|string|dictionary|list)|unable to|Value error|union|validation|"
    r"pydantic|should have|at most \d+ after|Field |NoneType|<class|Traceback|\b(dict|str|bool|float|int)\b|"
    r"\b(Spec|Terms|Entry|EndValue|TimeEnd|Static|PlainValidator|function-)\b"
)


def full_data(key=None):
    """A file with every key, but for those that exclude each other: then it has the given one."""
    data = read_document(broken.IMPLICIT, "full.yaml").data | copy.deepcopy(FULL | OTHERS.get(key, {}))
    data["tables"] = {
        "rho": {"points": {"h": [0, 1, 2]}, "values": [3, 2, 1], "kind": "linear", "smooth": 0.1, "outside": "hold",
                "unit": "kg", "units": {"h": "m"}, "source": "a book", "note": "air"},
        "wind": {"points": {"h": [0, 1], "v": [0, 1]}, "values": [[1, 2], [3, 4]], "outside": {"h": "error"}},
    }  # fmt: skip
    data["time"]["final"] = 2 if "measurements" in data else {"lower": 1, "upper": 3, "guess": 2}
    data["states"]["p"] = {
        "unit": "rad", "accel": "u - p", "note": "an angle", "initial": {"lower": 0, "upper": 1}, "final": {"value": 1},
        "history": "0.1*t",
        "velocity": {"name": "w", "unit": "rad/s", "lower": -9, "upper": 9, "initial": 0, "final": 0, "note": "speed"},
    }  # fmt: skip
    return data


def paths(node, path=()):
    """The path of every value."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in items:
        yield (*path, key)
        yield from paths(value, (*path, key))


def models(model):
    """A model of the schema and all those below it."""
    yield model
    for field in model.model_fields.values():
        for part in types_in(field.annotation):
            if isinstance(part, type) and issubclass(part, BaseModel):
                yield from models(part)


def types_in(annotation):
    """The types that an annotation is made of."""
    yield annotation
    for part in get_args(annotation):
        yield from types_in(part)


def replaced(data, path, value):
    """The data with another value at a path."""
    data = copy.deepcopy(data)
    reduce(lambda node, key: node[key], path[:-1], data)[path[-1]] = value
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
    keys = set()
    for data in (full_data(), *map(full_data, OTHERS)):
        assert load_text(written(data), "full.yaml", (), broken.METHODS).reference.source == "a book"
        keys |= {path[-1] for path in paths(data)}
    known = {field.alias or key for model in models(Spec) for key, field in model.model_fields.items()}
    # a CSV file (see test_tables_files), other dynamics (see broken.timeless), and what is only written in short
    assert known - keys == {"next", "file", "arguments", "simulate", "apart"}


@pytest.mark.parametrize(("number", "value"), list(enumerate(WRONG.values())), ids=WRONG.keys())
def test_no_message_is_foreign(number, value):
    """Each value in a fifth of the places, another fifth for the next value."""
    full = full_data()
    phased = full_data("phases")
    of_phases = [path for path in paths(phased) if path[0] in ("phases", "links")]
    robots = {own: full_data(own) for own in ("model", "step", "to_at")}
    of_chains = [(data, path) for data in robots.values() for path in paths(data) if path[0] == "model"]
    places = [*((full, path) for path in paths(full)), *((phased, path) for path in of_phases), *of_chains]
    for whole, path in share(places, 5, first=number % 5):
        data = replaced(whole, path, value)
        try:
            load_text(written(data), "full.yaml", (), broken.METHODS)
        except SpecError as error:
            known = {tuple(".".join(map(str, known)).split(".")) for known in paths(data)} | {()}
            for mistake in error.mistakes:
                assert mistake.what and mistake.remedy, mistake
                assert not FOREIGN.search(f"{mistake.what}; {mistake.remedy}"), (path, str(mistake))
                where = place(mistake)
                assert where in known or ("missing" in mistake.what and where[:-1] in known), (path, str(mistake))


@pytest.mark.parametrize("key", EXAMPLES)
def test_an_example_is_right(key):
    """Wherever a message gives it, it makes no mistake, but that its names may not go with those of the file."""
    full = full_data(key)
    matches = [
        path for path in paths(full) if path[-1] == key and how_written(path) == f"for example {key}: {EXAMPLES[key]}"
    ]
    assert matches, key
    for example in EXAMPLES[key].split(", or "):
        for path in matches:
            try:
                load_text(written(replaced(full, path, value_of(example, key))), "full.yaml", (), broken.METHODS)
            except SpecError as error:
                inside = [m for m in error.mistakes if place(m)[: len(path)] == path]
                assert not [m for m in inside if not OF_THE_FILE.search(m.what)], example


def test_the_mistakes_of_all_files_go_through_the_command_line(tmp_path):
    path = tmp_path / "full.yaml"
    path.write_text(written(full_data()))
    (spec,) = load_all([str(path)])
    assert spec.name == "full"
