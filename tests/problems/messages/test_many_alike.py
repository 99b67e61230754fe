"""What is wrong with a loop is told once; words that pint takes for units by accident are none."""

import pytest
from command_line import trajopt

LOOP = """\
trajopt: 1
parameters: {N: 12, k: {value: 1, unit: s}}
time: {initial: 0, final: 1}
states:
  T{i}: {for: i in 1..N, unit: K, rate: "RATE", initial: 0}
controls: {u: {unit: K, lower: 0, upper: 1}}
objective: {minimize: {integral: T12**2}}
"""


@pytest.mark.parametrize(
    ("rate", "words"),
    [
        ("k*(u - T{i})", 'the rate of T{i} is in K/s, and "k*(u - T{i})" in K*s'),
        ("(u - S)/k", 'unknown name "S"'),
        ("1/(k - k)*(u - T{i})", "divides by zero"),
    ],
)
def test_a_loop_is_told_once(folder, rate, words):
    (folder / "loop.yaml").write_text(LOOP.replace("RATE", rate))
    run = trajopt("check", "loop.yaml")
    errors = [line for line in run.output.splitlines() if line.startswith("error:")]
    assert run.exit_code == 2 and len(errors) == 1
    assert "loop.yaml:5: states.T{i}.rate" in errors[0] and words in errors[0]


IN_TEMPLATES = [
    ('"RATE"', '"(u - d{i})/k"', "states.T{i}.rate", 'unknown name "d{i}"; '),
    ('"RATE"', '"u + T{i} + k"', "states.T{i}.rate", 'cannot be added to "u + T{i}", which is in K'),
    ('"RATE"', '"2 T{i}"', "states.T{i}.rate", '"2 T{i}": an operator is missing'),
    ("controls:", 'drawing: [{for: i in 1..N, point: ["{i}", "S{i}"]}]\ncontrols:', "drawing.0.point.1", '"S{i}"'),
    ("controls:", 'drawing: [{for: i in 1..N, circle: ["{i}", "T{i}"]}]\ncontrols:', "drawing.0", "the radius of"),
    ("initial: 0}\nc", "intial: 0}\nc", "states.T{i}.intial", 'unknown key "intial"; did you mean initial?'),
]


@pytest.mark.parametrize("count", [2, 12])
@pytest.mark.parametrize(("old", "new", "place", "words"), IN_TEMPLATES, ids=[own[1] for own in IN_TEMPLATES])
def test_what_holds_of_all_entries_is_said_of_the_template(folder, old, new, place, words, count):
    text = (
        LOOP.replace("N: 12", f"N: {count}")
        .replace("T12", f"T{count}")
        .replace(old, new)
        .replace("RATE", "(u - T{i})/k")
    )
    (folder / "all.yaml").write_text(text)
    run = trajopt("check", "all.yaml")
    (told,) = [line for line in run.output.splitlines() if line.startswith("error:")]
    assert f": {place}: " in told and words in told and "more of this line" not in told


def test_what_holds_of_some_is_said_of_these(folder):
    (folder / "some.yaml").write_text(LOOP.replace("RATE", "(u - T{i + 1})/k"))
    run = trajopt("check", "some.yaml")
    (told,) = [line for line in run.output.splitlines() if line.startswith("error:")]
    assert 'states.T12.rate: unknown name "T13"' in told


@pytest.mark.parametrize("word", ["unit", "pcs/day", "1000 particles", "points"])
def test_a_word_that_is_no_unit(folder, word):
    text = LOOP.replace("unit: K", f"unit: {word}").replace("RATE", "(u - T{i})/k")
    (folder / "words.yaml").write_text(text)
    run = trajopt("check", "words.yaml")
    assert run.exit_code == 0 and f'"{word}" is no unit that can be checked' in run.output
