"""The shipped problems, the JSON Schema, and what becomes of a file: numbers, ranges, functions, guesses."""

import json
import re
from math import inf, pi

import broken
import numpy as np
import pytest
import yaml
from named import FAMILIES
from pydantic import BaseModel
from repository import ROOT

from trajopt.problems.build import build
from trajopt.problems.catalog import find_problem, shipped, start_new
from trajopt.problems.errors import FileError
from trajopt.problems.expressions.functions import smooth_names
from trajopt.problems.language.json_schema import schema
from trajopt.problems.load import load, load_text
from trajopt.problems.quantities import MAX_DEGREE, Range
from trajopt.problems.schema.spec import Spec
from trajopt.transcription.schemes.runge_kutta import TABLES
from trajopt.transcription.schemes.table import DEFAULT_DEGREE, INTEGRAL_DEGREE

DOCS = (ROOT / "docs" / "problem_file.md").read_text()
SHIPPED = [*shipped().values(), find_problem("cartpole").with_name("template.yaml")]


def built(*edits: tuple[str, str]):
    """The problem of the good file with some edits."""
    text = broken.GOOD
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    return build(load_text(text, "good.yaml", methods=broken.METHODS))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_problem_loads_and_builds(path):
    spec = load(path, methods=broken.METHODS)
    assert not spec.warnings
    assert spec.source and spec.file == str(path) and spec.text == path.read_text()
    assert path.stem == "template" or (spec.reference is not None and spec.tags)
    assert spec.text.startswith("# ")
    for phase in build(spec).phases:
        values = phase.guess.samples(np.array([0.0, 0.5, 1.0]))
        values |= {"t": np.array([0.0, 0.5, 1.0]), **phase.guess.parameters}
        assert all(np.all(np.isfinite(state.rate(values, np))) for state in phase.states)
        assert all(np.all(np.isfinite(residual.function(values, np))) for residual in phase.residuals)


@pytest.fixture(scope="module")
def validator():
    """What a file of the schema is held against; the schema itself is checked once."""
    validators = pytest.importorskip("jsonschema").validators
    made = schema(broken.METHODS)
    kind = validators.validator_for(made)
    kind.check_schema(made)
    return kind(made)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_json_schema_accepts_the_shipped_problems(path, validator):
    validator.validate(yaml.load(path.read_text(), yaml.CSafeLoader))


def test_json_schema_refuses_what_the_loader_refuses(validator):
    jsonschema = pytest.importorskip("jsonschema")
    good = yaml.safe_load(broken.GOOD)
    validator.validate(good)
    wrong = [("mesh", 0, {"method": "euler", "segments": 1}), ("states", "x", {"rate": []}), ("time", "end", 1)]
    for section, key, value in wrong:
        bad = json.loads(json.dumps(good))
        bad[section][key] = value
        with pytest.raises(jsonschema.ValidationError):
            validator.validate(bad)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({key: value for key, value in good.items() if key != "states"}, schema())


def test_the_examples_of_the_docs_are_right():
    whole, example, *more = re.findall(r"```yaml\n(.*?)```", DOCS, re.DOTALL)
    static, discrete = (next(own for own in more if word in own) for word in ("hyperbola", "next:"))
    assert load_text(static, "docs.yaml").static and load_text("trajopt: 1\n" + discrete, "docs.yaml").discrete
    spec = load_text(whole, "docs.yaml")
    assert spec.name == "block move" and not spec.warnings and spec.text == whole
    rest = "{trajopt: 1, time: {initial: 0, final: 1}, parameters: {m: 1, k: 1}, controls: {u: {}}, "
    rest += "objective: {minimize: {integral: u**2}}, mesh: [{method: any, segments: 1}], "
    data = yaml.safe_load(rest + "name: docs}") | yaml.safe_load(example)
    spec = load_text(json.dumps(data), "docs.yaml")
    (phase,) = build(spec).phases
    assert [state.name for state in phase.states] == ["q", "v", "p", "r", "w", "s"] and not spec.warnings
    assert [z.name for z in phase.algebraic] == ["F", "v[rate]", "s[rate]"] and len(phase.residuals) == 3


def sections() -> dict[str, str]:
    """Each key of a file -> its row in the documentation."""
    rows = [line.split(" | ") for line in DOCS[DOCS.index("| key |") :].split("\n\n")[0].splitlines()[2:]]
    return {key: " ".join(row[1:]) for row in rows for key in re.findall(r"`(\w+)`", row[0])}


def keys(definition: dict) -> set[str]:
    """The keys of a mapping of the schema, or of the items of a list or a mapping of names."""
    parts = [definition, *definition.get("anyOf", []), definition.get("items", {})]
    parts.append(definition.get("additionalProperties") or {})
    inner = [
        schema()["$defs"][part["$ref"].split("/")[-1]] for part in parts if isinstance(part, dict) and "$ref" in part
    ]
    return {key for part in parts for key in part.get("properties", {})}.union(*map(keys, inner))


def test_every_key_stands_in_the_docs():
    """The sections in the table, their keys in the row of the section; all others somewhere."""
    rows = sections()
    assert rows.keys() == Spec.model_fields.keys()
    for section, definition in schema()["properties"].items():
        written = set(re.findall(r"\w+", " ".join(re.findall(r"`(.*?)`", rows[section]))))
        assert keys(definition) - {"expression", "value", "for"} <= written, section  # every entry may be a template
    everywhere = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`]+)`", re.sub("```", "", DOCS)))))
    assert {key for definition in schema()["$defs"].values() for key in keys(definition)} <= everywhere


def test_the_docs_and_the_schema_name_the_methods_and_functions():
    assert f"`{' '.join(smooth_names())}`" in DOCS
    for name in (*FAMILIES, *(table.name for table in TABLES)):
        assert f"`{name}`" in DOCS
    degree = schema()["$defs"]["Mesh"]["properties"]["degree"]
    assert degree["description"].startswith(f"of {', '.join(FAMILIES)}: ")
    assert f"default {DEFAULT_DEGREE}" in degree["description"] and f"(default {DEFAULT_DEGREE})" in DOCS
    assert f"`degree` from 1 to {MAX_DEGREE}" in DOCS
    form = schema()["$defs"]["Mesh"]["properties"]["form"]["description"]
    assert f"differential from degree {INTEGRAL_DEGREE + 1} on" in form
    assert f"`differential` from degree {INTEGRAL_DEGREE + 1} on" in DOCS


def test_every_field_is_described():
    models = [schema(), *schema()["$defs"].values()]
    objects = [part for model in models for part in [model, *model.get("anyOf", [])] if "properties" in part]
    assert len(objects) > 10
    assert all(field.get("description") for part in objects for field in part["properties"].values())


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_full_spec_is_a_problem_file_again(path):
    spec = load(path)
    again = load_text(spec.model_dump_json(), "again.yaml")
    assert again.model_dump() == spec.model_dump()


def test_cartpole():
    problem = build(load(find_problem("cartpole")))
    (phase,) = problem.phases
    q2, v1 = phase.states[1], phase.states[2]
    assert (problem.sense, phase.initial_time, phase.final_time) == (1, Range(0, 0), Range(2, 2))
    assert q2.bounds == Range(-2 * pi, 2 * pi) and q2.initial == Range(0, 0) and q2.final == Range(pi, pi)
    assert phase.controls[0].bounds == Range(-20, 20)
    # (6.1) at q2 = 1, v2 = 2, u = 3
    expected = (0.5 * 0.3 * np.sin(1) * 4 + 3 + 0.3 * 9.81 * np.cos(1) * np.sin(1)) / (1 + 0.3 * np.sin(1) ** 2)
    assert v1.rate({"q2": 1.0, "v2": 2.0, "u": 3.0}, np) == pytest.approx(expected, rel=1e-14)
    assert phase.guess.samples(np.array([0.5]))["q2"] == pytest.approx(pi / 2)


def test_functions_and_ranges():
    problem = built()
    (phase,) = problem.phases
    assert phase.states[0].rate.names == {"v"}
    assert phase.states[1].rate.names == {"u", "c", "v"}
    assert phase.states[1].rate({"u": 3.0, "c": 0.5, "v": 2.0}, np) == 1.0
    assert phase.lagrange({"u": 3.0}, np) == 9.0
    assert phase.mayer({"x[final]": 2.0, "v[final]": 3.0, "c": 0.5}, np) == 6.25
    assert [c.name for c in (*phase.path, *phase.boundary, *phase.integral)] == [
        "speed limit",
        "x_final_x_initial",
        "power",
    ]
    assert phase.boundary[0].bounds == Range(1 - 2e-6, 1 + 2e-6)  # both ends of x are given
    assert phase.implied == {"x_final_x_initial": ("x[final]", "x[initial]")}
    assert phase.integral[0].bounds == Range(-inf, 100)
    assert phase.integral[0].function({"u": 3.0, "v": 2.0}, np) == 6.0
    assert problem.parameters[0].bounds == Range(0.1, 0.5)


def test_ends_lie_inside_the_bounds():
    (phase,) = built(("final: d}", "final: {lower: 1}}"), ("initial: 0, final: {lower", "final: {lower")).phases
    assert phase.states[0].final == Range(1, 2) and phase.states[0].initial == Range(-2, 2)


def test_maximize_and_free_times():
    problem = built(("{minimize", "{maximize"), ("final: T}", "final: {lower: 1, upper: 3}}"))
    assert problem.sense == -1
    assert problem.phases[0].final_time == Range(1, 3) and problem.phases[0].guess.final_time == 2


KEYFRAMES = "guess:\n  constants: {u: 1}\n  keyframes: {time: [0, 1, 2], x: [0, 0.5, 1]}"


@pytest.mark.parametrize(
    ("guess", "s", "x", "v", "u"),
    [
        ("guess: linear", [0, 1], [0, 1], [0, 0], [0, 0]),
        ("", [0, 1], [0, 1], [0, 0], [0, 0]),
        ("guess: {constants: {v: d/2, u: 1}}", [0, 1], [0, 1], [0.5, 0.5], [1, 1]),
        ("guess: {keyframes: {x: [0, 1, 3*d, 1]}}", [0, 1 / 3, 2 / 3, 1], [0, 1, 3, 1], [0] * 4, [0] * 4),
        ("guess: {keyframes: {time: [5, 6, 9], u: [1, 2, 3]}}", [0, 0.25, 1], [0, 0.25, 1], [0] * 3, [1, 2, 3]),
    ],
)
def test_guesses(guess, s, x, v, u):
    found = built((KEYFRAMES, guess)).phases[0].guess
    assert found.s == pytest.approx(s)
    assert {name: pytest.approx(row) for name, row in found.values.items()} == {"x": x, "v": v, "u": u}
    assert found.parameters == {"c": 0.3}


@pytest.mark.parametrize(
    ("ends", "expected"),
    [
        ("initial: 0, final: 1", [0, 1]),
        ("initial: 0.5", [0.5, 0.5]),
        ("final: 0.5", [0.5, 0.5]),
        ("initial: {lower: 0, upper: 1}, final: 2", [0.5, 2]),
        ("lower: 0, upper: 9, initial: 0.5", [0.5, 0.5]),
        ("initial: 0, final: {lower: 1}", [0, 1]),
        ("lower: 1", [1, 1]),
        ("lower: -4, upper: -1", [-1, -1]),
        ("upper: -1", [-1, -1]),
    ],
)
def test_linear_guess_of_a_state(ends, expected):
    text = f"""{{trajopt: 1, states: {{x: {{rate: u, {ends}}}}}, controls: {{u: {{lower: 2}}}},
        time: {{initial: 0, final: 1}}, objective: {{minimize: {{integral: u**2}}}},
        mesh: [{{method: any, segments: 1}}]}}"""
    guess = build(load_text(text, "state.yaml")).phases[0].guess
    assert guess.values["x"].tolist() == expected and guess.values["u"].tolist() == [2, 2]


def test_a_spec_made_in_python_builds():
    spec = Spec.model_validate(yaml.safe_load(broken.GOOD.replace("1e-8", "1.0e-8")))
    assert build(spec).name == "a good file"


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("name", ["cartpole", "cartpole.yaml"])
def test_shipped_problems_by_name(name):
    assert find_problem(name) == shipped()["cartpole"]


@pytest.mark.parametrize(("name", "says"), [("cartpol", "did you mean cartpole?"), ("no/x.yaml", "look into no")])
def test_a_name_that_is_not_shipped(name, says):
    with pytest.raises(FileError, match=says.replace("?", r"\?")):
        find_problem(name)


def test_a_file_of_ones_own_comes_before_a_shipped_one(folder):
    (folder / "cartpole.yaml").write_text(broken.GOOD)
    assert load(find_problem("cartpole.yaml")).name == "a good file"


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("name", "source"), [("my_problem", "template"), ("swing: up.yaml", "cartpole")])
def test_a_new_file_starts_from_another(name, source):
    path = start_new(name, source)
    assert path.suffix == ".yaml" and load(path).name == path.stem
    with pytest.raises(FileError, match="--force"):
        start_new(name, source)
    start_new(name, source, force=True)


def test_what_a_file_leaves_out_is_what_an_empty_entry_says():
    """Defaults are made without a validator, which is built at the first file."""
    for name, field in Spec.model_fields.items():
        if isinstance(field.default, BaseModel) and name != "model":
            own = type(field.default)
            assert field.default == own() == own.model_validate({}), name
            assert field.default.model_dump() == own().model_dump()
