"""Mistakes of phases, links and waypoints."""

from .case import edits

LAUNCH = """trajopt: 1
name: launch
parameters: {g: 9.81, c: 3000, T: 4.0e5, m0: 20000, case: 1500}
time: {initial: 0, final: {lower: 70, upper: 200, guess: 100}}
states:
  h: {unit: m, rate: v, initial: 0}
  v: {unit: m/s, rate: T/m - g, initial: 0, note: speed}
  m: {unit: kg, rate: -T/c, lower: 100, initial: m0}
controls: {u: {lower: 0, upper: 1}}
expressions: {energy: g*h + v**2/2 + 0*u}
phases:
  first:
    time: {final: 60}
    constraints: {path: [{expression: u*m, upper: 90000}]}
  second:
    parameters: {T: 1.0e5}
    states: {m: {final: 3000}}
    mesh: [{method: radau, segments: 8}]
links:
  - {from: first, to: second, except: [m]}
  - {name: drop, expression: "second.m[initial] - first.m[final]", equals: -case}
objective: {maximize: {terminal: "second.energy[final]", integral: -1e-9*u**2}}
refine: {}
"""

WALK = """trajopt: 1
name: walk
time: {initial: 0, final: 2}
states:
  x: {rate: u, initial: 0, final: 2, lower: -5, upper: 5}
controls: {u: {}}
waypoints:
  - {x: 1}
  - {time: 1.5, x: {lower: 1, upper: 2}}
objective: {minimize: {integral: u**2}}
"""

edit, walk = edits(LAUNCH), edits(WALK)

PHASES = [
    edit("a phase of no name", "  first:\n", "  1st:\n", "phases.1st", "use a letter"),
    edit("a phase of a reserved name", "  first:\n", "  for:\n", "phases.for", "meaning of its own"),
    edit("a phase that is a number", "    time: {final: 60}", "    time: 3", "phases.first.time", "must be a mapping"),
    edit(
        "a phase of no duration",
        "    parameters: {T: 1.0e5}\n",
        "    time: {initial: 60, final: 60}\n    parameters: {T: 1.0e5}\n",
        "phases.second.time.final",
        "leave this phase out, with what it says under links:",
    ),
    edit("a misspelt key of a phase", "    mesh: [", "    mehs: [", "phases.second.mehs", "did you mean mesh?"),
    edit("a key of the file in a phase", "    mesh: [", "    solver: [", "phases.second.solver", "put solver: at the"),
    edit(
        "scaling in a phase",
        "    mesh: [",
        "    scaling: auto\n    mesh: [",
        "phases.second.scaling",
        "the whole problem",
    ),
    edit(
        "optimize in a phase",
        "    mesh: [",
        "    optimize: {k: {}}\n    mesh: [",
        "phases.second.optimize",
        "the whole",
    ),
    edit(
        "tables in a phase", "    mesh: [", "    tables: {}\n    mesh: [", "phases.second.tables", "the whole problem"
    ),
    edit("a method of a phase", "method: radau", "method: radua", "phases.second.mesh.0.method", "did you mean radau?"),
    edit(
        "a degree of a phase", "segments: 8}", "segments: 8, degree: 99}", "phases.second.mesh.0.degree", "from 1 to 60"
    ),
    edit("an unknown name in a phase", "u*m, upper", "u*mm, upper", "phases.first.constraints.path.0.expression", "mm"),
    edit(
        "crossed bounds in a phase",
        "{m: {final: 3000}}",
        "{m: {final: 3000, upper: 50}}",
        "phases.second.states.m.upper",
        "is above upper 50",
    ),
    edit(
        "an end out of the top level's bounds",
        "{final: 3000}",
        "{final: 30}",
        "phases.second.states.m.final",
        "outside the bounds",
    ),
    edit("a time that ends before", "{final: 60}", "{final: 600}", "time.final", "is not after", line=4),
    edit(
        "nobody says when it begins",
        "time: {initial: 0, final",
        "time: {final",
        "time",
        "nothing says when the first phase begins",
    ),
    edit(
        "nobody says when it ends",
        "time: {initial: 0, final: {lower: 70, upper: 200, guess: 100}}",
        "time: {initial: 0}",
        "time",
        "nothing says when the last phase ends",
    ),
    edit("an unknown phase in a link", "from: first", "from: frist", "links.0.from", "did you mean first?"),
    edit("an unknown phase to link", "to: second", "to: third", "links.0.to", "the phases are first, second"),
    edit(
        "a link without a phase to go to", "to: second, ", "", "links.0", "a link has an expression, or from: and to:"
    ),
    edit("an unknown state to leave out", "except: [m]", "except: [mm]", "links.0.except", "did you mean m?"),
    edit("a bound of a passage", "except: [m]", "upper: 3", "links.0", "a bound without an expression"),
    edit("a link without a bound", ", equals: -case", "", "links.1", "the link has no bound"),
    edit(
        "two kinds of bound of a link",
        "equals: -case",
        "equals: -case, lower: 0",
        "links.1",
        "equals is given together",
    ),
    edit(
        "crossed bounds of a link", "equals: -case", "lower: 2, upper: 1", "links.1.lower", "lower 2 is above upper 1"
    ),
    edit("a link of both kinds", "name: drop,", "name: drop, from: first,", "links.1", "keep one"),
    edit(
        "a passage said twice",
        "  - {name: drop,",
        "  - {from: first, to: second}\n  - {name: drop,",
        "links.1",
        "links.0 has said that second goes on from first; keep one of the two, with all that jumps under except: of it",
    ),
    edit(
        "a link said twice",
        "  - {name: drop,",
        '  - {expression: "second.m[initial]-first.m[final]", equals: (-case)}\n  - {name: drop,',
        "links.2",
        "links.1 says this already; keep one of the two",
        line=22,
    ),
    edit("a misspelt key of a link", "name: drop,", "nmae: drop,", "links.1.nmae", "did you mean name?"),
    edit("a bad name of a link", "name: drop,", "name: 'a/b',", "links.1.name", "use letters, digits"),
    edit("a bound that varies", "equals: -case", "equals: 'first.m[final]'", "links.1.equals", "must be known before"),
    edit(
        "no end in a link",
        "first.m[final]",
        "first.m",
        "links.1.expression",
        "write first.m[final] or first.m[initial]",
    ),
    edit("an unknown name in a link", "first.m[final]", "first.mm[final]", "links.1.expression", "did you mean m?"),
    edit("an unknown phase in an expression", "first.m[final]", "frst.m[final]", "links.1.expression", "mean first?"),
    edit("an end of a parameter in a link", "equals: -case", "equals: '-case[final]'", "links.1.equals", "write case"),
    edit("abs in a link", "first.m[final]", "abs(first.m[final])", "links.1.expression", "write it smooth"),
    edit("a phase in dynamics", "rate: T/m - g,", "rate: first.T/m - g,", "states.v.rate", 'unknown name "first.T"'),
    edit(
        "a state that jumps without a word",
        "  second:\n    parameters: {T: 1.0e5}\n    states: {m: {final: 3000}}",
        "    states: {v: {final: 5}}\n  second:\n    parameters: {T: 1.0e5}\n    states: {v: {initial: 6}}",
        "links.0",
        "v ends at 5 in first, begins at 6 in second",
        line=21,
    ),
    edit(
        "an objective of another sense",
        "    time: {final: 60}",
        "    time: {final: 60}\n    objective: {minimize: {integral: u}}",
        "phases.first.objective",
        "the file says maximize",
        line=14,
    ),
    edit(
        "no objective at all",
        '{terminal: "second.energy[final]", integral: -1e-9*u**2}',
        "{}",
        "objective.maximize",
        "the objective is empty",
    ),
    edit(
        "an integral constraint of all phases",
        "refine: {}",
        "constraints: {integral: [{expression: u, upper: 3}]}",
        "constraints.integral.0",
        "belongs to one of them",
    ),
    edit(
        "crossed bounds of a boundary constraint of all phases",
        "refine: {}",
        "constraints: {boundary: [{expression: 'second.m[final]', lower: 2*case, upper: case}]}",
        "constraints.boundary.0.lower",
        "is above upper",
    ),
    edit(
        "an unknown name in the objective",
        "second.energy[final]",
        "second.enrgy[final]",
        "objective.maximize.terminal",
        "did you mean energy?",
    ),
    walk("a waypoint that is a number", "  - {x: 1}", "  - 1", "waypoints.0", "must be a mapping"),
    walk(
        "a waypoint of no state",
        "  - {x: 1}",
        "  - {time: 1}",
        "waypoints.0",
        "no state has a value at this place; add one",
    ),
    walk("a waypoint out of bounds", "  - {x: 1}", "  - {x: 9}", "waypoints.0.x", "outside the bounds"),
    walk("a waypoint of an unknown state", "  - {x: 1}", "  - {y: 1}", "waypoints.0.y", "the states are x"),
    walk("waypoints and phases", "waypoints:", "phases: {a: {}}\nwaypoints:", "waypoints", "keep one", line=8),
    walk(
        "waypoints of one name",
        "  - {x: 1}",
        "  - {x: 1, name: leg2}",
        "waypoints",
        "two waypoints have one name",
        line=7,
    ),
    walk("a waypoint too late", "time: 1.5", "time: 5", "time.final", "is not after", line=3),
]
