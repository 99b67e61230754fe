"""Mistakes of what a method of solution is asked for: nonsmooth functions, options of the solver."""

from .case import edit, edits, rate_of_v
from .good import GOOD, MODEL, NONSMOOTH

nonsmooth, model = map(edits, (NONSMOOTH, MODEL))
newton = edits(GOOD.replace("solver: {", "solver: {engine: newton, "))

CONSISTENT = [
    nonsmooth(
        "a way that is none",
        "nonsmooth: slack",
        "nonsmooth: smooth",
        "nonsmooth",
        "write slack, {tanh: 0.01}",
    ),
    nonsmooth("tanh without a width", "nonsmooth: slack", "nonsmooth: tanh", "nonsmooth", "{tanh: 0.01}"),
    nonsmooth("no way", "nonsmooth: slack", "nonsmooth: {}", "nonsmooth", "nothing is given here"),
    nonsmooth("two ways", "nonsmooth: slack", "nonsmooth: {tanh: 1, sqrt: 1}", "nonsmooth", "keep one of them"),
    nonsmooth("a misspelt way", "nonsmooth: slack", "nonsmooth: {tahn: 1}", "nonsmooth.tahn", "did you mean tanh?"),
    nonsmooth(
        "a width of zero",
        "nonsmooth: slack",
        "nonsmooth: {tanh: 0}",
        "nonsmooth.tanh",
        "write a positive number",
    ),
    nonsmooth("a negative smoothing", "nonsmooth: slack", "nonsmooth: {sqrt: -d}", "nonsmooth.sqrt", "is -1"),
    nonsmooth("a width that varies", "nonsmooth: slack", "nonsmooth: {sqrt: u}", "nonsmooth.sqrt", "must be known"),
    nonsmooth(
        "too many widths",
        "nonsmooth: slack",
        "nonsmooth: {tanh: [1, 0.1]}",
        "nonsmooth.tanh",
        "there are 2 values for 1 entry",
    ),
    nonsmooth("no widths", "nonsmooth: slack", "nonsmooth: {tanh: []}", "nonsmooth.tanh", "at least 1"),
    nonsmooth("a list of ways", "nonsmooth: slack", "nonsmooth: [slack]", "nonsmooth", "must be a mapping"),
    nonsmooth("no nonsmooth", "nonsmooth: slack\n", "", "objective.minimize.integral", "section 5.5", line=18),
    rate_of_v("abs of two", "abs(u, v)", "abs takes one argument"),
    rate_of_v("min of one", "min(u)", "2 to 20 arguments"),
    rate_of_v("min of many", "min(" + "u, " * 50 + "v)", "2 to 20 arguments"),
    rate_of_v("a trailing comma", "max(u, )", "a value is missing"),
    rate_of_v("abs and no parentheses", "abs u", "write abs(u)"),
    rate_of_v("abs in an expression of constants", "u*abs(v)*abs(m)", "nonsmooth: slack"),
    edit(
        "abs at an end",
        '"x[final] - x[initial]"',
        '"abs(x[final])"',
        "constraints.boundary.0.expression",
        "section 5.5",
    ),
    edit("abs in a named expression", "power: u*v", "power: abs(u*v)", "expressions.power", "section 5.5"),
]

SOLVERS = [
    edit("another engine", "solver: {", "solver: {engine: snopt, ", "solver.engine", "'ipopt' or 'newton'"),
    *(
        newton(f"bounds for Newton, {path}", given, f"{given} ", path, "the Newton engine takes ")
        for path, given in (
            ("states.x.lower", "x: {unit: m,"),
            ("controls.u.lower", "u: {note: force,"),
            ("optimize.c.lower", "c: {lower: 0.1,"),
            ("constraints.path.0", "- {name: speed limit,"),
            ("constraints.integral.0", "- {expression: power,"),
        )
    ),
    newton(
        "a free time for Newton",
        "final: T}",
        "final: {upper: 3, guess: 2}}",
        "time.final.upper",
        "leave out engine: newton",
    ),
    nonsmooth(
        "slack for Newton",
        "solver: {",
        "solver: {engine: newton, ",
        "nonsmooth",
        "write nonsmooth: {tanh: 0.01}",
        line=26,
    ),
    model(
        "a model for Newton",
        "model: five_link_biped",
        "solver: {engine: newton}\nmodel: five_link_biped",
        "model",
        "equality constraints only",
        line=10,
    ),
    edit("a library", "max_iter: 100", "hsllib: ./evil.so", "solver.hsllib", "--set solver.hsllib=..."),
    edit("a library in capitals", "max_iter: 100", "HSLlib: ./evil.so", "solver.HSLlib", "data, never code"),
    edit(
        "a library behind a prefix",
        "max_iter: 100",
        "resto.pardisolib: a.so",
        "solver.resto.pardisolib",
        "load a library",
    ),
    edit("an option file", "max_iter: 100", "option_file_name: a.opt", "solver.option_file_name", "cannot check"),
    edit(
        "an option file in capitals, behind a prefix",
        "max_iter: 100",
        "resto.OPTION_file_name: a.opt",
        "solver.resto.OPTION_file_name",
        "as solver.NAME",
    ),
    edit("an output file", "max_iter: 100", "output_file: a.txt", "solver.output_file", "write a file"),
]

# Signs, slopes and sizes of slack variables need every range of the file, also one that is mistaken itself.
RANGES = [
    nonsmooth("a range of no value", "u_max: 5", "u_max: 5 N", "parameters.u_max", "{value: 5, unit: N}"),
    nonsmooth("a range of a list", "u_max: 5", "u_max: [5]", "parameters.u_max", "a number or an expression"),
    nonsmooth("a broken bound", "lower: -2", "lower: 2 m", "states.x.lower", "write lower: 2"),
    nonsmooth("a range of nothing", "u_max: 5", "u_max: .nan", "parameters.u_max", "NaN is not a number"),
]
