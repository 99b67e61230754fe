"""A problem with a singular arc between arcs on bounds, for the tests of arcs and of polish."""

STOCK = """\
trajopt: 1
name: a fish stock, harvested
time: {initial: 0, final: 10}
states: {n: {rate: n*(1 - n) - h, initial: 0.2, final: 0.2}}
controls: {h: {lower: 0, upper: 1}}
objective: {maximize: {integral: h}}
"""
