"""The builder of every collocation scheme: one defect, for all rows of the table in `schemes`.

On segment s of duration h, with the states x_i at the scheme's state nodes and the dynamics f_j at its collocation
nodes,

    sum_i L[r, i] x_i  ==  h sum_j R[r, j] f_j

A state that the scheme eliminates is no variable: it is written out wherever it occurs, from the defect that defines
it. Segments of one scheme share their templates. Where a defect has the dynamics of two nodes at most (the differential
form), its rows differ only in their coefficients, so that one template, indexed by row, serves all rows of all
segments, whatever the degree; otherwise there is one template for each row, indexed by segment.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from ...problems.problem import Curves
from ...problems.quantities import State
from ...problems.sets import without
from ..constraint_kinds import DEFECT
from ..libraries.pyomo import Constraint, RangeSet, Set, pyomo
from ..program.templates import item
from ..schemes.scheme import Scheme, collocation_scheme
from ..schemes.segment import SegmentGroup
from .builder import PhaseBuilder
from .delays import add_delays
from .place import Place, Values
from .point_rows import PointRows, point_rows


class CollocationBuilder(PhaseBuilder):
    """Fills the block of one phase by the `schemes.Scheme` of each of its segments."""

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.names = [state.name for state in self.phase.states]
        self.schemes = [collocation_scheme(group.scheme) for group in self.mesh.groups]
        eliminated = [[node for node, _ in scheme.eliminated] for scheme in self.schemes]
        pairs = zip(self.mesh.groups, eliminated, strict=True)
        gone = np.concatenate([group.nodes[:, np.array(nodes, int)].ravel() for group, nodes in pairs])
        self.kept = without(self.mesh.slot_points, gone)
        self.explicit = without(self.mesh.collocated, gone)

    def stored(self) -> tuple[list[str], np.ndarray]:
        return self.names, self.kept

    def variables(self, guess: Curves) -> None:
        super().variables(guess)
        block, mesh = self.block, self.mesh
        self.explicit_set = self.points("explicit", self.explicit)
        self.data("weight", self.explicit_set, mesh.weights[self.explicit])
        self.data("width", block.segment, mesh.widths)
        self.data("first", block.segment, mesh.first)
        self.members = [self._set_of(f"segment{i}", g.segments) for i, g in enumerate(mesh.groups)]

    def _set_of(self, name: str, segments: np.ndarray) -> Any:
        """The Set of a group's segments; the Set of all segments if they are all."""
        if len(segments) == self.mesh.segments:
            over = self.block.segment
        else:
            over = Set(initialize=segments.tolist())
            self.block.add_component(name, over)
        self.owners[over.name] = segments
        return over

    def h(self, s: Any) -> Any:
        return self.duration * item(self.block.width, s)

    def places(self) -> list[Place]:
        block, mesh = self.block, self.mesh
        places = [
            Place(
                name="",
                over=self.explicit_set,
                values=lambda k: self.at(k, self.names),
                weight=lambda k: self.duration * item(block.weight, k),
                points=self.explicit,
                quadrature=mesh.weights[self.explicit],
            )
        ]
        for i, (scheme, group, over) in enumerate(zip(self.schemes, mesh.groups, self.members, strict=True)):
            for node, _ in scheme.eliminated:
                b = float(scheme.b[scheme.collocated.index(node)])
                places.append(
                    Place(
                        name=f"_group{i}_node{node}",
                        over=over,
                        values=partial(self._node, scheme, node),
                        weight=partial(self._weight, b),
                        points=group.nodes[:, node],
                        quadrature=mesh.weights[group.nodes[:, node]],
                        computed=self.phase.states,
                    )
                )
        return places

    def _node(self, scheme: Scheme, node: int, s: Any) -> Values:
        return self._nodes(scheme, s)[node]

    def _weight(self, b: float, s: Any) -> Any:
        return self.h(s) * b

    def end_values(self, last: bool) -> Values:
        """The states at the end, and the inputs there: extrapolated where the end is no collocation point."""
        k = self.last if last else 0
        values = self.at(k, self.names, inputs=k in self.mesh.collocated)
        if k not in self.mesh.collocated:
            scheme, tau = self.mesh.schemes[-1 if last else 0], float(last)
            weights = scheme.control_basis(np.array([tau]))[0]
            points = self.mesh.first[-1 if last else 0] + np.array(scheme.collocated)
            for component, name in self.inputs:
                values[name] = _dot(weights, [component[name, int(j)] for j in points])
        return values

    def dynamics(self) -> None:
        for i, (group, over) in enumerate(zip(self.mesh.groups, self.members, strict=True)):
            if collocation_scheme(group.scheme).point_rows is None:
                self._rows_by_segment(group, over, i)
        for rows in point_rows(self.mesh):
            self._rows_by_point(rows)
        add_delays(self)

    def _rows_by_segment(self, group: SegmentGroup, over: Any, number: int) -> None:
        span = self.mesh.edges[group.segments], self.mesh.edges[group.segments + 1]
        scheme = collocation_scheme(group.scheme)
        for state in self.phase.states:
            for r in scheme.rows:

                def rule(block: Any, s: Any, r: int = r, state: State = state) -> Any:
                    return self._defect(scheme, s, r, state)

                self.add(f"defect{number}_{state.name}_{r}", over, rule, DEFECT, state.name, span, group=number, row=r)

    def _defect(self, scheme: Scheme, s: Any, r: int, state: State) -> Any:
        nodes = self._nodes(scheme, s)
        x = [node[state.name] for node in nodes]
        f = self._rates(scheme, state, nodes, scheme.R[r])
        return _dot(scheme.L[r], x) == self.h(s) * _dot(scheme.R[r], f)  # (3.3), (4.3), (4.4)

    def _nodes(self, scheme: Scheme, s: Any) -> list[Values]:
        """The values at the nodes of segment s; eliminated states are expressions of the others."""
        eliminated, first = dict(scheme.eliminated), item(self.block.first, s)
        nodes = [
            self.at(first + i, () if i in eliminated else self.names, inputs=i in scheme.collocated)
            for i in range(len(scheme.sigma))
        ]
        for node, row in eliminated.items():
            for state in self.phase.states:
                x = [None if i in eliminated else other[state.name] for i, other in enumerate(nodes)]
                f = self._rates(scheme, state, nodes, scheme.R[row])
                nodes[node][state.name] = scheme.eliminate(node, row, x, f, self.h(s))
        return nodes

    def _rates(self, scheme: Scheme, state: State, nodes: list[Values], weights: np.ndarray) -> list:
        """f at the collocation nodes whose weight is not zero, None at the others."""
        pairs = zip(scheme.collocated, weights, strict=True)
        return [state.rate(nodes[i], pyomo) if weight else None for i, weight in pairs]

    def _rows_by_point(self, rows: PointRows) -> None:
        block, mesh, name = self.block, self.mesh, f"rows{rows.terms}"
        over = RangeSet(0, len(rows.row) - 1)
        block.add_component(f"{name}_q", over)
        self.owners[over.name] = rows.segments
        start, own = mesh.first[rows.segments], rows.point[rows.row, 0] if rows.terms else mesh.degrees[rows.segments]
        times = mesh.fractions[start + own]
        columns = {"first": start, "width": mesh.widths[rows.segments], "row": rows.row}
        first, width, row = (self.data(f"{name}_{key}", over, values) for key, values in columns.items())
        # Row r of a table of n columns starts at n r: Pyomo is slower with two indices.
        nodes, tables = rows.L.shape[1], {"L": rows.L, "node": rows.node, "R": rows.R, "point": rows.point}
        L, node, R, point = (self.data(f"{name}_{key}", None, table.ravel()) for key, table in tables.items())

        def defect(block: Any, q: Any, state: State) -> Any:
            k, a, r = item(first, q), nodes * item(row, q), rows.terms * item(row, q)
            x = [item(block.x, state.name, k + item(node, a + i)) for i in range(nodes)]
            left = sum([item(L, a + i) * x_i for i, x_i in enumerate(x)])
            f = [state.rate(self.at(k + item(point, r + j), self.names), pyomo) for j in range(rows.terms)]
            right = sum([item(R, r + j) * f_j for j, f_j in enumerate(f)])
            return left == self.duration * item(width, q) * right if f else left == 0.0

        for state in self.phase.states:
            constraint = Constraint(over, rule=partial(defect, state=state))
            block.add_component(f"defect_of_{rows.terms}_{state.name}", constraint)
            for part in rows.parts:
                span = times[part.q], times[part.q]
                self.tell(constraint, DEFECT, state.name, span, group=part.group, row=part.rows, part=part.q)


def _dot(weights: np.ndarray, values: Sequence) -> Any:
    """sum_i weights[i] * values[i], with no term where the weight is zero."""
    # A list, not a generator: Pyomo takes a sum over a generator for a sum over a Set.
    return sum([value if w == 1 else float(w) * value for w, value in zip(weights, values, strict=True) if w])
