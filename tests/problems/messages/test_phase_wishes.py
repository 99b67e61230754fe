"""Words of other tools in links, tables, measurements, pairs and guesses of phases: a sentence each, and the line."""

import pytest

from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text

FILE = """\
trajopt: 1
tables: {f: {points: {x: [0, 1, 2, 3]}, values: [0, 1, 4, 9], outside: hold}}
states: {x: {rate: v, initial: 0}, v: {rate: u - f(x), initial: 0}}
controls: {u: {lower: -5, upper: 5}}
time: {initial: 0, final: 4}
phases:
  a: {time: {final: 2}, states: {x: {final: 1}}}
  b: {measurements: {m: {data: {time: [3], x: [2]}, deviations: 0.1}}}
links: [{from: a, to: b}]
complementarity: [{a: x, b: u}]
guess: {keyframes: {time: [0, 4], x: [0, 3]}}
objective: {minimize: {integral: u**2}}
"""
LINK, TABLE, DATA = (
    "{from: a, to: b}]",
    "f: {points: {x: [0, 1, 2, 3]}, values: [0, 1, 4, 9], outside: hold}",
    "data: {",
)
GUESS = "guess: {keyframes: {time: [0, 4], x: [0, 3]}}"

CASES = {  # name: (what the good file has, what was written, the path, what is told)
    "a jump": (LINK, "{from: a, to: b, jump: {v: -0.8*v}}]", "links.0.jump", 'except: [v], and as another entry '
               '"b.v[initial] = -0.8*a.v[final]"'),
    "an impact": (LINK, "{from: a, to: b, impact: yes}]", "links.0.impact", "except: [v], and as another entry"),
    "states of a link": (LINK, "{from: a, to: b, states: [x]}]", "links.0.states", "all states that both phases have"),
    "a first phase": (LINK, "{first: a, to: b}]", "links.0.first", "write from: a"),
    "one name to leave out": (LINK, "{from: a, to: b, except: x}]", "links.0.except", "write except: [x]"),
    "an integral by phases": ("{integral: u**2}", "{integral: {a: u**2, b: 2*u**2}}", "objective.minimize.integral",
                              "under phases.a write objective: {minimize: {integral: u**2}}"),
    "a last term by phases": ("{integral: u**2}", '{terminal: {b: "x[final]"}}', "objective.minimize.terminal",
                              'under phases.b write objective: {minimize: {terminal: "x[final]"}}'),
    "one link": ("[" + LINK, "{from: a, to: b}", "links", "write links: [{from: a, to: b}]"),
    "one name without": ("a: {time: {f", "a: {without: v, time: {f", "phases.a.without", "write without: [v]"),
    "a file for a table": (TABLE, "f: f.csv", "tables.f", "write f: {file: f.csv}"),
    "points without a name": ("points: {x: [0, 1, 2, 3]}", "points: [0, 1, 2, 3]", "tables.f.points",
                              "write points: {x: [0, 1, 2, 3]}, with its name for x"),
    "sigma": ("deviations: 0.1", "sigma: 0.1", "phases.b.measurements.m.sigma", "write deviations: 0.1"),
    "uncertainties by column": ("deviations: 0.1", "uncertainty: {x: 0.1}", "phases.b.measurements.m.uncertainty",
                                "write deviations: {x: 0.1}"),
    "a column by itself": ("deviations: 0.1", "y: [2]", "phases.b.measurements.m.y", "write data: {y: [2]}, with the"),
    "a gap and a force": ("a: x, b: u}", "gap: x, b: u}", "complementarity.0.gap", "write a: x"),
    "a guess of a phase": (GUESS, "guess: {b: {constants: {u: 1}}}", "guess.b",
                           "phases: {b: {guess: {constants: {u: 1}}}}"),
    "a free end": ("final: 2}", "final: free}", "phases.a.time.final", "a free time has a range and a guess"),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_word_of_another_tool_is_told_with_the_line(name):
    given, written, path, told = CASES[name]
    assert FILE.count(given) == 1
    with pytest.raises(SpecError) as error:
        load_text(FILE.replace(given, written), "w.yaml")
    (mistake,) = error.value.mistakes
    line = FILE[: FILE.index(given)].count("\n") + 1
    assert mistake.where == f"w.yaml:{line}: {path}" and told in f"{mistake.what}; {mistake.remedy}"


def test_the_good_file_is_good_and_keyframes_may_have_t():
    assert load_text(FILE, "w.yaml").guess == load_text(FILE.replace("{time: [0, 4]", "{t: [0, 4]"), "w.yaml").guess
