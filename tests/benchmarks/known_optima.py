"""Problems whose optimum is known: in closed form, or (REFERENCES) from solves far finer than the benchmark's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq, minimize_scalar

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.problems.problem import Guess, Phase, Problem
from trajopt.problems.quantities import Range, State, Variable


@dataclass(frozen=True)
class Known:
    """text: of the problem file; build: what builds it without one; else it is the shipped one of that name, with the
    overrides. segments: of a second-order method on the coarsest mesh."""

    name: str
    optimum: float
    text: str = ""
    overrides: tuple[str, ...] = ()
    segments: int = 20
    build: Callable[[], Problem] | None = None

    def problem(self) -> Problem:
        if self.build:
            return self.build()
        spec = load_text(self.text, f"{self.name}.yaml") if self.text else load(shipped()[self.name], self.overrides)
        return build_all(spec)[-1]


def cycloid() -> float:
    """The time from (0, 10) to (10, 5) on the cycloid through both."""
    phi = brentq(lambda p: (p - np.sin(p)) - 2 * (1 - np.cos(p)), 3, 4, xtol=1e-15)
    return phi * np.sqrt(5 / (1 - np.cos(phi)) / 9.80665)


def hyper_sensitive() -> float:
    """The cost of falling to 0 from 1.5 and of rising from it to 1, along the level H = 0; T is endless beside it."""
    x, w = np.polynomial.legendre.leggauss(60)

    def integral(f: Callable, end: float) -> float:
        t = (x + 1) * end / 2
        return float(w @ f(t)) * end / 2

    return integral(lambda s: s * np.sqrt(s**4 + 1) - s**3, 1.5) + integral(lambda s: s * np.sqrt(s**4 + 1) + s**3, 1.0)


def riccati(A: np.ndarray, B: np.ndarray, Q: np.ndarray, R: np.ndarray, T: float) -> np.ndarray:
    """P of the cost x0' P x0 = min integral of x' Q x + u' R u over [0, T] with a free end."""
    n = len(A)
    M = expm(-T * np.block([[A, -B @ np.linalg.solve(R, B.T)], [-Q, -A.T]]))
    return M[n:, :n] @ np.linalg.inv(M[:n, :n])


def oscillator() -> float:
    P = riccati(np.array([[0.0, 1.0], [-4.0, 0.0]]), np.array([[0.0], [1.0]]), np.diag([1.0, 0.0]), np.eye(1), 3.0)
    return float(np.array([1.0, 0.5]) @ P @ np.array([1.0, 0.5]))


def drift() -> float:
    """y' = u + p, y(0) = 1, cost p^2 + the integral of y^2 + u^2: the quadratic cost of (y, p) less its minimum."""
    P = riccati(np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[1.0], [0.0]]), np.diag([1.0, 0.0]), np.eye(1), 1.0)
    return float(P[0, 0] - P[0, 1] ** 2 / (P[1, 1] + 1))


def decay() -> float:
    """T + the least energy that takes x' = -x + u from 0 to 1 in T."""
    return minimize_scalar(lambda T: T + 1 / (1 - np.exp(-2 * T)), bounds=(0.1, 3), options={"xatol": 1e-9}).fun


def chain() -> float:
    """x = c cosh((t - a)/c) - m of length 4 from (0, 1) to (1, 3)."""
    c = brentq(lambda c: 4 * c**2 * np.sinh(0.5 / c) ** 2 - (16 - 4), 0.05, 5, xtol=1e-15)
    a = 0.5 - c * np.arctanh(2 / 4)
    shift = 1 - c * np.cosh(-a / c)
    s = (np.sinh(2 * (1 - a) / c) - np.sinh(-2 * a / c)) / 4
    return c * (1 / (2 * c) + s) * c + shift * 4


def two_phases() -> float:
    """x' = u through 1, 0.9 and 0.75 at t = 0, 0.75 and 1, cost the integral of x^2 + u^2: hyperbolic arcs."""

    def arc(a: float, b: float, T: float) -> float:
        return ((a * a + b * b) * np.cosh(T) - 2 * a * b) / np.sinh(T)

    return arc(1, 0.9, 0.75) + arc(0.9, 0.75, 0.25)


HEAD = "trajopt: 1\nname: {name}\n"
TAIL = "mesh: [{method: trapezoid, segments: 10, tolerance: 1.0e-8}]\n"


def _known(name: str, optimum: float, text: str, segments: int = 20) -> Known:
    return Known(name, optimum, HEAD.format(name=name) + text.strip() + "\n" + TAIL, segments=segments)


MIN_TIME = """
time: {initial: 0, final: {lower: 0.1, upper: 10, guess: 1}}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {lower: -1, upper: 2}}
objective: {minimize: {terminal: "t[final]"}}
guess: {constants: {v: 0.5}}
"""
FUEL = """
time: {initial: 0, final: 4}
states: {x: {rate: v, initial: 0, final: 2}, v: {rate: up - down, initial: 0, final: 0}}
controls: {up: {lower: 0, upper: 1}, down: {lower: 0, upper: 1}}
objective: {minimize: {integral: up + down}}
"""
SPEED_LIMIT = """
time: {initial: 0, final: 1}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0, upper: 1.22}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
"""
OSCILLATOR = """
time: {initial: 0, final: 3}
states: {x: {rate: v, initial: 1}, v: {rate: -4*x + u, initial: 0.5}}
controls: {u: {}}
objective: {minimize: {integral: x**2 + u**2}}
"""
GROWTH = """
time: {initial: 0, final: 1}
states: {x: {rate: z, initial: 2.718281828459045}}
controls: {u: {}}
algebraic: {z: {}}
residuals: [exp(z) - exp(u*x)]
objective: {minimize: {integral: log(x)**2 + u**2}}
guess: {constants: {x: 2}}
"""
DRIFT = """
time: {initial: 0, final: 1}
states: {x: {rate: (u + p)*x, initial: 2.718281828459045}}
controls: {u: {}}
optimize: {p: {guess: 0}}
objective: {minimize: {integral: log(x)**2 + u**2, terminal: p**2}}
guess: {constants: {x: 2}}
"""
DECAY = """
time: {initial: 0, final: {lower: 0.1, upper: 10, guess: 1}}
states: {x: {rate: -x + u, initial: 0, final: 1}}
controls: {u: {}}
objective: {minimize: {terminal: "t[final]", integral: u**2/2}}
"""
CHAIN = """
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 1, final: 3}}
controls: {u: {lower: -20, upper: 20}}
objective: {minimize: {integral: x*sqrt(1 + u**2)}}
constraints: {integral: [{name: length, expression: sqrt(1 + u**2), lower: 4, upper: 4}]}
guess: {keyframes: {x: [1, 1, 3], u: [0, 2, 4]}}
"""
MIXED = """
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0}}
controls: {u: {lower: -5, upper: 5}}
objective: {minimize: {integral: (x - 2)**2}}
constraints: {path: [{name: sum, expression: u + x, upper: 1}]}
"""
RAYLEIGH = """
time: {initial: 0, final: 4.5}
states: {x: {rate: y, initial: -5}, y: {rate: -x + y*(1.4 - 0.14*y**2) + 4*u, initial: -5}}
controls: {u: {}}
objective: {minimize: {integral: u**2 + x**2}}
constraints: {path: [{name: mixed, expression: u + x/6, upper: 0}]}
"""
RANGE = """
time: {initial: 0, final: 2}
states: {x: {rate: v*a, initial: 0}, y: {rate: v*b, initial: 0, final: 0.1}, v: {rate: 0.5 - b, initial: 0}}
controls: {a: {lower: -10, upper: 10}, b: {lower: -10, upper: 10}}
objective: {maximize: {terminal: "x[final]"}}
constraints: {path: [{name: circle, expression: a**2 + b**2, lower: 1, upper: 1}]}
guess: {constants: {a: 1, b: 0, v: 1}}
"""
SINGULAR = """
time: {initial: 0, final: {lower: 2, upper: 8, guess: 4}}
states: {x: {rate: v, initial: 2, final: 5}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {integral: (1 + v**2)/2}}
"""
LANDER = """
time: {initial: 0, final: {lower: 0.5, upper: 3, guess: 1.5}}
states:
  h: {rate: v, initial: 1, final: 0}
  v: {rate: -1 + T/m, initial: -0.783, final: 0}
  m: {rate: -T/2.349, initial: 1, lower: 0.1}
controls: {T: {lower: 0, upper: 1.227}}
objective: {minimize: {integral: T}}
guess: {constants: {T: 0.6, m: 0.8}}
"""
GODDARD = """
time: {initial: 0, final: {lower: 0.05, upper: 1, guess: 0.2}}
states:
  h: {rate: v, initial: 1, lower: 1}
  v: {rate: (T - 310*v**2*exp(-500*(h - 1)))/m - 1/h**2, initial: 0, lower: 0}
  m: {rate: -T/0.5, initial: 1, final: 0.6, lower: 0.6, upper: 1}
controls: {T: {lower: 0, upper: 3.5}}
objective: {maximize: {terminal: "h[final]"}}
guess: {keyframes: {h: [1, 1.01], v: [0.05, 0.05], m: [1, 0.6], T: [1.75, 1.75]}}
"""


def _interior_point() -> Problem:
    """Two phases that meet where their common value is given."""

    def phase(name: str, start: float, end: float, a: float, b: float) -> Phase:
        guess = Guess(start, end, np.array([0.0, 1.0]), {"x": np.array([a, b]), "u": np.zeros(2)})
        x = State("x", rate=lambda v, m: v["u"], initial=Range(a, a), final=Range(b, b))
        u = Variable("u", bounds=Range(-1.0, 1.0))
        cost = lambda v, m: v["x"] ** 2 + v["u"] ** 2  # noqa: E731
        return Phase(name, Range(start, start), Range(end, end), (x,), (u,), guess, lagrange=cost)

    return Problem("interior point", 1, (phase("first", 0, 0.75, 1, 0.9), phase("last", 0.75, 1, 0.9, 0.75)))


REFERENCES = {  # radau of degree 5, refined to 1e-11, engine to 1e-12, with the correction of `objective_error`
    "van_der_pol": 2.86726104522,
    "cartpole": 58.807667458167,
    "rayleigh": 44.80444490837,
    "range": 1.712314875075,
    "goddard": 1.012836918,
}

KNOWN = (
    Known("block_move_min_force", 12.0, segments=10),
    Known("bryson_denham", 4.0),
    Known("brachistochrone", cycloid()),
    Known("hyper_sensitive", hyper_sensitive(), overrides=("parameters.T=40",), segments=40),
    _known("minimum time", np.sqrt(3), MIN_TIME),
    _known("minimum fuel", 4 - np.sqrt(8), FUEL),
    _known("speed limit", 16 * 1.22**3 / 9 / 0.22, SPEED_LIMIT),
    _known("oscillator", oscillator(), OSCILLATOR),
    _known("growth, algebraic", np.tanh(1), GROWTH, 10),
    _known("drift, parameter", drift(), DRIFT, 10),
    _known("decay, free time", decay(), DECAY, 10),
    _known("hanging chain", chain(), CHAIN),
    _known("mixed constraint", 1 + 2 * (1 - np.exp(-1)) + (1 - np.exp(-2)) / 2, MIXED, 10),
    _known("singular arc", 10 / 3, SINGULAR),
    _known("lander", 1.4203125990, LANDER),
    Known("van_der_pol", REFERENCES["van_der_pol"]),
    Known("cartpole", REFERENCES["cartpole"], segments=40),
    _known("rayleigh", REFERENCES["rayleigh"], RAYLEIGH),
    _known("range", REFERENCES["range"], RANGE),
    Known("block_move_min_work", (10 - np.sqrt(80)) ** 2, segments=30),
    Known("interior point, two phases", two_phases(), segments=10, build=_interior_point),
    _known("goddard", REFERENCES["goddard"], GODDARD, 40),
)
