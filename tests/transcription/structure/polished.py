"""What the tests of polish share: solved problems to polish, and a time that is known."""

from scipy.optimize import brentq

from trajopt.results.polish.polish import Polished
from trajopt.transcription.continuation import solve_spec
from trajopt.transcription.loading import build_checked, load_file, load_yaml


def limited_energy():
    """The least time from rest to rest over 1 with |u| <= 1, whose square has an integral of 1.8 at most.

    u = 1 until a, then down to -1 in a time 2 d, and -1: a + d/3 = 0.9.
    """

    def too_far(d):
        a = 0.9 - d / 3
        return a * (a + d) - a**2 / 2 + d**2 / 3 - 0.5

    d = brentq(too_far, 0, 2)
    return 2 * (0.9 + 2 * d / 3)


def first(text, *overrides):
    """The solution of a text, or of a shipped problem by its name."""
    spec = load_yaml(text, overrides) if "\n" in text else load_file(text, overrides)
    (problems,) = build_checked([spec])
    return Polished(solve_spec(spec, problems), spec)
