"""Mistakes in guesses: in the file, and in CSV files beside it."""

from .case import edits
from .good import GOOD, IMPLICIT

GUESS = "  constants: {u: 1}\n  keyframes: {time: [0, 1, 2], x: [0, 0.5, 1]}\n"
edit, of_residuals = edits(GOOD), edits(IMPLICIT)
LINE = GOOD[: GOOD.index(GUESS)].count("\n") + 1


def guess(name: str, given: str, path: str, says: str):
    return edit(name, GUESS, f"  {given}\n", f"guess.{path}" if path else "guess", says, line=LINE)


GUESSES = [
    guess("a guess of another kind", "shooting: 1", "shooting", "shooting"),
    edit("a word for a guess", f"guess:\n{GUESS}", "guess: simulated\n", "guess", "did you mean simulate?"),
    guess("a formula of a state", "formulas: {u: 2*x}", "formulas.u", "x is a state, which is not known here"),
    guess("a formula without a value", "formulas: {u: log(t)}", "formulas.u", "no finite value at t = 0"),
    guess("a formula of nothing", "formulas: {w: t}", "formulas.w", "w is not a state or a control"),
    guess(
        "a formula and a constant", "{constants: {u: 1}, formulas: {u: t}}", "constants.u", "u has a formula as well"
    ),
    guess("a formula at an end", 'formulas: {u: "t[final]"}', "formulas.u", "which is not known here; write t"),
    guess("a simulated state", "simulate: {x: t}", "simulate.x", "x is not a control"),
    guess("a control of a control", "simulate: {u: power}", "simulate.u", "u is a control, which is not known here"),
    guess("a simulation without a rate", "simulate: {u: log(0.5 - t)}", "simulate", "no finite value at t = 0.5"),
    of_residuals(
        "a simulation of residuals", GUESS, "  simulate: {u: 1}\n", "guess.simulate", "are implicit", line=LINE + 5
    ),
    guess("data without times", "data: {x: [0, 1]}", "data", "the data have no time"),
    guess(
        "data of other lengths", "data: {time: [0, 1], x: [0, 1, 2]}", "data", "x has 3 values, and there are 2 times"
    ),
    guess("data that go back", "data: {time: [0, 2, 1], x: [0, 1, 2]}", "data", "entry 3 is 1, after 2"),
    guess("data with a gap", "data: {time: [0, 1], x: [0, .nan]}", "data", "a value of x is"),
    guess(
        "data of another time", "data: {time: [7, 9], x: [0, 1]}", "data.time", "7 to 9, those of the problem 0 to 2"
    ),
    guess("data of no state", "data: {time: [0, 1], xx: [0, 1]}", "data.xx", "did you mean x?"),
    edit(
        "data and a file",
        f"guess:\n{GUESS}",
        "guess: {file: a.csv, data: {time: [0, 1], x: [0, 1]}}\n",
        "guess",
        "file and data are both given",
    ),
    guess("data as a list", "data: [0, 1]", "data", "the data are a list; write lists of numbers by name"),
]

BAD_GUESS: dict[str, tuple[bytes, str]] = {
    # name: the CSV file, what is said
    "no times": (b"x,v\n0,0\n1,1\n", "data.csv has no column time; call the column of the times time, or t"),
    "times alone": (b"time\n0\n1\n", "data.csv has a column of times alone"),
    "a time twice": (
        b"t,x\n0,0\n1,1\n1,2\n",
        "data.csv, line 4: the time 1 follows 1; sort the lines by time, and give",
    ),
    "times that fall": (b"t,x\n0,0\n2,1\n1,2\n", "data.csv, line 4: the time 1 follows 2"),
    "an empty cell": (b"t,x\n0,0\n1,\n", "data.csv, line 3, column x: the cell is empty"),
    "a word": (b"t,x\n# a comment\n0,0\n\n1,one\n", 'data.csv, line 5, column x: "one" is no finite number'),
    "one line": (b"t,x\n0,0\n", "there are less than two times"),
    "no states": (b"t,y,z\n0,0,0\n1,1,1\n", "no column of data.csv is a state or a control: they are y, z"),
    "another time": (b"t,x\n7,0\n8,1\n", "the times of the data are 7 to 8, those of the problem 0 to 2"),
}
