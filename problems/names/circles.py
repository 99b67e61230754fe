"""Definitions that refer to each other: their order, and the circles among them."""

from __future__ import annotations

from collections.abc import Mapping
from graphlib import CycleError, TopologicalSorter


def untangle(graph: Mapping[str, set[str]], most: int = 20) -> tuple[list[str], list[list[str]]]:
    """The names of a graph, each after those it refers to, and the circles found in it, each as [a, b, a].

    Names in a circle are left out of the order. After `most` circles the search ends, and the order is empty.
    """
    graph = dict(graph)
    circles: list[list[str]] = []
    while len(circles) < most:
        try:
            return [name for name in TopologicalSorter(graph).static_order() if name in graph], circles
        except CycleError as error:
            circles.append(error.args[1][::-1])
            graph = {name: needs.difference(circles[-1]) for name, needs in graph.items() if name not in circles[-1]}
    return [], circles
