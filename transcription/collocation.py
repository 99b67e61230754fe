"""The builder of every collocation scheme: one defect, for all rows of the table in `schemes`.

On segment s of duration h, with the states x_i at the scheme's state nodes and the dynamics f_j at its collocation nodes,

    defect<r>_<state>[s]:    sum_i L[r, i] x_i  ==  h sum_j R[r, j] f_j

A state that the scheme eliminates is no variable: it is written out wherever it occurs, from the defect that defines it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyomo.core as pyomo
from pyomo.core import Set

from ..problems.problem import State
from .builder import PhaseBuilder, Place


class CollocationBuilder(PhaseBuilder):
    """Fills the block of one phase by a `schemes.Scheme`."""

    def __init__(self, *args):
        super().__init__(*args)
        self.scheme, self.eliminated = self.mesh.scheme, dict(self.mesh.scheme.eliminated)
        self.names = [state.name for state in self.phase.states]

    def stored(self) -> dict[str, np.ndarray]:
        points = np.setdiff1d(self.mesh.nodes, self.mesh.nodes[:, list(self.eliminated)])
        return dict.fromkeys(self.names, points)

    def variables(self, guess) -> None:
        super().variables(guess)
        block, mesh = self.block, self.mesh
        self.explicit = explicit = np.setdiff1d(mesh.collocated, mesh.nodes[:, list(self.eliminated)])
        block.explicit = Set(initialize=explicit.tolist())
        self.data("first", block.segment, mesh.first)
        self.data("width", block.segment, mesh.widths)
        self.data("weight", block.explicit, mesh.weights[explicit])

    def h(self, s):
        return self.duration * self.block.width[s]

    def places(self) -> list[Place]:
        block, mesh = self.block, self.mesh
        places = [
            Place(
                name="",
                over=block.explicit,
                values=lambda k: self.at(k, self.names),
                weight=lambda k: self.duration * block.weight[k],
                points=self.explicit,
                quadrature=mesh.weights[self.explicit],
                computed={},
            )
        ]
        for node in self.eliminated:
            b = float(self.scheme.b[self.scheme.collocated.index(node)])
            places.append(
                Place(
                    name=f"_node{node}",
                    over=block.segment,
                    values=lambda s, node=node: self._nodes(s)[node],
                    weight=lambda s, b=b: self.h(s) * b,
                    points=mesh.nodes[:, node],
                    quadrature=mesh.weights[mesh.nodes[:, node]],
                    computed={state.name: state.bounds for state in self.phase.states},
                )
            )
        return places

    def end_values(self, last: bool) -> dict:
        return self.at(self.last if last else 0, self.names)

    def dynamics(self) -> None:
        segments = self.mesh.edges[:-1], self.mesh.edges[1:]
        for state in self.phase.states:
            for r in self.scheme.rows:

                def rule(block, s, r=r, state=state):
                    return self._defect(s, r, state)

                self.add(f"defect{r}_{state.name}", self.block.segment, rule, "defect", state.name, segments, row=r)

    def _defect(self, s, r: int, state: State):
        nodes = self._nodes(s)
        x = [node[state.name] for node in nodes]
        f = self._rates(state, nodes, self.scheme.R[r])
        return _dot(self.scheme.L[r], x) == self.h(s) * _dot(self.scheme.R[r], f)  # (3.3), (4.3), (4.4)

    def _nodes(self, s) -> list[dict]:
        """The values at the nodes of segment s; eliminated states are expressions of the others."""
        scheme = self.scheme
        nodes = [
            self.at(self.block.first[s] + i, () if i in self.eliminated else self.names)
            for i in range(len(scheme.sigma))
        ]
        for node, row in self.eliminated.items():
            for state in self.phase.states:
                x = [other.get(state.name) for other in nodes]
                f = self._rates(state, nodes, scheme.R[row])
                nodes[node][state.name] = scheme.eliminate(node, row, x, f, self.h(s))
        return nodes

    def _rates(self, state: State, nodes: list[dict], weights: np.ndarray) -> list:
        """f at the collocation nodes whose weight is not zero, None at the others."""
        pairs = zip(self.scheme.collocated, weights, strict=True)
        return [state.rate(nodes[i], pyomo) if weight else None for i, weight in pairs]


def _dot(weights: np.ndarray, values: Sequence):
    """sum_i weights[i] * values[i], with no term where the weight is zero."""
    return sum(value if w == 1 else float(w) * value for w, value in zip(weights, values, strict=True) if w)
