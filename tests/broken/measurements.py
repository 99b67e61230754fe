"""Mistakes in measurements: in the file, and in CSV files beside it."""

from .case import edits
from .good import GOOD

DATA = "data: {time: [0, 1, 2], x: [0, 0.4, 1]}"
MEASURED = GOOD.replace("constraints:", f"measurements:\n  run: {{{DATA}, deviations: 0.1}}\nconstraints:")
LINE = MEASURED[: MEASURED.index("  run:")].count("\n") + 1
edit = edits(MEASURED)
ENTRY = f"{{{DATA}, deviations: 0.1}}"


def run(name: str, given: str, path: str, says: str):
    return edit(f"measured: {name}", ENTRY, given, f"measurements.run{'.' if path else ''}{path}", says, line=LINE)


def data(name: str, given: str, says: str, path: str = "data"):
    return run(name, f"{{data: {given}}}", path, says)


MEASUREMENTS = [
    run("no measurements", "{note: later}", "", "there are no measurements; add file: with a CSV file, or data:"),
    run("a file that is a number", "{file: 3}", "file", "there is no file 3"),
    run("a file and data", f"{{file: a.csv, {DATA}}}", "", "file and data are both given"),
    run("weights and deviations", f"{{{DATA}, weights: 1, deviations: 1}}", "", "weights are 1/deviation**2"),
    run("a deviation of zero", f"{{{DATA}, deviations: 0}}", "deviations", "the number is 0; write a positive one"),
    run("a deviation below zero", f"{{{DATA}, deviations: {{x: -1}}}}", "deviations", "the number is -1"),
    run(
        "a deviation of no column",
        f"{{{DATA}, deviations: s}}",
        "deviations",
        "there is no column s; the columns are x",
    ),
    run(
        "a weight of no column",
        f"{{{DATA}, weights: {{xx: 1}}}}",
        "weights.xx",
        "there is no column xx; did you mean x?",
    ),
    run("what is compared with no column", f"{{{DATA}, compare: {{y: x}}}}", "compare.y", "there is no column y"),
    run("an unknown name", f"{{{DATA}, compare: {{x: x + w}}}}", "compare.x", 'unknown name "w"'),
    run(
        "a measured control that is none",
        f"{{{DATA}, compare: {{x: u + uu}}}}",
        "compare.x",
        'unknown name "uu"; did you mean u?',
    ),
    run(
        "the modulus of a measured control",
        f"{{{DATA}, compare: {{x: abs(power)}}}}",
        "compare.x",
        "abs is not a consistent function",
    ),
    run(
        "a measured constant", f"{{{DATA}, compare: {{x: 2*t}}}}", "compare.x", "depends on nothing that is to be found"
    ),
    run("a measured end", f'{{{DATA}, compare: {{x: "x[final]"}}}}', "compare.x", "write x"),
    run("a measured modulus", f"{{{DATA}, compare: {{x: abs(v)}}}}", "compare.x", "abs is not smooth; write it smooth"),
    run("a misspelt key", f"{{{DATA}, deviation: 0.1}}", "deviation", "did you mean deviations?"),
    data("no times", "{x: [0, 1]}", "the data have no time"),
    data("no columns", "{time: [0, 1]}", "the data have times alone"),
    data("other lengths", "{time: [0, 1], x: [0, 1, 2]}", "x has 3 values, and there are 2 times"),
    data("times that fall", "{time: [0, 2, 1], x: [0, 1, 2]}", "the times fall: entry 3 is 1, after 2"),
    data("a value in words", "{time: [0, 1], x: [0, much]}", 'a value of x is the text "much"'),
    data("an infinite value", "{time: [0, 1], x: [0, .inf]}", "a value of x is the number inf"),
    data("a time outside", "{time: [0, 3], x: [0, 1]}", "the time 3 is not from 0 to 2; change time:"),
    data("columns of no state", "{time: [0, 1], y: [0, 1]}", "no column is named as a state: y; say by compare:"),
    data("a column without values", "{time: [0, 1], x: [null, null]}", "the column x has no values"),
    data(
        "too many times",
        f"{{time: {[i / 1200 for i in range(2400)]}, x: {[0] * 2400}}}",
        "there are 2400 distinct times",
        "",
    ),
    run(
        "a missing deviation",
        "{data: {time: [0, 1], x: [0, 1], s: [1, null]}, deviations: s}",
        "data",
        "s of x is missing at time 1",
    ),
    run(
        "another column's deviation",
        "{data: {time: [0, 1], x: [0, 1], v: [0, 1]}, deviations: {x: 1}}",
        "deviations",
        "v has no standard",
    ),
    edit(
        "measured: a free end of time",
        "final: T}",
        "final: {lower: 1, upper: 3}}",
        "constraints.integral.0",
        "an integral constraint is of one phase; name the integral under integrals:",
        line=MEASURED[: MEASURED.index("expression: power, ")].count("\n") + 1,
    ),
    edit(
        "measured: residuals maximised",
        "minimize",
        "maximize",
        "measurements.run",
        "squared residuals are minimised",
        line=LINE,
    ),
    edit("a name of measurements", "  run:", '  "run 1":', "measurements.run 1", "cannot be a name"),
]

BAD_MEASURED: dict[str, tuple[bytes, str]] = {
    # name: the CSV file, what is said
    "no times": (b"x,v\n0,0\n1,1\n", "data.csv has no column time"),
    "times that fall": (b"t,x\n0,0\n2,1\n1,2\n", "data.csv, line 4: the time 1 follows 2; sort the lines by time"),
    "a missing time": (b"t,x\n0,0\n,1\n", "data.csv, line 3, column t: the cell is empty"),
    "a word": (b"t,x\n# a comment\n0,0\n\n1,one\n", 'data.csv, line 5, column x: "one" is no finite number'),
    "a number of another country": (b"t,x\n0,0\n1,0,5\n", "data.csv, line 3: there are 3 cells for 2 columns"),
    "semicolons": (b"t;x\n0;0\n", "write commas between the columns"),
    "no states": (b"t,y,z\n0,0,0\n1,1,1\n", "no column is named as a state: y, z"),
    "a time outside": (b"t,x\n0,0\n3,1\n", "the time 3 is not from 0 to 2"),
    "no values": (b"t,x,v\n0,,0\n1,,1\n", "the column x has no values"),
}
