"""Mistakes of keys and numbers."""

from .case import edit, raw

TERMS = '{integral: u**2, terminal: "x[final]*v[final] + c**2"}'

CONSTANT = """trajopt: 1
time: {initial: 0, final: 1}
parameters: {m: 1}
states: {x: {rate: u, initial: 0, final: 1}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
constraints: {KIND: [{expression: 2*m, lower: 0.5}]}
"""

KEYS = [
    *(
        raw(
            f"a {kind} constraint on a constant",
            CONSTANT.replace("KIND", kind),
            ":7: ",
            "the constraint is on a constant",
        )
        for kind in ("path", "boundary")
    ),
    raw("only a version", "trajopt: 1\n", ":1: time", "time is missing"),
    edit(
        "no version",
        "trajopt: 1\n",
        "",
        "trajopt",
        "the version of the file format is missing; write trajopt: 1 at the top",
    ),
    edit("another version", "trajopt: 1", "trajopt: 2", "trajopt", "write trajopt: 1"),
    edit(
        "a reference beyond all numbers",
        "reference: {objective: 6.0,",
        "reference: {objective: 1.0e+300,",
        "reference.objective",
        "1e+300 is too large a number; write one below 1e+300",
    ),
    edit("a misspelt section", "controls:", "contols:", "contols", "did you mean controls?"),
    edit("a section of the future", "solver: {max_iter: 100}", "fleet: []", "fleet", "the keys here are trajopt, name"),
    *(
        edit(f"{what} in tags", "parameters:", f"tags: {tags}\nparameters:", place, says)
        for what, tags, place, says in (
            ("capitals", "[Smooth]", "tags.0", 'this is no tag: the text "Smooth"; write lowercase letters'),
            ("a space", "[stiff, free time]", "tags.1", 'this is no tag: the text "free time"'),
            ("a number", "[3]", "tags.0", "this is no tag: the number 3"),
            ("many letters", f"[{'a' * 41}]", "tags.0", "the tag has 41 letters; write at most 40"),
            ("a word twice", "[stiff, stiff]", "tags", 'the tag "stiff" is given twice'),
            ("no list", "smooth", "tags", "this must be a list"),
        )
    ),
    edit("a misspelt key", "rate: v,", "rates: v,", "states.x.rates", "did you mean rate?"),
    edit("no rate", "rate: v, ", "", "states.x", "rate is missing; add rate: an expression, or residuals:"),
    edit("no method", "method: hermite-simpson, ", "", "mesh.0.method", "collocation method"),
    edit("no states", "states:", "controls_: &s\nstates: {}\nunused:", "states", "at least 1", line=12),
    edit(
        "an empty mesh",
        "  - {method: hermite-simpson, segments: 10, tolerance: 1e-8}",
        "  []",
        "mesh",
        "at least 1",
        line=29,
    ),
    edit("a mesh that is no list", "  - {method", "  {method", "mesh", "write mesh: [{method: herm", line=29),
    edit(
        "a mesh by methods",
        "mesh:\n  - {method: hermite-simpson, segments: 10, tolerance: 1e-8}",
        "mesh: {radau: {segments: 10}}",
        "mesh",
        'start each item with "- ", or write for example mesh: [{method:',
    ),
    edit("states as a list", "states:", "states: [x, v]\nother:", "states", "must be a mapping, not a list"),
    edit("a state as a number", "  x: {unit", "  w: 3\n  x: {unit", "states.w", "must be a mapping, not the number 3"),
    edit("a bound as a list", "lower: -2", "lower: [-2]", "states.x.lower", "not a list"),
    edit("a bound as true", "lower: -2", "lower: true", "states.x.lower", "lower is true; write its value"),
    edit("a name as a list", "name: a good file", "name: [a]", "name", "put the text in quotes"),
    edit("a long text", "name: a good file", "name: " + "a" * 20_000, "name", "shorten it"),
    edit(
        "no sense",
        "{minimize: {integral",
        "{least: {integral",
        "objective.least",
        "the keys here are minimize, maximize",
    ),
    edit("two senses", "objective: {", "objective: {maximize: {integral: v}, ", "objective", "two objectives"),
    edit("an empty objective", TERMS, "{}", "objective.minimize", "add integral: or terminal:"),
    edit("an objective without terms", TERMS, "u**2", "objective.minimize", "write minimize: {integral: u**2}"),
    edit("fixed and free", "final: d}", "final: {value: d, lower: 0}}", "states.x.final", "keep the value"),
    edit("nothing fixed", "final: d}", "final: {}}", "states.x.final", "nothing is given here"),
    edit("no bound", ", upper: 100", "", "constraints.integral.0", "add lower:, upper: or equals:"),
    edit("two kinds of bound", "equals: d", "equals: d, lower: 0", "constraints.boundary.0", "keep one"),
    edit(
        "a kind of guess", "guess:\n  constants: {u: 1}\n  keyframes:", "guess: random\nother:", "guess", "write linear"
    ),
    edit("a choice", "solver: {", "solver: {accept: good, ", "solver.accept", "'optimal' or 'acceptable'"),
    edit("a switch that is none", "max_iter", "coarse_start: maybe, max_iter", "solver.coarse_start", "true or false"),
    edit("a tolerance for refine", "solver:", "refine: 1e-8\nsolver:", "refine", "write refine: {tolerance: 1e-8}"),
    edit(
        "no final time",
        ", final: T}",
        "}",
        "time.final",
        "add for example final: 1, or {lower: 0.5, upper: 3}",
    ),
    edit(
        "controls as lists",
        "u: {note: force, lower: -u_max, upper: u_max}",
        "u: [1, 2]",
        "controls.u",
        "a mapping, not",
    ),
    edit(
        "an objective as a number",
        "{minimize: " + TERMS + "}",
        "3",
        "objective",
        "not the number 3",
    ),
    edit("a British objective", "minimize", "minimise", "objective.minimise", "write minimize: "),
    edit("an option as a list", "max_iter: 100", "max_iter: [1]", "solver.max_iter", "solver's option"),
    edit("the option tol", "max_iter: 100", "tol: 1e-6", "solver.tol", "tolerance: in each entry of mesh:"),
]

STRANGE = [
    edit("NUL in a name", "a good file", '"a\\0b"', "name", r"the character '\x00', which cannot be printed"),
    edit("NUL in a unit", "{note: force,", '{unit: "N\\0",', "controls.u.unit", r"the character '\x00'"),
    edit("an escape", "{note: force,", '{unit: "\\e]0;x\\a",', "controls.u.unit", r"the character '\x1b'"),
    edit("DEL in a note", "{note: force,", '{note: "a\\x7f", unit: N,', "controls.u.note", r"the character '\x7f'"),
]

NUMBERS = [
    edit("NaN", "u_max: 5", "u_max: .nan", "parameters.u_max", "write a finite number"),
    edit("an infinite parameter", "u_max: 5", "u_max: 1e400", "parameters.u_max", "write a finite number"),
    edit("no meshes", "solver:", "refine: {max_meshes: 0}\nsolver:", "refine.max_meshes", "from 1 to 100"),
    edit("meshes in words", "solver:", "refine: {max_meshes: lots}\nsolver:", "refine.max_meshes", "from 1 to 100"),
    edit("a size of nothing", "mesh:", "scaling: {uu: 3}\nmesh:", "scaling.uu", "did you mean u?"),
    edit("a size of a parameter", "mesh:", "scaling: {d: 3}\nmesh:", "scaling.d", "those that have one are x, v, u, c"),
    edit("infinity", "upper: 2,", "upper: .inf,", "states.x.upper", "leave upper: out for no bound"),
    edit("a tolerance of NaN", "tolerance: 1e-8", "tolerance: .nan", "mesh.0.tolerance", "finite number"),
    edit("a tolerance of zero", "tolerance: 1e-8", "tolerance: 0", "mesh.0.tolerance", "out of range"),
    edit("a tolerance in words", "tolerance: 1e-8", "tolerance: small", "mesh.0.tolerance", 'not the text "small"'),
    edit("a million segments", "segments: 10", "segments: 1000000", "mesh.0.segments", "1 to 200000"),
    edit("no segments", "segments: 10", "segments: 0", "mesh.0.segments", "1 to 200000"),
    edit("half a segment", "segments: 10", "segments: 10.5", "mesh.0.segments", "whole number"),
    edit("a list in the degrees", "segments: 10,", "segments: 1, degree: [[2]],", "mesh.0.degree", "degree is a list"),
    edit("a mapping in the degrees", "segments: 10,", "segments: 1, degree: [{n: 2}],", "mesh.0.degree", "a mapping"),
    edit("a list as a degree", "segments: 10,", "segments: 2, degree: [2, [3]],", "mesh.0.degree", "degree is a list"),
    edit("endless segments", "segments: 10", "segments: .inf", "mesh.0.segments", "whole number"),
    edit("segments in words", "segments: 10", "segments: many", "mesh.0.segments", "whole number"),
    edit("a negative width", "segments: 10", "segments: [1, -1]", "mesh.0.segments", "positive relative widths"),
    edit("an unknown method", "hermite-simpson,", "hermite-simson,", "mesh.0.method", "did you mean hermite-simpson?"),
    edit("crossed bounds", "lower: -2", "lower: 3", "states.x.lower", "lower 3 is above upper 2"),
    edit("crossed parameters", "u_max: 5", "u_max: -5", "controls.u.lower", "lower 5 is above upper -5", line=15),
    edit("crossed statics", "lower: 0.1", "lower: 1", "optimize.c.lower", "above upper 0.5"),
    edit("crossed limits", "upper: 100", "upper: 1, lower: 2", "constraints.integral.0.lower", "above upper 1"),
    edit("an end outside the bounds", "final: d}", "final: 3*d}", "states.x.final", "outside the bounds -2 to 2"),
    edit("a range outside the bounds", "final: d}", "final: {lower: 3}}", "states.x.final", "3 to inf lies outside"),
    edit("a duration of zero", "final: T}", "final: 0}", "time.final", "make the final time larger"),
    edit("a negative duration", "T: 2*d", "T: -2*d", "time.final", "the final time -2 is not after", line=10),
    edit("a free time without a guess", "final: T}", "final: {lower: 1}}", "time.final", "add guess:"),
    edit("a guess before the start", "final: T}", "final: {lower: -1, guess: -1}}", "time.final", "a larger value"),
    edit("too few keyframes", "[0, 0.5, 1]", "[0, 1]", "guess.keyframes.x", "the same number of values"),
    edit("one keyframe", "{time: [0, 1, 2], x: [0, 0.5, 1]}", "{x: [0]}", "guess.keyframes.x", "at least 2"),
    edit("keyframes that go back", "[0, 1, 2]", "[0, 2, 1]", "guess.keyframes.time", "the times do not increase"),
    edit("a guess of nothing", "constants: {u: 1}", "constants: {w: 1}", "guess.constants.w", "state or a control"),
    edit("two guesses", "constants: {u: 1}", "constants: {x: 1}", "guess.constants.x", "keep one of the two"),
    edit("a constant objective", TERMS, "{integral: 1}", "objective.minimize", "constant"),
]
