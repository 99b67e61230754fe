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
        ("k*(u - T{i})", "the rate of T1 is in K/s"),
        ("(u - S)/k", 'unknown name "S"'),
        ("1/(k - k)*(u - T{i})", "divides by zero"),
    ],
)
def test_a_loop_is_told_once(folder, rate, words):
    (folder / "loop.yaml").write_text(LOOP.replace("RATE", rate))
    run = trajopt("check", "loop.yaml")
    errors = [line for line in run.output.splitlines() if line.startswith("error:")]
    assert run.exit_code == 2 and len(errors) == 1
    assert "loop.yaml:5: states.T1.rate" in errors[0] and words in errors[0] and "11 more of this line" in errors[0]


def test_two_of_one_line_are_both_told(folder):
    (folder / "two.yaml").write_text(LOOP.replace("N: 12", "N: 2").replace("T12", "T2").replace("RATE", "k*(u - T{i})"))
    run = trajopt("check", "two.yaml")
    assert sum(line.startswith("error:") for line in run.output.splitlines()) == 2


@pytest.mark.parametrize("word", ["unit", "pcs/day", "1000 particles", "points"])
def test_a_word_that_is_no_unit(folder, word):
    text = LOOP.replace("unit: K", f"unit: {word}").replace("RATE", "(u - T{i})/k")
    (folder / "words.yaml").write_text(text)
    run = trajopt("check", "words.yaml")
    assert run.exit_code == 0 and f'"{word}" is no unit that can be checked' in run.output
