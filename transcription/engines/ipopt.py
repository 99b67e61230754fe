"""Compiled nonlinear program -> IPOPT through cyipopt -> Outcome."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any

import numpy as np

from ...problems.errors import Mistake, SpecError
from ...problems.text import did_you_mean
from ..program.contract import NonlinearProgram, NotFinite
from ..scaling import Scaling
from .ipopt_library import OPTION, load_library, loaded
from .linear_solvers import missing_libraries
from .outcome import COLUMNS, Outcome, Start, Status
from .rounding import met_to_rounding

MOST_RELAXED = 1e-10

DEFAULTS = {
    # IPOPT's own 1e-8 lets the optimum of Bryson and Denham's problem gain 3e-7, which no error estimate sees.
    "bound_relax_factor": MOST_RELAXED,
    "print_level": 0,
    "sb": "yes",
    "tol": 1e-8,
    # IPOPT's own 15 iterations at an acceptable point end solves that are still on their way: singular controls, where
    # the regularisation of the Hessian falls by a third in each.
    "acceptable_iter": 80,
    # IPOPT's own 1e20 is 3000 iterations away from an unbounded control that slows down on its way.
    "diverging_iterates_tol": 1e14,
    # Measured with the wheel's MUMPS over all shipped problems, three methods and 12 to 999 segments: 0.84 of the solve
    # time on average, the same iterations and objectives. The default ordering is superlinear on banded matrices.
    "mumps_pivot_order": 6,
    "min_refinement_steps": 0,
    # Where the Hessian needs regularising at all, it needs more than IPOPT's first try of 1e-4: the same iterations on
    # all shipped problems but two, and a factorisation or two saved in each iteration that is regularised.
    "first_hessian_perturbation": 1.0,
}

RELAXED = 0.01
"""Of the tolerance, and MOST_RELAXED at most: by how much bounds are relaxed. The optimum gains that times the
multipliers, 36 for Bryson and Denham's problem: 3.6e-9 by the default, whatever the mesh."""

LARGE, LARGE_DEFAULTS = 20_000, {"mumps_scaling": 0}
"""Unknowns from which on a program has more defaults. Measured at 10000 segments: 0.25 and 0.37 of the engine's time
for the cart-pole by trapezoid and Radau, 0.8 to 1.05 otherwise, and as many iterations or fewer. Smaller programs gain
nothing on average, and some take a tenth more iterations."""

LONG, OFTEN = 100, 50
"""Iterations after which it is asked whether a solve still leads anywhere, and between two such questions."""

OPTION_FILE = "option_file_name"

USER_SCALING = {"nlp_scaling_method": "user-scaling"}

FREQUENT_OPTIONS = (
    "acceptable_iter", "acceptable_tol", "bound_relax_factor", "constr_viol_tol", "derivative_test", "dual_inf_tol",
    "compl_inf_tol", "fixed_variable_treatment", "hessian_approximation", "hsllib", "linear_solver", "max_cpu_time",
    "max_iter", "max_wall_time", "mu_init", "mu_strategy", "mumps_permuting_scaling", "mumps_pivot_order",
    "mumps_scaling", "nlp_scaling_max_gradient", "nlp_scaling_method", "output_file", "print_level", "tol",
    "warm_start_init_point",
)  # fmt: skip
"""Only to suggest a name for one that IPOPT does not know; any option IPOPT knows is taken."""


WARM = {
    "warm_start_init_point": "yes", "mu_init": 1e-8,  # a larger one is where a loose tolerance stops
    "warm_start_bound_push": 1e-6, "warm_start_bound_frac": 1e-6,
    "warm_start_slack_bound_push": 1e-6, "warm_start_slack_bound_frac": 1e-6, "warm_start_mult_bound_push": 1e-8,
}  # fmt: skip


def solve_program(
    nlp: NonlinearProgram,
    z: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    options: Mapping[str, object] | None = None,
    start: Start | None = None,
    progress: Callable[[dict], None] | None = None,
    stop: Callable[[], bool] | None = None,
    scaling: Scaling | None = None,
    away: Callable[[np.ndarray], bool] | None = None,
) -> Outcome:
    """Minimise the compiled program from z, between lower and upper.

    nlp: gives the values, derivatives and bounds of the constraints.
    z: initial values of the unknowns, shape (n,).
    lower, upper: bounds of the unknowns, shape (n,); infinite where there is none.
    options: any of IPOPT's, over DEFAULTS and LARGE_DEFAULTS; and `library`, see `ipopt_library`.
    start: multipliers for a warm start; None for IPOPT's own.
    progress: called with each iteration's record, name in COLUMNS -> number.
    stop: asked at each iteration; true ends the solve with status INTERRUPTED and the last iterate.
    scaling: in place of IPOPT's own; the outcome is that of the unscaled program.
    away: asked now and then, after LONG iterations, of a point (n,) that has a better objective than the start; true
        ends the solve with status DIVERGING.

    Raises ValueError for an option that `check_options` would refuse, SpecError for a library that cannot be had.
    """
    options = _with_library(options or {})
    callbacks = _Callbacks(nlp, progress, stop, away)
    problem = _problem(n=nlp.n, m=nlp.m, problem_obj=callbacks, lb=lower, ub=upper, cl=nlp.cl, cu=nlp.cu)
    chosen = {**DEFAULTS, **(LARGE_DEFAULTS if nlp.n >= LARGE else {}), **(WARM if start else {})}
    if (tol := options.get("tol")) is not None:
        chosen["bound_relax_factor"] = min(MOST_RELAXED, RELAXED * float(str(tol)))
    chosen |= {**(USER_SCALING if scaling else {}), **options}
    if scaling:
        problem.set_problem_scaling(scaling.objective, scaling.z, scaling.g)
    _learn_reals(options)
    for name, value in chosen.items():
        if not _accepts(problem, name, value):
            raise ValueError(f"IPOPT does not take {name} = {value!r}")
    multipliers = (start.y, start.z_lower, start.z_upper) if start else ()
    z, info = problem.solve(z, *multipliers)
    status = Status.DIVERGING if callbacks.is_away else Status.from_code(info["status"])
    if status in (Status.ACCEPTABLE, Status.STALLED):
        last = {name: values[-1] for name, values in callbacks.record.items()}
        found = np.concatenate([info["mult_g"], info["mult_x_L"], info["mult_x_U"]])
        if met_to_rounding(nlp, z, found, last, float(str(chosen["tol"]))):
            status = Status.SOLVED
    return Outcome(
        status=status,
        z=z,
        y=info["mult_g"],
        z_lower=info["mult_x_L"],
        z_upper=info["mult_x_U"],
        objective=float(info["obj_val"]),
        iterations={name: np.array(values) for name, values in callbacks.record.items()},
        solver={
            "engine": "ipopt",
            "ipopt": loaded().version,
            OPTION: loaded().library,
            **chosen,
            "scaling": json.dumps(scaling.sizes if scaling else None),
        },
        failed=callbacks.failed,
    )


_REAL: set[str] = set()
"""Options that have turned out to take real numbers."""
_WHOLE = frozenset({"max_iter", "print_level", *(name for name, value in DEFAULTS.items() if isinstance(value, int))})


def check_options(options: Mapping[str, object]) -> list[Mistake]:
    """Ask IPOPT itself whether it takes each option; mistakes stand at solver.<name>."""
    try:
        options = _with_library(options)
    except SpecError as error:
        return list(error.mistakes)
    listener = _listener(load_library())
    mistakes = []
    for name, value in options.items():
        if not _accepts(listener, name, value):
            known = () if name in FREQUENT_OPTIONS else FREQUENT_OPTIONS  # then it is the value
            remedy = did_you_mean(name, known, otherwise="IPOPT's documentation lists its options and their values")
            mistakes.append(Mistake(f"solver.{name}", f"IPOPT does not take {name} = {value!r}", remedy))
    if mistakes:
        return mistakes
    missing = missing_libraries(options, partial(_silent_problem, options))
    return [Mistake(f"solver.{name}", *told) for name, told in missing.items()]


def _with_library(options: Mapping[str, object]) -> dict[str, object]:
    """IPOPT's own of the options, once the library is loaded that they name. Raises SpecError."""
    wanted = options.get(OPTION)
    load_library(None if wanted is None else str(wanted))
    return {name: value for name, value in options.items() if name != OPTION}


@cache
def _listener(library: Any) -> Any:
    """The problem that is asked whether a library takes an option; it is not solved with what it takes."""
    return _silent_problem({})


def _silent_problem(options: Mapping[str, object]) -> Any:
    """A problem of one unknown with these options. IPOPT prints no words of its own about one that it refuses.

    It obeys the print level only from its first solve on, which takes 3 ms.
    """
    problem = _problem(n=1, m=0, problem_obj=_Nothing(), lb=[0.0], ub=[1.0], cl=[], cu=[])
    problem.add_option("print_level", 0)
    problem.add_option("sb", "yes")
    problem.solve(np.array([0.5]))
    for name, value in options.items():
        _accepts(problem, name, value)
    return problem


def _problem(**definition: Any) -> Any:
    """A new problem of cyipopt that takes its options from the caller only.

    IPOPT reads the file `ipopt.opt` in the current folder at each solve, if there is one, unless the name of that
    file is empty: it would change results, write files and load libraries without a word.
    """
    problem = load_library().Problem(**definition)
    problem.add_option(OPTION_FILE, "")
    return problem


def _accepts(problem: Any, name: str, value: object) -> bool:
    if name.lower().rpartition(".")[2] == OPTION_FILE:  # behind a prefix it is no other option
        return False
    attempts: tuple[object, ...] = (value,)
    if isinstance(value, int):  # IPOPT tells 1 from 1.0
        attempts = (float(value),) if name in _REAL else (value, float(value))
    for attempt in attempts:
        try:
            problem.add_option(name, attempt)
        except TypeError:
            continue
        if attempt is not value:
            _REAL.add(name)
        return True
    return False


def _learn_reals(options: Mapping[str, object]) -> None:
    """Find out which whole numbers are of options that take real ones, where IPOPT prints nothing of its own."""
    for name in [name for name, value in options.items() if isinstance(value, int) and name not in _WHOLE | _REAL]:
        _accepts(_listener(load_library()), name, options[name])


class _Nothing:
    """The least that cyipopt takes for a problem."""

    def objective(self, z: np.ndarray) -> float:
        return 0.0

    def gradient(self, z: np.ndarray) -> np.ndarray:
        return np.zeros_like(z)


class _Callbacks:
    """The functions IPOPT calls, with a record of each iteration and of the last evaluation that was not finite."""

    def __init__(
        self,
        nlp: NonlinearProgram,
        progress: Callable[[dict], None] | None,
        stop: Callable[[], bool] | None,
        away: Callable[[np.ndarray], bool] | None,
    ) -> None:
        self.nlp, self.progress, self.stop, self.away = nlp, progress, stop, away
        self.tried = np.zeros(nlp.n)
        self.is_away = False
        self.record: dict[str, list[float]] = {name: [] for name in COLUMNS}
        self.failed: tuple[np.ndarray, list] | None = None

    def _finite(self, function: Callable, z: np.ndarray, *args: Any) -> Any:
        try:
            return function(z, *args)
        except NotFinite as error:
            self.failed = (np.array(z), error.names)
            raise load_library().CyIpoptEvaluationError from error

    def objective(self, z: np.ndarray) -> float:
        self.tried = z
        return self._finite(self.nlp.objective, z)

    def gradient(self, z: np.ndarray) -> np.ndarray:
        return self._finite(self.nlp.gradient, z)

    def constraints(self, z: np.ndarray) -> np.ndarray:
        return self._finite(self.nlp.constraints, z)

    def jacobianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        return self.nlp.jacobianstructure()

    def jacobian(self, z: np.ndarray) -> np.ndarray:
        return self._finite(self.nlp.jacobian, z)

    def hessianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        return self.nlp.hessianstructure()

    def hessian(self, z: np.ndarray, y: np.ndarray, sigma: float) -> np.ndarray:
        return self._finite(self.nlp.hessian, z, y, sigma)

    def intermediate(self, *values: float) -> bool:
        for name, value in zip(COLUMNS, values, strict=True):
            self.record[name].append(value)
        if self.progress:
            self.progress(dict(zip(COLUMNS, values, strict=True)))
        self.is_away = self._is_away()
        return not (self.is_away or (self.stop and self.stop()))

    def _is_away(self) -> bool:
        objectives = self.record["objective"]
        done = len(objectives) - 1
        if not self.away or done < LONG or done % OFTEN or not objectives[-1] < objectives[0]:
            return False
        return self.away(self.tried)
