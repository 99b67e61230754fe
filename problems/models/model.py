"""The contract of a model in Python: names, units and equations; values and bounds are the problem file's.

A model names its parameters, states, controls and algebraic variables. Given numbers for the parameters it builds the
equations, which are functions as `problems.problem.Function` describes them: called with a mapping of names to numbers,
NumPy arrays or Pyomo expressions, and with the module that holds sin, cos, ... for these. Functions of the boundary get
the names "q1[initial]" and "q1[final]".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any

import numpy as np

from ..lean.records import dataclass
from ..quantities import Function, Range


@dataclass(frozen=True)
class Quantity:
    """What a problem file is told of a parameter, a state, a control or an algebraic variable."""

    unit: str = ""
    note: str = ""


@dataclass(frozen=True)
class Equations:
    """A model with numbers for its parameters.

    rates: name of each state -> dx/dt. residuals: functions that are zero at every time, as many as algebraic
    variables. path and boundary: constraints that belong to the model, name -> (function, range). outputs: quantities
    of t, x, u that expressions of the problem file may use by name.
    """

    rates: Mapping[str, Function]
    residuals: Mapping[str, Function] = field(default_factory=dict)
    path: Mapping[str, tuple[Function, Range]] = field(default_factory=dict)
    boundary: Mapping[str, tuple[Function, Range]] = field(default_factory=dict)
    outputs: Mapping[str, Function] = field(default_factory=dict)


@dataclass(frozen=True)
class OfModel:
    """A function of a model with numbers for its parameters, equal to another of the same numbers.

    model: its name. group, name: which function of its equations. numbers: of the parameters.
    """

    model: str
    group: str
    name: str
    numbers: tuple[tuple[str, float], ...]
    function: Function = field(compare=False, repr=False)

    def __call__(self, values: Mapping[str, Any], functions: Any) -> Any:
        return self.function(values, functions)

    @property
    def parameters(self) -> Mapping[str, float]:
        """The numbers by name."""
        return dict(self.numbers)

    @property
    def constants(self) -> frozenset[str]:
        """The names of the parameters: as of `Expression.constants`."""
        return frozenset(self.parameters)


@dataclass(frozen=True)
class Model:
    """A shipped model.

    build: values of all parameters by name -> Equations. pose: for drawings, (values of the states at one time, values
    of the parameters) -> name of each part -> its joints, shape (K, 2): x and y, to be joined by straight lines.
    """

    name: str
    source: str
    parameters: Mapping[str, Quantity]
    states: Mapping[str, Quantity]
    controls: Mapping[str, Quantity]
    build: Callable[[Mapping[str, float]], Equations]
    algebraic: Mapping[str, Quantity] = field(default_factory=dict)
    pose: Callable[[Mapping[str, float], Mapping[str, float]], Mapping[str, np.ndarray]] | None = None

    def equations(self, parameters: Mapping[str, float]) -> Equations:
        """The equations with these parameters, whose functions are `OfModel`."""
        built, numbers = self.build({name: float(value) for name, value in parameters.items()}), (*parameters.items(),)

        def told(group: str, functions: Mapping[str, Function]) -> dict[str, Function]:
            return {name: OfModel(self.name, group, name, numbers, own) for name, own in functions.items()}

        def bounded(group: str) -> dict[str, tuple[Function, Range]]:
            given: Mapping[str, tuple[Function, Range]] = getattr(built, group)
            functions = told(group, {name: function for name, (function, _) in given.items()})
            return {name: (functions[name], bounds) for name, (_, bounds) in given.items()}

        plain = {group: told(group, getattr(built, group)) for group in ("rates", "residuals", "outputs")}
        return Equations(**plain, path=bounded("path"), boundary=bounded("boundary"))
