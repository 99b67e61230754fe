"""Problem files that are made to be hard to read, to compile or to hold."""

from __future__ import annotations

HEAD = """
trajopt: 1
name: hard
time: {initial: 0, final: 1}
states: {x: {rate: RATE, initial: 0, final: 0.1}}
controls: {u: {lower: -2, upper: 2}}
objective: {minimize: {integral: COST}}
"""
MESH = "mesh: [{method: hermite-simpson, segments: 3}]\n"


def _of(rate: str = "u", cost: str = "u**2", more: str = MESH) -> str:
    return HEAD.replace("RATE", rate).replace("COST", cost) + more


def _chain(length: int, link: str, last: str = "e{}") -> str:
    named = "\n".join(f"  e{i}: {link.format(f'e{i - 1}' if i else 'x')}" for i in range(length))
    return _of(f"u + {last.format(length - 1)}", more=f"{MESH}expressions:\n{named}\n")


def _named(parts: int, each: str, joined: str = "*") -> str:
    """A product of named products."""
    named = "\n".join(f"  e{i}: '{each.replace('I', str(i))}'" for i in range(parts))
    return _of("u + " + joined.join(f"e{i}" for i in range(parts)), more=f"{MESH}expressions:\n{named}\n")


def _constant_residual(residual: str) -> str:
    return f"""
trajopt: 1
time: {{initial: 0, final: 1}}
states: {{x: {{initial: 0, final: 1}}, v: {{rate: F}}}}
algebraic: {{F: {{}}}}
objective: {{minimize: {{integral: F**2}}}}
residuals: ["x[rate] - F", {residual}]
{MESH}"""


def _mesh(entry: str, more: str = "") -> str:
    return _of(more=f"mesh: [{entry}]\n{more}")


def _constraint(kind: str, expression: str) -> str:
    return _of(more=f"{MESH}constraints: {{{kind}: [{{expression: {expression}, upper: 2}}]}}\n")


RESIDUALS = ("1", "0", "x - x", "'0*F + 2'", "pi", "F**0", "t", "0*t", "t - 1")
CONSTRAINTS = {
    "path": ("1", "x - x", "u**0"),
    "boundary": ("1", "'x[final] - x[final]'", "'x[initial]**0'"),
    "integral": ("1", "u - u"),
}

HARD: dict[str, str] = {
    **{f"residual {own}": _constant_residual(own) for own in RESIDUALS},
    **{f"{kind} {own}": _constraint(kind, own) for kind, many in CONSTRAINTS.items() for own in many},
    **{f"cost {own}": _of(cost=own) for own in ("1", "0", "u - u", "pi")},
    **{f"rate {own}": _of(rate=own) for own in ("1", "0.1", "0", "u - u")},
    **{f"chain of {k}": _chain(k, "{} + 1") for k in (40, 100, 300, 1000, 3000)},
    **{f"chain of sines, {k}": _chain(k, "sin({})") for k in (30, 100, 300)},
    **{f"Horner's scheme of {k}": _chain(k, "{}*u + 1.5") for k in (30, 100, 300)},
    **{f"doubling chain of {k}": _chain(k, "{0}*{0}") for k in (10, 30, 100)},
    **{f"doubling sum of {k}": _chain(k, "{0} + sin({0})") for k in (10, 30, 100)},
    **{f"product of {k}": _of("*".join(["u"] * k)) for k in (50, 300, 1900)},
    **{f"product of {k} sums": _of("*".join(f"(u+{i})" for i in range(2, k + 2))) for k in (10, 30, 98, 200, 400)},
    **{f"product of {k} sums in the cost": _of(cost="*".join(f"(u+{i})" for i in range(2, k + 2))) for k in (98, 400)},
    **{f"product of {k} cosines": _of("*".join(f"cos({i}*u)" for i in range(1, k + 1))) for k in (10, 30, 100, 300)},
    **{f"{k} quotients": _of("/".join(f"(x+{i})" for i in range(2, k + 2))) for k in (100, 400)},
    **{f"sum of {k}": _of(" + ".join([f"sin({i}*u)" for i in range(k)])) for k in (50, 200, 290)},
    **{f"sum of {k} names": _of("u" + " + u" * k) for k in (300, 990)},
    **{f"polynomial of {k}": _of(" + ".join(f"u**{i}" for i in range(2, k))) for k in (100, 350)},
    **{f"expanded power {k}": _of(f"(x + u + 1)**{k}") for k in (10, 100, 1000)},
    **{f"nest of {k}": _of("sin(" * k + "u" + ")" * k) for k in (30, 49)},
    **{f"tower of {k}": _of("**".join(["(x + 2)"] * k)) for k in (3, 10, 30, 49)},
    **{f"signs {k}": _of("-(" * k + "u" + ")" * k) for k in (30, 49)},
    "products of products": _named(20, "*".join(f"(u+{i}+I)" for i in range(1, 21))),
    "sums of products": _named(20, "*".join(f"(u+{i}+I)" for i in range(1, 21)), " + "),
    "many small sums": _named(300, "sin(u + I)", " + "),
    "three thousand names": _named(800, "x + I", " + "),
    "steps": _mesh("{method: runge-kutta-4, segments: 200000, substeps: 1000}"),
    "steps of a few": _mesh("{method: runge-kutta-4, segments: 20, substeps: 1000}"),
    "many substeps": _mesh("{method: runge-kutta-4, segments: 2000, substeps: 1001}"),
    "two hundred thousand of Gauss": _mesh("{method: gauss, segments: 200000, degree: 60}"),
    "many meshes": _of(more="mesh: [" + ", ".join(["{method: radau, segments: 3}"] * 500) + "]\n"),
    "a negative tolerance of the reference": _of(more=f"{MESH}reference: {{objective: 1, tolerance: -1}}\n"),
    "no tolerance of the reference": _of(more=f"{MESH}reference: {{objective: 1, tolerance: 0}}\n"),
    "a library": _of(more=f"{MESH}solver: {{linear_solver: ma57}}\n"),
    "a loud solver": _of(more=f"{MESH}solver: {{print_level: 12}}\n"),
    "a file of the solver's": _of(more=f"{MESH}solver: {{resto.output_file: /tmp/x}}\n"),
    "a unit that steers": _of(more=MESH).replace("final: 1}", 'final: 1, unit: "\\e]0;x\\a"}'),
}  # fmt: skip
"""Name -> a problem file."""
