"""A problem whose first phase has two successors at the same times; the second lacks a state and a control."""

BRANCHES = """
trajopt: 1
time: {initial: 0}
states: {x: {rate: v, initial: 0}, v: {rate: u, initial: 0}}
controls: {u: {}}
phases:
  out: {time: {final: 2}}
  boat: {time: {final: 5}, states: {x: {final: 10}, v: {final: 0}}}
  buoy: {time: {final: 6}, without: [u, v], states: {x: {rate: -1}}, objective: {minimize: {integral: 0}}}
links: [{from: out, to: boat}, {from: out, to: buoy, except: [v]}]
objective: {minimize: {integral: u**2}}
mesh: [{method: radau, segments: 4}]
"""
