"""Mistakes of names and expressions, and of overrides on the command line."""

from .case import edit, override, rate_of_v

CHAIN = "".join(f"  e{i}: e{i - 1}*e{i - 1} + e{i - 1}\n" for i in range(1, 60))

NAMES = [
    edit("a reserved name", "  d: 1.0", "  sin: 1.0\n  d: 1.0", "parameters.sin", "choose another name"),
    edit("time as a name", "controls:", "  t: {rate: 1}\ncontrols:", "states.t", "choose another name"),
    edit("a name with a dash", "  d: 1.0", "  d-max: 1.0\n  d: 1.0", "parameters.d-max", "digits and _"),
    edit("a number as a name", "  d: 1.0", "  1: 1.0\n  d: 1.0", "parameters.1", "use a letter"),
    edit("a name twice", "controls:\n", "controls:\n  v: {}\n", "controls.v", "already declared under states", line=15),
    edit(
        "a constraint twice",
        "expression: power",
        "name: speed limit, expression: power",
        "constraints.integral.0.name",
        "its own name",
    ),
    edit("a name with a slash", "speed limit", "m/s", "constraints.path.0.name", "use letters, digits"),
    edit("a cyclic parameter", "d: 1.0", "d: T/2", "parameters.", "is a circle"),
    edit("a parameter of itself", "u_max: 5", "u_max: u_max + 1", "parameters.u_max", "u_max -> u_max is a circle"),
    edit("a cyclic expression", "power: u*v", "power: u*work\n  work: power*v", "expressions.", "is a circle"),
    edit(
        "an endless expression",
        "  power: u*v\n",
        "  e0: u\n" + CHAIN + "  power: e59\n",
        "expressions.e10",
        "refer to fewer expressions",
        line=19,
    ),
    rate_of_v("an unknown name", "(u - c*vv)/m", "did you mean v?"),
    rate_of_v("a name of its own", "(u - k*v)/m", "declare it"),
    rate_of_v("an end in a rate", "u - x[final]", "write x, or move the expression"),
    edit("a state in a bound", "upper: 2,", "upper: 2*v,", "states.x.upper", "under constraints:"),
    edit("a state in a parameter", "T: 2*d", "T: 2*x", "parameters.T", "x is a state"),
    edit(
        "a static as a value", "initial: 0, final: d}", "initial: c, final: d}", "states.x.initial", "static parameter"
    ),
    edit(
        "a bare state at the boundary",
        '"x[final] - x[initial]"',
        "x",
        "constraints.boundary.0.expression",
        "write x[final] or x[initial]",
    ),
    edit(
        "bare time in the objective",
        '"x[final]*v[final] + c**2"',
        "t",
        "objective.minimize.terminal",
        "write t[final] or t[initial]",
    ),
    edit(
        "a bare expression at the boundary",
        '"x[final] - x[initial]"',
        "power",
        "constraints.boundary.0.expression",
        "write power[final] or power[initial]",
    ),
    edit(
        "an end of a parameter",
        '"x[final] - x[initial]"',
        '"x[final] - d[final]"',
        "constraints.boundary.0.expression",
        "write d",
    ),
]

EXPRESSIONS = [
    rate_of_v("an import", "__import__('os').system('true')", "has no meaning in an expression"),
    rate_of_v("an attribute", "u.real", "no attributes"),
    rate_of_v("a lambda", "(lambda: 1)()", "is a word of Python"),
    rate_of_v("a comprehension", "[v for v in u]", "is a word of Python"),
    rate_of_v("a condition", "u if v else 0", "no branches"),
    rate_of_v("a tower of powers", "9**9**9", "exponent larger than 1000"),
    rate_of_v("a huge power", "u*10**400", "too large a number"),
    rate_of_v("a huge number", "u*1e400", "larger than 1e+100"),
    rate_of_v("a huge exponent", "u**100000", "exponent larger than 1000"),
    rate_of_v("a long expression", "u" + " + u" * 2000, "name its parts under expressions:"),
    rate_of_v("a deep expression", "(" * 200 + "u" + ")" * 200, "nested deeper than 50"),
    rate_of_v("deep powers", "**".join(["u"] * 1200), "nested too deeply"),
    rate_of_v("many signs", "-" * 500 + "u", "write one sign"),
    rate_of_v("an empty expression", " ", "the expression is empty"),
    rate_of_v("a caret", "u^2", "write ** for a power"),
    rate_of_v("a missing operator", "2u", "write 2*u"),
    rate_of_v("a missing parenthesis", "sin(u", "add the missing )"),
    rate_of_v("a parenthesis too many", "u)", ") closes nothing"),
    rate_of_v("a function without parentheses", "sin u", "write sin(u)"),
    rate_of_v("a module", "np.sin(u)", "write sin"),
    rate_of_v("ln", "ln(u)", "write log(u)"),
    rate_of_v("arcsin", "arcsin(u/9)", "write asin(u/9)"),
    rate_of_v("abs", "u - abs(v)", "section 5.5"),
    rate_of_v("max", "max(u, v)", "nonsmooth: {tanh: 0.01}"),
    rate_of_v("an unknown function", "sine(u)", "did you mean sin?"),
    rate_of_v("two arguments", "sin(u, v)", "one argument"),
    rate_of_v(
        "a delay of a state", "u + v(t - 0.5)", "there are no delays; approximate a delay tau by states of its own"
    ),
    rate_of_v("a delay of a control", "v + u(t-c)", "there are no delays"),
    rate_of_v("a delay of a name like a function", "u - pos(t - 1)", "did you mean cos? If pos is a state or control"),
    rate_of_v("a delay in brackets", "u + v[t - 0.5]", "there are no delays"),
    rate_of_v("a delay by a function", "u + delay(v, 0.5)", "y with the rate (x - y)/tau"),
    rate_of_v("a state of time", "u - v(t)", "a state or control is written without (t): v"),
    *(
        rate_of_v(
            f"{name} of a state", f"u - {name}(v)", f'"{name}(v)" in "u - {name}(v)": there is no {name}: it jumps'
        )
        for name in ("floor", "ceil", "round", "heaviside")
    ),
    rate_of_v("a smooth switch", "u*heaviside(v)", "write step(x - a, eps)"),
    rate_of_v("a remainder", "mod(u, 2*pi)", "an angle needs none"),
    rate_of_v("a piecewise function", "piecewise(v > 0, u, 0)", "there is no piecewise: expressions have no branches"),
    rate_of_v("if as a function", "if(v > 0, u, 0)", "write a + (b - a)*step(x - c, eps)"),
    rate_of_v("if as a word", "u if v else 1", "write a + (b - a)*step(x - c, eps)"),
    rate_of_v("random numbers", "u + random()", "write a disturbance as a function of t"),
    rate_of_v("a derivative", "u + diff(x, t)", "write the expression of its rate"),
    rate_of_v("a derivative by der", "u + der(x)", "x[rate] in a residual"),
    rate_of_v("an integral", "u - integral(x)", "declare a state with this as its rate"),
    rate_of_v(
        "a sign", "u - c*sign(v)", "write sign(v, eps), where eps is the width of the smooth change, or tanh(v/eps)"
    ),
    rate_of_v("a step", "u*step(v - 1)", "write step(v - 1, eps), where eps is the width"),
    rate_of_v("a step by other means", "u + step(v - c)", "or (1 + tanh((v - c)/eps))/2"),
    rate_of_v("a smooth abs", "u - smooth_abs(v)", "smooth_abs needs a width, for its slope jumps"),
    rate_of_v("no width", "sign(v, m - 2)", '"sign(v, m - 2)" has a width that is not positive with m = 2'),
    rate_of_v("one argument", "u + atan2(v)", "atan2 takes two arguments, not 1"),
    rate_of_v("too many operands", f"norm({', '.join('u' * 21)})", "norm takes 2 to 20 arguments, not 21"),
    rate_of_v("an angle on the cut", "u + atan2(0, -m)", "has no value on the cut (y = 0 and x <= 0"),
    rate_of_v("arctan2", "arctan2(v, u)", "write atan2(v, u)"),
    rate_of_v("a comparison", "u > 0", "give the bounds as lower:, upper: or equals:"),
    rate_of_v("an index", "u[0]", "write u[initial]"),
    rate_of_v("a trailing operator", "u +", "write what stands after it"),
    rate_of_v("a superscript", "u²", "write **2"),
    rate_of_v("a division by zero", "u/(m - 2)", '"u/(m - 2)" divides by zero with m = 2'),
    rate_of_v("a logarithm of zero", "u + log(m - 2)", "is the logarithm of zero with m = 2"),
    rate_of_v("a root of a negative number", "u*sqrt(-m)", '"sqrt(-m)" is not a real number with m = 2'),
    edit("a parameter without a value", "T: 2*d", "T: 2/(d - 1)", "parameters.T", "divides by zero with d = 1"),
    edit("a bound without a value", "upper: 2,", "upper: log(d - 1),", "states.x.upper", "change the expression"),
]

OVERRIDES = [
    override("an override without a value", "parameters.d", "write parameters.u_max=15", "--set parameters.d"),
    override("an override of nothing", "=3", "this is not PATH=VALUE", "--set =3"),
    override("a misspelt parameter", "parameters.u_maxx=15", "did you mean u_max?"),
    override("a misspelt override", "solvr.max_iter=5", "did you mean solver?"),
    override("an override out of the list", "mesh.3.segments=5", "write an index from 0 to 0"),
    override("an override by a word", "mesh.first.segments=5", "write an index"),
    override("an override with a wrong value", "mesh.0.segments=many", "whole number"),
    override("an override that is not YAML", "parameters.d=[1", "close the bracket"),
    override("an override with a bomb", "parameters.d=" + "[" * 1000, "nested deeper"),
    override("an override that crosses bounds", "controls.u.lower=10", "lower 10 is above upper 5"),
    override("an override of all of nothing", "name.*=3", "nothing for * to mean"),
    override("an override of an expression", "states.v.rate=2u", "write 2*u"),
    override("an override with a double dot", "mesh..segments=5", "this is not a path"),
]
