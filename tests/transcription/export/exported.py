"""Readers of exported programs, which share no code with what wrote them.

Each evaluates a file at one point, given by the names that the file has for its variables, and returns a Program.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from math import inf
from pathlib import Path

import numpy as np

FUNCTIONS = {f: getattr(np, f) for f in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt")}
FUNCTIONS |= {f: getattr(np, f) for f in ("arcsin", "arccos", "arctan")}


@dataclass
class Program:
    """constraints: name -> (body - lower, upper - body). bounds: name of a variable -> (lower, upper)."""

    objective: float
    constraints: dict[str, tuple[float, float]]
    bounds: dict[str, tuple[float, float]]


# -- AMPL: D. M. Gay, Writing .nl files, 2005 ------------------------------------------------------------------------

OPERATORS = {
    "o0": np.add, "o1": np.subtract, "o2": np.multiply, "o3": np.divide, "o5": np.power, "o16": np.negative,
    "o37": np.tanh, "o38": np.tan, "o39": np.sqrt, "o40": np.sinh, "o41": np.sin, "o43": np.log, "o44": np.exp,
    "o45": np.cosh, "o46": np.cos, "o49": np.arctan, "o51": np.arcsin, "o53": np.arccos,
}  # fmt: skip


def read_nl(path: Path, values: dict[str, float]) -> Program:
    variables, rows = (path.with_suffix(suffix).read_text().splitlines() for suffix in (".col", ".row"))
    z = [values[name] for name in variables]
    lines = (line.split() for line in path.read_text().splitlines())
    header = list(islice(lines, 10))
    assert header[0][0] == "g3" and header[1][:3] == [str(len(z)), str(len(rows) - 1), "1"]
    body, limits = np.zeros(len(rows)), {}
    for key, *rest in lines:
        row = len(rows) - 1 if key[0] in "OG" else int(key[1:] or 0)
        if key[0] in "CO":
            body[row] += _operand(lines, z)
        elif key[0] in "JG":
            body[row] += sum(float(c) * z[int(j)] for j, c in islice(lines, int(rest[0])))
        elif key[0] in "rb":
            count = len(rows) - 1 if key[0] == "r" else len(z)
            limits[key[0]] = [_limits(*line) for line in islice(lines, count)]
        else:
            assert key[0] in "xk"  # the initial guess; the number of nonzeros in each column
            list(islice(lines, int(key[1:])))
    constraints = {
        name: (value - lower, upper - value)
        for name, value, (lower, upper) in zip(rows[:-1], body[:-1], limits["r"], strict=True)
    }
    return Program(body[-1], constraints, dict(zip(variables, limits["b"], strict=True)))


def _operand(lines, z) -> float:
    """An expression in Polish prefix notation."""
    (key,) = next(lines)
    if key[0] == "n":
        return float(key[1:])
    if key[0] == "v":
        return z[int(key[1:])]
    if key == "o54":  # a sum of so many
        (count,) = next(lines)
        return sum(_operand(lines, z) for _ in range(int(count)))
    operator = OPERATORS[key]
    return operator(*(_operand(lines, z) for _ in range(operator.nin)))


def _limits(kind: str, *numbers: str) -> tuple[float, float]:
    a = [float(number) for number in numbers]
    return {"0": lambda: (a[0], a[1]), "1": lambda: (-inf, a[0]), "2": lambda: (a[0], inf), "3": lambda: (-inf, inf),
            "4": lambda: (a[0], a[0])}[kind]()  # fmt: skip


# -- GAMS ------------------------------------------------------------------------------------------------------------


def read_gms(path: Path, values: dict[str, float]) -> Program:
    text = path.read_text()
    names = {re.sub(r"\W", "_", name).upper(): name for name in values}
    scope = {name: values[own] for name, own in names.items()} | {"POWER": np.power, "GAMS_OBJECTIVE": 0.0}
    scope |= {name.upper(): function for name, function in FUNCTIONS.items()}

    def evaluate(expression: str) -> float:
        return eval(expression.upper(), {"__builtins__": {}}, scope)

    equations = re.findall(r"^(\w+)\.\.\s+(.*?) =([el])= (.*?) ;$", text, re.MULTILINE | re.DOTALL)
    rows = {name: (sign, evaluate(left), evaluate(right)) for name, left, sign, right in equations}
    declared = re.search(r"^EQUATIONS\s+(.*?);", text, re.MULTILINE | re.DOTALL)[1].split()
    assert declared == list(rows) and list(rows)[-1] == "cost"
    objective = rows.pop("cost")[2]
    constraints: dict[str, tuple[float, float]] = {}
    for name, (sign, left, right) in rows.items():
        own, slack = name[:-3] if sign == "l" else name, right - left
        below, above = constraints.get(own, (inf, inf))
        if sign == "e":
            below, above = -slack, slack
        elif name.endswith("_lo"):
            below = slack
        else:
            above = slack
        constraints[own] = below, above
    return Program(objective, constraints, _gams_bounds(text, names))


def _gams_bounds(text: str, names: dict[str, str]) -> dict[str, tuple[float, float]]:
    bounds = {}
    for kind, listed in re.findall(r"^(POSITIVE )?VARIABLES\s+(.*?);", text, re.MULTILINE | re.DOTALL):
        bounds |= {name: [0.0 if kind else -inf, inf] for name in listed.split()}
    for name, end, value in re.findall(r"^(\w+)\.(lo|up) = (\S+);$", text, re.MULTILINE):
        bounds[name][end == "up"] = float(value)
    del bounds["GAMS_OBJECTIVE"]
    return {names[name.upper()]: tuple(ends) for name, ends in bounds.items()}


# -- LaTeX -----------------------------------------------------------------------------------------------------------


def read_tex(path: Path, values: dict[str, float]) -> Program:
    """`values` by names such as x_{q1,3}; the constraints are named by their labels, which must all be different."""
    head, _, text = path.read_text().partition("\\begin{document}\n")
    assert head.startswith("\\documentclass") and text.endswith("\\end{document}\n")
    ((_, (objective,)),), constraints, ((_, bounds),) = map(_formulas, text.split("\\subsection*")[1:])
    assert len(dict(constraints)) == len(constraints)
    return Program(
        evaluate_tex(objective, values),
        {label: _slacks(row, values) for label, (row,) in constraints},
        {name: ends for row in bounds for name, ends in _tex_bounds(row)},
    )


def formulas(path: Path) -> list[str]:
    """All formulas of a document, each on one line."""
    return [row for _, rows in _formulas(path.read_text()) for row in rows]


def _formulas(text: str) -> list[tuple[str, list[str]]]:
    """(the line above, the formulas) of each align*."""
    found = re.findall(r"^([^\n]*)\n\\begin\{align\*\}\n& (.*?)\n\\end\{align\*\}$", text, re.MULTILINE | re.DOTALL)
    assert len(found) == text.count(r"\begin{align*}")
    return [(label, body.replace(" \\\\\n& \\quad {}", " ").split(" \\\\\n& ")) for label, body in found]


NAME = r"[xuzpt]_\{(?:\\mathrm\{[^{}]*\}|[^{}])*\}"


def _plain(name: str) -> str:
    return re.sub(r"\\mathrm\{(.*?)\}", r"\1", name).replace(r"\_", "_")


def evaluate_tex(formula: str, values: dict[str, float]) -> float:
    place = {name: i for i, name in enumerate(values)}
    code = re.sub(NAME, lambda name: f"z[{place[_plain(name[0])]}]", formula)
    code = re.sub(r"\\biggl|\\biggr", "", code)
    code = re.sub(r"\\([a-z]+)\^\{(\d+)\}\(", r"raised(\1, \2)(", code)  # sin^2(x)
    before = ""
    while code != before:  # from the inside out
        before = code
        code = re.sub(r"\^\{([^{}]*)\}", r"**(\1)", code)
        code = re.sub(r"\\sqrt\{([^{}]*)\}", r"sqrt(\1)", code)
        code = re.sub(r"\\frac\{([^{}]*)\}\{([^{}]*)\}", r"((\1)/(\2))", code)
    code = re.sub(r"\\([a-z]+)\(", r"\1(", re.sub(r"\\,|\\cdot ", "*", code))
    raised = {"raised": lambda function, n: lambda x: function(x) ** n}
    return eval(code, {"__builtins__": {}}, {**FUNCTIONS, **raised, "z": list(values.values())})


def _slacks(relation: str, values: dict[str, float]) -> tuple[float, float]:
    sides = re.split(r" (?:=|\\leq) ", relation)
    numbers = [evaluate_tex(side, values) for side in sides]
    if " = " in relation:
        return numbers[0] - numbers[1], numbers[1] - numbers[0]
    slacks = np.diff(numbers).tolist()
    if len(slacks) == 1:
        slacks.insert(0 if "_" in sides[0] else 1, inf)
    return tuple(slacks)


def _tex_bounds(row: str) -> Iterator[tuple[str, tuple[float, float]]]:
    relation, _, points = row.partition(r",\quad k = ")
    (name,) = map(_plain, re.findall(NAME, relation))
    if relation.endswith(r"\text{ free}"):
        ends = -inf, inf
    else:
        below, above = _slacks(relation, {name: 0.0})
        ends = -below, above
    for k in _points(points) if points else [""]:
        yield name.replace(",k}", f",{k}}}") if points else name, ends


def _points(text: str) -> list[int]:
    """The indices of a list such as 0, 2, ..., 8."""
    points: list[int] = []
    items = iter(text.split(", "))
    for item in items:
        if item == r"\dots":
            points += range(2 * points[-1] - points[-2], int(next(items)) + 1, points[-1] - points[-2])
        else:
            points.append(int(item))
    return points
