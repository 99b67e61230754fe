"""Mistakes in tables of data: in the file, in the expressions that look them up, and in CSV files beside it."""

from .case import edits, raw
from .good import GOOD

GRID = "{points: {v: [0, 1, 2], x: [0, 1]}, values: [[0, 1], [1, 2], [2, 4]]}"
WITH_TABLES = GOOD.replace(
    "time: {",
    "tables:\n"
    "  drag: {points: {v: [0, 1, 2, 3]}, values: [0, 0.1, 0.4, 0.9], outside: extrapolate, unit: N}\n"
    f"  wind: {GRID[:-1]}, outside: hold, units: {{v: m/s}}}}\n"
    "time: {",
).replace("(u - c*v)/m", '"(u - c*v - drag(v) - wind(v, x))/m"')
edit = edits(WITH_TABLES)
POINTS, VALUES = "{v: [0, 1, 2, 3]}", "[0, 0.1, 0.4, 0.9]"


def points(name: str, given: str, says: str, place: str = "points.v"):
    return edit(name, POINTS, given, f"tables.drag.{place}", says)


def values(name: str, given: str, says: str):
    return edit(name, VALUES, given, "tables.drag.values", says)


def rate(name: str, call: str, says: str):
    return edit(name, "drag(v)", call, "states.v.rate", says)


IN_FILE = [
    points("points that fall", "{v: [0, 2, 1, 3]}", "the points do not increase: entry 3 is 1, after 2"),
    points("a point twice", "{v: [0, 1, 1, 3]}", "the points do not increase: entry 3 is 1, after 1"),
    points("one point", "{v: [0]}", "there is one point here; give at least two"),
    points("no list of points", "{v: 3}", "this must be a list of numbers, not the number 3"),
    points("a point of NaN", "{v: [0, .nan, 2, 3]}", "finite number"),
    points("a point in words", "{v: [0, one, 2, 3]}", 'this must be a number, not the text "one"'),
    points("no arguments", "{}", "the table has no arguments", "points"),
    points("four arguments", "{v: [0, 1], a: [0, 1], b: [0, 1], d: [0, 1]}", "the table has 4 arguments", "points"),
    points("a strange argument", '{"v (m/s)": [0, 1, 2, 3]}', "cannot be the name of an argument", "points"),
    values("too few values", "[0, 0.1, 0.4]", "the values are 3, the points of v 4; give a value for each point"),
    values("values in two directions", "[[0, 1], [1, 2]]", "the values are 2 x 2, the points of v 4"),
    values("a value of infinity", "[0, .inf, 0.4, 0.9]", "value 2 is the number inf"),
    values("a value in words", "[0, 0.1, much, 0.9]", 'value 3 is the text "much"'),
    values("no list of values", "3", "the values are the number 3; write a list of numbers"),
    edit(
        "a ragged grid", "[1, 2], [2, 4]]", "[1], [2, 4]]", "tables.wind.values", "row 2 of the values has the shape 1"
    ),
    edit(
        "a grid of other shape", "[[0, 1], [1, 2], [2, 4]]", "[[0, 1, 2], [1, 2, 4]]", "tables.wind.values", "are 2 x 3"
    ),
    edit(
        "a word in a grid",
        "[1, 2], [2, 4]]",
        "[1, x], [2, 4]]",
        "tables.wind.values",
        'value 2 of row 2 is the text "x"',
    ),
    edit("straight lines", ", unit: N}\n  w", ", kind: linear}\n  w", "tables.drag.kind", "a kink at every point"),
    edit(
        "lines rounded too widely",
        ", unit: N}\n  w",
        ", kind: linear, smooth: 0.5}\n  w",
        "tables.drag.smooth",
        "write less than 0.5",
    ),
    edit(
        "no width for one argument",
        ", units: {v: m/s}",
        ", kind: linear, smooth: {v: 0.1}",
        "tables.wind.smooth",
        "the distance for x is missing",
    ),
    edit("a curve that is rounded", ", unit: N}\n  w", ", smooth: 0.1}\n  w", "tables.drag.smooth", "cubic has none"),
    edit("a width of nothing", ", unit: N}\n  w", ", kind: linear, smooth: 0}\n  w", "tables.drag.smooth", "positive"),
    edit("a monotone surface", ", units: {v: m/s}", ", kind: monotone", "tables.wind.kind", "takes one argument"),
    edit("another kind", ", unit: N}\n  w", ", kind: quintic}\n  w", "tables.drag.kind", "is not one of the choices"),
    edit(
        "another way outside", "outside: hold", "outside: clamp", "tables.wind.outside", "write error, hold or extrap"
    ),
    edit("outside of no argument", "outside: hold", "outside: {y: hold}", "tables.wind.outside.y", "is no argument"),
    edit("a unit of no argument", "units: {v:", "units: {vv:", "tables.wind.units.vv", "did you mean v?"),
    edit(
        "a misspelt key of a table", "outside: hold", "outsides: hold", "tables.wind.outsides", "did you mean outside?"
    ),
    edit("no values", f", values: {VALUES}", "", "tables.drag", "the table has no values; add points:"),
    edit(
        "columns without a file", ", unit: N}\n  w", ", value: F}\n  w", "tables.drag.value", "there is none; add file:"
    ),
    edit("a file and points", ", unit: N}\n  w", ", file: a.csv}\n  w", "tables.drag.file", "are both given"),
    edit("a table called sin", "  wind:", "  sin:", "tables.sin", "has a meaning of its own"),
    edit("a table called delay", "  wind:", "  delay:", "tables.delay", "has a meaning of its own"),
    edit("a table called like a state", "  drag: {", "  x: {", "tables.x", "already declared under states"),
    edit("a table called like a parameter", "  drag: {", "  d: {", "tables.d", "already declared under parameters"),
    edit("tables as a list", "tables:\n", "tables: [1]\nother:\n", "tables", "must be a mapping, not a list"),
    rate("a misspelt table", "drg(v)", '"drg" in "(u - c*v - drg(v) - wind(v, x))/m": there is no drg(...); did you'),
    rate("an unknown table", "lift(v)", "lift is not a function"),
    rate("a table without arguments", "drag", "drag is a table of data; write drag(v)"),
    rate("a table of nothing", "drag()", "nothing between the parentheses"),
    rate("an argument too many", "drag(v, x)", "drag takes 1 argument, not 2; write drag(v)"),
    edit("an argument too few", "wind(v, x)", "wind(v)", "states.v.rate", "wind takes 2 arguments, not 1"),
    rate("a factor before a table", "2 drag(v)", "write 2*drag(...) for a product"),
    rate("a table of a later state", "drag(v(t + 0.5))", "a state can be taken at t and at an earlier time"),
    edit("a constant outside", "T: 2*d", "T: 2*d + 0*bound(7)", "parameters.T", "is outside of the points of bound"),
]
IN_FILE[-1] = raw(
    IN_FILE[-1].name,
    IN_FILE[-1].content.replace(b"tables:\n", b"tables:\n  bound: {points: {a: [0, 1]}, values: [0, 1]}\n"),
    ":7: parameters.T",
    IN_FILE[-1].says,
)

BOUNDED = WITH_TABLES.replace("outside: extrapolate", "outside: error")
BEYOND = [
    edits(BOUNDED)(
        "an end outside", "initial: 0, final: 0}", "initial: 0, final: 4}", "states.v.final", "points from 0 to 3"
    ),
    edits(BOUNDED)(
        "bounds outside",
        "initial: 0, final: 0}",
        "lower: 5, upper: 9}",
        "states.v",
        "v is 5 to 9 here, and the table drag has points from 0 to 3",
    ),
    edits(BOUNDED)("time outside", "drag(v)", "drag(5*t)", "states.v.rate", "v of drag is"),
    edits(BOUNDED)("time itself outside", "T: 2*d", "T: 4*d", "time.final", "t is 4 here"),
]
BEYOND[-1] = raw(
    BEYOND[-1].name,
    BEYOND[-1].content.replace(b"drag(v)", b"drag(t)").replace(b"time: [0, 1, 2]", b"time: [0, 1, 4]"),
    ":13: time.final",
    BEYOND[-1].says,
)

TABLES = [*IN_FILE, *BEYOND]

CSV = "v,x,F\n0,0,1\n0,1,2\n1,0,3\n1,1,5\n"
BAD_CSV: dict[str, tuple[str, bytes, str]] = {
    # name: the entry, the CSV file, what is said
    "no file": ("{file: other.csv}", b"", "there is no file other.csv"),
    "a file above": ("{file: ../data.csv}", b"", "is not in the folder of the problem file"),
    "an absolute path": ("{file: /etc/passwd}", b"", "is not in the folder of the problem file"),
    "a link that leads out": ("{file: link.csv}", b"", "is a link that leads out of the folder"),
    "a folder as a table": ("{file: folder}", b"", "is no ordinary file"),
    "an empty CSV file": ("{file: data.csv}", b"", "data.csv has no lines"),
    "only names": ("{file: data.csv}", b"v,x,F\n", "data.csv has no line of numbers"),
    "no UTF-8": ("{file: data.csv}", b"v,x,F\n0,0,1\n0,1,\xff\n", "data.csv, line 3: this is not UTF-8"),
    "semicolons": ("{file: data.csv}", b"v;x;F\n0;0;1\n", "write commas between the columns"),
    "a column twice": ("{file: data.csv}", b"v,v,F\n0,0,1\n", "data.csv has two columns v"),
    "a column that is missing": ("{file: data.csv, arguments: [v, y], value: F}", CSV.encode(), "has no column y"),
    "no column of values": ("{file: data.csv, value: f}", CSV.encode(), "has no column f; did you mean F?"),
    "which column": (
        "{file: data.csv, arguments: [v]}",
        CSV.encode(),
        "over v is not clear; add value: with",
    ),
    "a value as an argument": (
        "{file: data.csv, arguments: [v, F], value: F}",
        CSV.encode(),
        "name one to three columns",
    ),
    "five columns": ("{file: data.csv}", b"a,b,c,d,F\n0,0,0,0,1\n", "name one to three columns"),
    "a word in a cell": (
        "{file: data.csv}",
        CSV.replace("1,0,3", "1,0,n/a").encode(),
        'line 4, column F: "n/a" is no fin',
    ),
    "NaN in a cell": (
        "{file: data.csv}",
        CSV.replace("1,0,3", "1,nan,3").encode(),
        'line 4, column x: "nan" is no finite',
    ),
    "infinity in a cell": (
        "{file: data.csv}",
        CSV.replace("1,0,3", "1,0,inf").encode(),
        'column F: "inf" is no finite',
    ),
    "an empty cell": ("{file: data.csv}", CSV.replace("1,0,3", "1,0,").encode(), "line 4, column F: the cell is empty"),
    "a short line": (
        "{file: data.csv}",
        CSV.replace("1,0,3", "1,0").encode(),
        "line 4: there are 2 cells for 3 columns",
    ),
    "decimal commas": ("{file: data.csv}", CSV.replace("1,0,3", "1,0,3,5").encode(), "there are 4 cells for 3 columns"),
    "a missing point": ("{file: data.csv}", CSV.replace("1,0,3\n", "").encode(), "v = 1, x = 0 is missing, for one"),
    "a point given twice": (
        "{file: data.csv}",
        (CSV + "1,0,4\n").encode(),
        "line 6: v = 1, x = 0 stands on line 4 alread",
    ),
    "a large file": ("{file: data.csv}", b"v,F\n" + b"0,1\n" * 2_600_000, "data.csv is larger than 10 MB"),
    "too many lines": ("{file: data.csv}", b"v,F\n" + b"0,1\n" * 100_001, "data.csv has 100001 lines of numbers"),
    "one point of an argument": (
        "{file: data.csv, arguments: [v, x]}",
        b"v,x,F\n0,0,1\n1,0,2\n",
        "there is one point here",
    ),
    "several curves over one column": (
        "{file: data.csv}",
        b"v,x,F\n0,0,1\n1,4,2\n",
        "over v is not clear; add value: with",
    ),
    "a NUL": ("{file: data.csv}", b"v,F\n0,1\n1,\x00\n", "line 3, column F"),
}
