"""One phase of the nonlinear program of a shooting method: values, derivatives, costates, and where they stand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from typing import Any

import numpy as np

from ..collocation.forms import form_of_phase
from ..layout import Layout
from ..method_kind import TIMES
from ..program.direct import Direct
from ..program.pointwise import PointFunctions
from ..schemes.segment import SegmentGroup
from .rows import PhaseRows, path_constraints
from .simulation import STEP, Segments


class PhaseProgram:
    """One phase: its groups of segments, its functions of the ends, and where everything goes."""

    def __init__(
        self,
        layout: Layout,
        rows: PhaseRows,
        parameters: np.ndarray,
        names: list[str],
        seconds: dict,
        m: int,
        values_only: bool,
    ) -> None:
        phase, mesh = layout.phase, layout.mesh
        self.layout, self.rows, self.phase = layout, rows, phase
        self.n, self.has_cost = len(phase.states), int(phase.lagrange is not None)
        ranges = phase.initial_time, phase.final_time
        self.t_fixed = np.array([r.lower if place < 0 else 0.0 for r, place in zip(ranges, layout.t, strict=True)])
        point = [v.name for v in (*phase.states, *phase.inputs)] + names
        free = (layout.t >= 0).any()
        split = ([*point, "t", STEP], []) if free else (point, ["t", STEP])
        integrands = [*([phase.lagrange] if phase.lagrange else []), *(c.function for c in phase.integral)]
        scaled = [_times_step(f) for f in [*(state.rate for state in phase.states), *integrands]]
        self.numbers = form_of_phase(phase, values_only).data
        dynamics = PointFunctions(scaled, *split, seconds, self.numbers)
        path = PointFunctions([c.function for _, c in path_constraints(phase)], *split, seconds, self.numbers)
        sizes = self.n, len(phase.inputs), len(names)
        self.groups = []
        for group in mesh.groups:
            columns, fixed = self._segment_columns(group, parameters)
            self.groups.append(Segments(mesh, group, sizes, columns=columns, fixed=fixed, dynamics=dynamics, path=path,
                                        bounded=rows.bounded))  # fmt: skip
        self.final = self._final(path, parameters, rows.final)
        self.ends = self._ends(parameters, names, seconds, np.append(rows.boundary, m))

    def _segment_columns(self, group: SegmentGroup, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        layout, count = self.layout, len(group.segments)
        x = layout.x[:, group.nodes[:, 0]].T
        u = layout.u[:, group.collocated].transpose(1, 2, 0).reshape(count, -1)
        border = np.tile(np.concatenate([layout.t, parameters]), (count, 1))
        fixed = np.concatenate([np.zeros(self.n), self.t_fixed, np.zeros(len(parameters) + u.shape[1])])
        return np.hstack([x, border, u]), fixed

    def _final(self, path: PointFunctions, parameters: np.ndarray, rows: np.ndarray) -> Direct:
        """The path constraints at the final point, whose state is an unknown."""
        layout, last = self.layout, self.layout.mesh.collocated[-1]
        columns = np.concatenate([layout.x[:, -1], layout.u[:, last], parameters, layout.t[1:], [-1]])
        fixed = np.concatenate([np.zeros(len(columns) - 2), self.t_fixed[1:], [0.0]])
        return Direct(path, columns, fixed, rows)

    def _ends(self, parameters: np.ndarray, names: list[str], seconds: dict, rows: np.ndarray) -> Direct:
        """The boundary constraints, the terminal objective last; inputs at the ends are those of the nodes nearest."""
        layout, phase, nodes = self.layout, self.phase, self.layout.mesh.collocated
        variables: list[tuple[str, int, float]] = []
        data: list[tuple[str, int, float]] = []
        own = [v.name for v in (*phase.states, *phase.inputs)]
        for end, x, u in (("initial", 0, nodes[0]), ("final", -1, nodes[-1])):
            places = np.concatenate([layout.x[:, x], layout.u[:, u]]).tolist()
            variables += [(f"{name}[{end}]", place, 0.0) for name, place in zip(own, places, strict=True)]
        variables += [(name, place, 0.0) for name, place in zip(names, parameters.tolist(), strict=True)]
        for end, place, value in zip(("initial", "final"), layout.t.tolist(), self.t_fixed, strict=True):
            (data if place < 0 else variables).append((f"t[{end}]", place, value))
        functions = [*(c.function for c in phase.boundary), *([phase.mayer] if phase.mayer else [])]
        compiled = PointFunctions(functions, [v[0] for v in variables], [v[0] for v in data], seconds, self.numbers)
        _, columns, fixed = zip(*variables, *data, strict=True)
        return Direct(compiled, np.array(columns), np.array(fixed), rows[: len(functions)])

    def with_number(self, name: str, value: float) -> PhaseProgram:
        """The same with another number, good for values only: of a parameter that is data, or of a given time."""
        other = copy(self)
        other.groups = [group.with_number(name, value) for group in self.groups]
        # the path constraints at the final point have the time there among their arguments
        other.final = self.final.with_number("t" if name == TIMES[1] else name, value)
        other.ends = self.ends.with_number(name, value)
        return other

    def move(self, z: np.ndarray) -> None:
        self.z = z
        for group in self.groups:
            group.move(z)
        self.final.move(z)
        self.ends.move(z)

    # -- values ----------------------------------------------------------------------------------------------------

    def cost(self) -> float:
        integral = sum(float(s.x[:, -1, self.n].sum()) for s in self.groups) if self.has_cost else 0.0
        return integral + (float(self.ends.values()[-1]) if self.phase.mayer else 0.0)

    def integrals(self) -> np.ndarray:
        """The integral of the objective, if it has one, and the constrained ones on each segment, (integrals, N)."""
        totals = np.empty((self.has_cost + len(self.phase.integral), self.layout.mesh.segments))
        for s, group in zip(self.groups, self.layout.mesh.groups, strict=True):
            totals[:, group.segments] = s.x[:, -1, self.n :].T
        return totals

    def constraints(self, g: np.ndarray) -> None:
        rows, n, groups = self.rows, self.n, self.layout.mesh.groups
        for s, group, defects, path, bounds in zip(
            self.groups, groups, rows.defects, rows.path, rows.bounds, strict=True
        ):
            g[defects] = self.z[self.layout.x[:, group.nodes[:, -1]].T] - s.x[:, -1, :n]
            g[path] = s.path.values(s.points)
            g[bounds] = s.points[:, 1:, s.bounded]
        g[rows.integral] = sum(s.x[:, -1, n + self.has_cost :].sum(axis=0) for s in self.groups)
        g[rows.final] = self.final.values()
        g[rows.boundary] = self.ends.values()[: len(rows.boundary)]

    # -- first derivatives -----------------------------------------------------------------------------------------

    def gradient(self, size: int) -> np.ndarray:
        """d cost / dz, with one entry more for what is fixed."""
        g = np.zeros(size)
        if self.has_cost:
            for s in self.groups:
                s.differentiate()
                g += np.bincount(s.columns.ravel() % size, s.end_tangents[:, self.n].ravel(), size)
        if self.phase.mayer:
            last = self.ends.o == len(self.rows.boundary)
            g += np.bincount(self.ends.columns[self.ends.j[last]], self.ends.jacobian()[last], size)
        return g

    def jacobian_places(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """(rows, columns, whether they are nonzeros) of the blocks of `jacobian_blocks`, each of one shape."""
        blocks, rows = [], self.rows
        for s, group, *own in zip(
            self.groups, self.layout.mesh.groups, rows.defects, rows.path, rows.bounds, strict=True
        ):
            defects, path, bounds = own
            following = self.layout.x[:, group.nodes[:, -1]].T
            integral = np.tile(rows.integral, (len(s.columns), 1))
            causal = s.causal[:, None]
            blocks += [
                (defects, following, following >= 0),
                *(_block(r, s.columns, mask) for r, mask in (
                    (defects, True), (path, causal), (bounds, causal[1:]), (integral, True))),
            ]  # fmt: skip
        for direct in (self.final, self.ends):
            kept = direct.o < len(direct.rows) - (direct is self.ends and self.phase.mayer is not None)
            blocks.append((direct.rows[direct.o], direct.columns[direct.j], kept))
        return blocks

    def jacobian_blocks(self) -> list[np.ndarray]:
        blocks, n = [], self.n
        for s in self.groups:
            s.differentiate()
            blocks += [np.ones((len(s.columns), n)), -s.end_tangents[:, :n], s.path_tangents, s.bound_tangents,
                       s.end_tangents[:, n + self.has_cost :]]  # fmt: skip
        return [*blocks, self.final.jacobian(), self.ends.jacobian()]

    # -- second derivatives ----------------------------------------------------------------------------------------

    def multipliers(self, s: Segments, number: int, y: np.ndarray, sigma: float) -> tuple[np.ndarray, ...]:
        """Multipliers of the ends of the segments of one group, of g and of the bounds at their points, as `adjoint`.

        s: the group.
        number: of it.
        y: (m,) multipliers of the rows.
        sigma: of the objective.
        """
        common = np.concatenate([np.full(self.has_cost, sigma), y[self.rows.integral]])
        end = np.hstack([-y[self.rows.defects[number]], np.tile(common, (len(s.columns), 1))])
        return end, y[self.rows.path[number]], y[self.rows.bounds[number]]

    def hessian_places(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        blocks = []
        for s in self.groups:
            a, b = np.tril_indices(s.columns.shape[1])
            places = s.columns[:, a], s.columns[:, b]
            blocks.append((np.maximum(*places), np.minimum(*places), np.minimum(*places) >= 0))
        for direct in (self.final, self.ends):
            places = direct.columns[direct.a], direct.columns[direct.b]
            blocks.append((np.maximum(*places), np.minimum(*places), np.ones(len(direct.a), bool)))
        return blocks

    def hessian_blocks(self, y: np.ndarray, sigma: float) -> list[np.ndarray]:
        blocks = []
        for number, s in enumerate(self.groups):
            a, b = np.tril_indices(s.columns.shape[1])
            blocks.append(s.hessian(*self.multipliers(s, number, y, sigma))[:, a, b])
        at_ends = np.append(y[self.rows.boundary], [sigma] * (self.phase.mayer is not None))
        return [*blocks, self.final.hessian(y[self.rows.final]), self.ends.hessian(at_ends)]

    # -- costates ----------------------------------------------------------------------------------------------------

    def costate(self, y: np.ndarray, sigma: float) -> np.ndarray:
        """lambda at the slots of the mesh, shape (n, K + N - 1), for the minimised objective.

        It is the derivative of the Lagrangian's remaining terms by the state. A constraint at a point belongs to both
        sides by halves, as in collocation, where the point has halves of its weight in both; wholly at the ends.
        """
        mesh = self.layout.mesh
        costate = np.zeros((self.n, len(mesh.slot_points)))
        at_point = np.zeros((self.n, mesh.segments + 1))
        at_point[:, -1] = y[self.rows.final] @ self.final.functions.jacobian(self.final.arguments)[:, : self.n]
        for number, (s, group) in enumerate(zip(self.groups, mesh.groups, strict=True)):
            end, path, bound = self.multipliers(s, number, y, sigma)
            _, after, own = s.adjoint(end, path, bound)
            starts = group.slots[:, : -1 : s.scheme.stride]
            costate[:, starts] = (after + own / 2).transpose(2, 0, 1)
            costate[:, group.slots[:, -1]] = end[:, : self.n].T
            at_point[:, group.segments] = own[:, 0].T
        costate[:, mesh.offset[0]] += at_point[:, 0] / 2
        costate[:, mesh.offset + mesh.degrees] -= at_point[:, 1:] * np.append(np.full(mesh.segments - 1, 0.5), 1.0)
        for s, group in zip(self.groups, mesh.groups, strict=True):
            costate[:, group.slots] = costate[:, group.slots] @ s.scheme.costate_basis(s.scheme.sigma).T
        return costate


def _times_step(function: Callable) -> Callable:
    def scaled(values: Mapping, functions: Any) -> Any:
        return values[STEP] * function(values, functions)

    return scaled


def _block(rows: np.ndarray, columns: np.ndarray, mask: np.ndarray | bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The places of derivatives of rows (G, ...) by all unknowns of their segments, columns (G, n_y)."""
    lifted = columns.reshape(len(columns), *[1] * (rows.ndim - 1), -1)
    shape = (*rows.shape, columns.shape[1])
    return (
        np.broadcast_to(rows[..., None], shape),
        np.broadcast_to(lifted, shape),
        np.broadcast_to((lifted >= 0) & mask, shape),
    )
