"""The template of `trajopt init`: each of its commented examples may be taken as it stands."""

import re
from pathlib import Path

import pytest
from command_line import trajopt
from repository import ROOT

pytestmark = pytest.mark.usefixtures("folder")

LINES = (ROOT / "problems" / "template.yaml").read_text().splitlines()
EXAMPLES = [match[1] for line in LINES if (match := re.match(r"# (\w+):( |$)", line))]
TOGETHER = {"algebraic": ("algebraic", "residuals"), "residuals": ("algebraic", "residuals")}


def uncommented(*keys: str) -> str:
    """The template with the examples of these keys: the line of the key, and those that stand further in."""
    lines, inside = [], False
    for line in LINES:
        if match := re.match(r"# (\w+):", line):
            inside = match[1] in keys
        inside = inside and line.startswith("#")
        lines.append(line.removeprefix("# ") if inside else line)
    return "\n".join(lines)


def solve(text: str, *arguments: str) -> None:
    Path("a.yaml").write_text(text)
    check = trajopt("check", "a.yaml", *arguments)
    assert check.exit_code == 0, check.stderr
    run = trajopt("solve", "a.yaml", "-q", *arguments)
    assert run.exit_code == 0, run.stderr


def test_all_sections_have_an_example():
    later = ["algebraic", "residuals", "optimize", "constraints", "nonsmooth", "solver", "reference"]
    assert ["tags", "expressions", "tables", *later] == EXAMPLES


@pytest.mark.parametrize("key", EXAMPLES)
def test_each_example_alone(key):
    text = uncommented(*TOGETHER.get(key, (key,)))
    assert text != "\n".join(LINES)
    solve(text)


@pytest.mark.parametrize("kind", ["path", "boundary", "integral"])
def test_each_constraint_alone(kind):
    others = "|".join({"path", "boundary", "integral"} - {kind})
    solve(re.sub(rf"^  ({others}):.*\n", "", uncommented("constraints"), flags=re.MULTILINE))


def test_all_examples_together():
    solve(uncommented(*EXAMPLES))


@pytest.mark.parametrize(
    "override",
    [
        "time.final={lower: 0.1, upper: 10, guess: 2}",
        "states.x.final={lower: 0, upper: 1}",
        "guess={constants: {F: 1}}",
        "guess={keyframes: {time: [0, 1, 2], x: [0, 0.5, 1]}}",
    ],
)
def test_what_stands_behind_a_line(override):
    assert override.partition("=")[2] in "\n".join(LINES)
    solve("\n".join(LINES), "--set", override)
