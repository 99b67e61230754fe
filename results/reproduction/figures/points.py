"""Gauss, Radau and Lobatto points of the Legendre polynomial of degree four, section 9.7 and appendix D: Figure 19."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.polynomial.legendre import Legendre

from ....transcription.schemes.orthogonal import gauss, lobatto, radau_left
from ....transcription.schemes.polynomials import barycentric_weights, integrated_basis, lagrange_basis
from ...pictures.style import BLACK, BLUE, GREEN, VERMILION
from .example import Example, Picture, Solutions, largest, panel_grid

DEGREE = 4
# The schemes' segments are [0, 1], the paper's [-1, 1]; its Radau points, roots of P4 + P3, hold the left end. Its
# Lobatto points are the roots of dP3/dt and both ends, four points as in the other sets; our degree of such a set is 3.
POINTS = {"Gauss": 2 * gauss(DEGREE) - 1, "Radau": 2 * radau_left(DEGREE) - 1, "Lobatto": 2 * lobatto(DEGREE - 1) - 1}
COLOURS = {"Gauss": BLUE, "Radau": VERMILION, "Lobatto": GREEN}
MARKERS = {"Gauss": "o", "Radau": "s", "Lobatto": "D"}


def function(t: np.ndarray) -> np.ndarray:
    """The curve that is interpolated on [-1, 1]."""
    return np.sin(2.6 * t + 0.4) + 0.3 * np.cos(4.5 * t)


def interpolant(name: str, t: np.ndarray) -> np.ndarray:
    """The barycentric interpolant (D.3) by one of the sets, at times t."""
    points = POINTS[name]
    return lagrange_basis(points, t) @ function(points)


def measure(solved: Solutions) -> dict[str, float]:
    P4, P3 = Legendre.basis(DEGREE), Legendre.basis(DEGREE - 1)
    t = POINTS
    v = {name: barycentric_weights(points) for name, points in t.items()}
    weights = {"Gauss": v["Gauss"] ** 2 / (1 - t["Gauss"] ** 2), "Lobatto": v["Lobatto"] ** 2}
    numbers = {
        f"{name} weights by ({equation}) against the scheme": largest(2 * w / w.sum() - _weights(t[name]))
        for (name, w), equation in zip(weights.items(), ("D.9", "D.10"), strict=True)
    }
    return {
        "largest |P4| at the Gauss points": largest(P4(t["Gauss"])),
        "largest |P4 + P3| at the Radau points": largest(P4(t["Radau"]) + P3(t["Radau"])),
        "largest |(1 - t^2) dP3/dt| at the Lobatto points": largest((1 - t["Lobatto"] ** 2) * P3.deriv()(t["Lobatto"])),
        **numbers,
    }


def _weights(points: np.ndarray) -> np.ndarray:
    """Quadrature weights on [-1, 1] as the schemes have them: integrals of the Lagrange polynomials."""
    return 2 * integrated_basis((points + 1) / 2, np.ones(1))[0]


def three_sets(solved: Solutions) -> Figure:
    figure, (row,) = panel_grid([2.4], 3, 2.35, across=0.25)
    t = np.linspace(-1, 1, 401)
    for ax, (name, points) in zip(row, POINTS.items(), strict=True):
        ax.plot(t, function(t), color=BLACK, linestyle="--", linewidth=1.3, label="function")
        ax.plot(t, interpolant(name, t), color=COLOURS[name], linewidth=1.8, label="interpolant")
        ax.plot(points, function(points), MARKERS[name], color=COLOURS[name], markersize=6, zorder=3)
        ax.plot(points, np.full_like(points, -1.75), MARKERS[name], color=COLOURS[name], markersize=5, clip_on=False)
        ax.axhline(-1.75, color=BLACK, linewidth=0.8, zorder=1)
        ax.set_title(name, loc="left")
        ax.set_title(f"error {largest(interpolant(name, t) - function(t)):.2g}", loc="right", fontsize="small")
        ax.set_ylim(-2.0, 2.0)
        ax.set_xlabel("$t$")
        ax.legend(loc="upper left", fontsize=7.5)
    for ax in row[1:]:
        ax.tick_params(labelleft=False)
    row[0].set_ylabel("$f(t)$")
    return figure


EXAMPLE = Example(
    name="points",
    title="Orthogonal collocation points (section 9.7, appendix D)",
    runs={},
    measure=measure,
    pictures=(
        Picture(
            "fig19_collocation_points",
            "Figure 19. Gauss, Radau and Lobatto points",
            "The three sets for the Legendre polynomial of degree four: without the ends, with one, with both. The "
            "dashed curve is the same in each panel (chosen by us); the solid one is its barycentric interpolant by "
            "the four points, which are repeated on the line below. Points and interpolants are those of the "
            "solver's schemes.",
            three_sets,
        ),
    ),
)
