"""The numbers that templates read: a slot in one long vector for each, and the slots at many indices at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..libraries.pyomo import VarData, value
from .templates import TemplateError


class Slots:
    """The vector of all numbers that templates read. `position` of a variable in z; `data`, what stands behind z."""

    def __init__(self, variables: Sequence[VarData]) -> None:
        self.n = len(variables)
        # By identity: == of two Pyomo variables is no comparison, it makes an expression.
        self.position = dict(zip(map(id, variables), range(self.n), strict=True))
        self.data: list[float] = []
        self._tables: dict[int, _Table] = {}
        self._single: dict[int, int] = {}

    def single(self, leaf: Any) -> int:
        """The slot of one VarData or ParamData."""
        slot = self.position.get(id(leaf), self._single.get(id(leaf)))
        if slot is None:
            if leaf.is_variable_type() and not leaf.fixed:
                raise TemplateError(f"{leaf.name} is neither among the compiled variables nor fixed")
            slot = self._single[id(leaf)] = self._append([value(leaf)])[0]
        return slot

    def table(self, component: Any) -> _Table:
        """The slots of an indexed Var or Param."""
        if id(component) not in self._tables:
            is_variable = issubclass(component._ComponentDataClass, VarData)
            make = self._variable_slots if is_variable else self._parameter_slots
            self._tables[id(component)] = _Table(component.name, *make(component))
        return self._tables[id(component)]

    def _append(self, values: Sequence[float]) -> range:
        start = self.n + len(self.data)
        self.data.extend(map(float, values))
        return range(start, self.n + len(self.data))

    def _variable_slots(self, component: Any) -> Any:
        keys, leaves = list(component.keys()), list(component.values())
        # A free variable that is not compiled is no mistake as long as no template reads it: `lookup` raises, not this.
        slots = np.array([self.position.get(i, -1) for i in map(id, leaves)], dtype=np.intp)
        for i in np.flatnonzero(slots < 0):
            if leaves[i].fixed:
                slots[i] = self.single(leaves[i])
        return keys, slots, None

    def _parameter_slots(self, component: Any) -> Any:
        # In their own type too, as the vector holds floats: a parameter may be an index, or part of one.
        values = component.extract_values()
        return list(values), np.array(self._append(values.values()), dtype=np.intp), np.array(list(values.values()))


class _Table:
    """Index -> slot for one component, for many indices at once.

    Each position of the index has a code (an integer less the lowest, or the rank of a name), and the codes together
    are a mixed-radix number that looks the slot up. -1 marks an index that does not exist, or a free variable that
    is not compiled.
    """

    def __init__(self, name: str, keys: list, slots: np.ndarray, values: np.ndarray | None) -> None:
        self.name, self.values = name, values
        positions = list(zip(*keys, strict=True)) if keys and isinstance(keys[0], tuple) else [keys]
        self.codes = [_codes(p) for p in positions]
        flat = np.zeros(len(keys), np.intp)
        for (radix, code), position in zip(self.codes, positions, strict=True):
            if callable(code):
                flat = flat * radix + np.fromiter(map(code, position), np.intp, len(keys))
            else:
                flat = flat * radix + (np.array(position, dtype=np.intp) - code)
        self.slots = np.full(int(np.prod([radix for radix, _ in self.codes])), -1, dtype=np.intp)
        self.order = np.zeros_like(self.slots)
        self.slots[flat], self.order[flat] = slots, np.arange(len(keys))

    def _flat(self, index: Sequence) -> Any:
        flat: Any = 0
        for (radix, code), i in zip(self.codes, index, strict=True):
            # Each position is checked by itself: a code out of its range would still make the number of another index.
            k = code(i) if callable(code) else i - code
            if k is None or np.min(k) < 0 or np.max(k) >= radix:
                raise TemplateError(f"{self.name} has no index {i}")
            flat = flat * radix + k
        if np.min(self.slots[flat]) < 0:
            raise TemplateError(f"{self.name} at index {index} does not exist, or is neither compiled nor fixed")
        return flat

    def lookup(self, index: Sequence) -> np.ndarray:
        """The slots at `index`, one entry (an integer array, an integer or a name) for each index position."""
        return self.slots[self._flat(index)]

    def value_at(self, index: Sequence) -> np.ndarray:
        """The values of a parameter at `index`, in their own type: integers stay integers."""
        if self.values is None:
            raise TemplateError(f"{self.name} is a variable and stands where only data can")
        return self.values[self.order[self._flat(index)]]


def _codes(values: Sequence) -> tuple[int, Callable | int]:
    distinct = dict.fromkeys(values)
    if distinct and all(isinstance(v, int | np.integer) for v in distinct):
        # Integers are shifted, not looked up: whole arrays of indices then take one subtraction.
        low = min(distinct)
        return max(distinct) - low + 1, low
    return len(distinct), {v: i for i, v in enumerate(distinct)}.get
