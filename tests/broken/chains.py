"""Mistakes of chains: links, joints, motors, names, numbers, the step of a walker."""

from .case import edits

CHAIN = """\
trajopt: 1
name: pole
parameters: {T: 2, m: 0.3}
time: {initial: 0, final: T}
model:
  kind: chain
  base: cart
  cart: {mass: 1.0, motor: u}
  links:
    - {name: pole, mass: m, length: 0.5, com: 0.5, inertia: 0}
    - {name: bob, mass: 0.1, length: 0.2}
states:
  x: {lower: -2, upper: 2, initial: 0, final: 1}
  q1: {lower: -2*pi, upper: 2*pi, initial: 0, final: pi}
  dq1: {initial: 0, final: 0}
controls:
  u: {lower: -20, upper: 20}
constraints: {path: [{expression: pole_y, upper: 1}]}
objective: {minimize: {integral: u**2}}
"""

WALKER = """\
trajopt: 1
name: walker
parameters: {m: 1, l: 1, c: 0.8}
time: {initial: 0, final: 1}
model:
  kind: chain
  zero: up
  links:
    - {name: stance, mass: m, length: l, com: c, inertia: 0}
    - {name: swing, mass: m, length: l, com: l - c, inertia: 0, zero: down, motor: true}
  step: {foot: swing, swap: [[stance, swing]]}
states: {q1: {initial: 0.2}}
objective: {minimize: {integral: u2**2}}
"""

FLYING = CHAIN.replace("  base: cart\n  cart: {mass: 1.0, motor: u}\n", "  base: floating\n")
RELATIVE = WALKER.replace("  zero: up\n", "  angles: relative\n").replace(
    "  step: {foot: swing, swap: [[stance, swing]]}\n", ""
)

chain, walker, flying, relative = map(edits, (CHAIN, WALKER, FLYING, RELATIVE))

CHAINS = [
    chain(
        "an unknown base", "base: cart", "base: trolley", "model.base", "write 'fixed', 'cart' or 'floating'", line=7
    ),
    chain(
        "a link without a mass", "mass: m, ", "", "model.links.0.mass", "mass is missing; add mass: a number", line=10
    ),
    chain(
        "two links of one name", "name: bob", "name: pole", "model.links.1.name", "two links are called pole", line=11
    ),
    chain("a name that is none", "name: bob", "name: the bob", "model.links.1.name", "use a letter, then"),
    chain("a name with a meaning", "name: bob", "name: com", "model.links.1.name", "choose another, such as com1"),
    chain(
        "a negative length",
        "length: 0.5",
        "length: m - 1",
        "model.links.0.length",
        "the length is -0.7; write a length above",
    ),
    chain("a negative mass", "mass: 0.1", "mass: -0.1", "model.links.1.mass", "the mass is -0.1"),
    chain(
        "a mass that varies", "mass: m,", "mass: m + t,", "model.links.0.mass", "is one number, and this varies in time"
    ),
    chain("nothing that turns", "mass: 0.1", "mass: 0", "model.links.1", "nothing holds it back"),
    chain(
        "a motor on a fixed joint",
        "length: 0.2",
        "length: 0.2, joint: fixed, motor: true",
        "model.links.1.motor",
        "the joint is fixed, which has no motor; remove motor:, or write joint: revolute or joint: prismatic",
    ),
    chain("a turn of a joint that turns", "length: 0.2", "length: 0.2, turn: 1", "model.links.1.turn", "joint: fixed"),
    chain(
        "a torque on a link that slides",
        "length: 0.2",
        "length: 0.2, joint: prismatic, torque: 1",
        "model.links.1.torque",
        "the joint is prismatic, which has no torque; remove torque:, or write joint: revolute",
    ),
    chain(
        "a force along a joint that turns",
        "length: 0.2",
        "length: 0.2, force: 1",
        "model.links.1.force",
        "joint: prism",
    ),
    chain(
        "a direction of a link that slides",
        "length: 0.2",
        "length: 0.2, joint: prismatic, zero: up",
        "model.links.1.zero",
        "write turn:, the angle between both",
    ),
    chain(
        "two distances of one name",
        "length: 0.2",
        "length: 0.2, joint: prismatic, distance: q1",
        "model.links.1.distance",
        "two coordinates are called q1",
    ),
    chain(
        "an unknown joint",
        "length: 0.2",
        "length: 0.2, joint: ball",
        "model.links.1.joint",
        "'revolute', 'prismatic' or 'fixed'",
    ),
    chain(
        "a link on no link",
        "length: 0.2",
        "length: 0.2, parent: poel",
        "model.links.1.parent",
        "there is no link poel; did you mean pole",
    ),
    chain(
        "a link on itself",
        "length: 0.2",
        "length: 0.2, parent: bob",
        "model.links.1.parent",
        "bob hangs on itself; write the links from",
    ),
    chain(
        "a link on a later one",
        "com: 0.5",
        "parent: bob, com: 0.5",
        "model.links.0.parent",
        "pole hangs on bob, which comes after it",
    ),
    chain("a place on the base", "com: 0.5", "at: 0.1, com: 0.5", "model.links.0.at", "hangs at one point; remove at:"),
    chain(
        "a centre without an inertia",
        ", inertia: 0",
        "",
        "model.links.0.com",
        "add inertia:, such as 0 for a point mass",
    ),
    chain("an inertia without a centre", "com: 0.5, ", "", "model.links.0.inertia", "add com:"),
    chain(
        "beside it, names of what slides, of a motor after a fixed link and of a constant are known",
        "com: 0.5, inertia: 0}",
        "inertia: 0}\n    - {name: plate, mass: 1, length: 1, joint: fixed}\n"
        "    - {name: arm, mass: 1, length: 1, joint: prismatic, motor: true, torque: -0.1*u2 - 0*arm_mass*dq2}",
        "model.links.0.inertia",
        "add com:",
    ),
    chain(
        "a misspelt kind", "kind: chain", "kind: chian", "model.kind", 'there is no model "chian"; did you mean chain?'
    ),
    chain("no kind", "  kind: chain\n", "", "model.kind", "kind is missing", line=5),
    chain(
        "a cart without its mass",
        "  cart: {mass: 1.0, motor: u}\n",
        "",
        "model.base",
        "add cart: {mass: 1, motor: u}",
        line=7,
    ),
    chain(
        "a cart on a fixed base",
        "base: cart\n  cart: {mass: 1.0, motor: u}",
        "cart: {mass: 1.0}\n",
        "model.cart",
        "write base: cart",
        line=7,
    ),
    chain(
        "a motor that is a number", "motor: u", "motor: 3", "model.cart.motor", "must be true or the name of a control"
    ),
    chain(
        "an output that is none",
        "pole_y",
        "pole_z",
        "constraints.path.0.expression",
        'unknown name "pole_z"; did you mean pole_',
    ),
    chain(
        "a rate for an angle",
        "q1: {lower",
        "q1: {rate: 3, lower",
        "states.q1.rate",
        "are those of the chain; remove rate:",
    ),
    chain("a state that it has not", "q1: {lower", "q7: {lower", "states.q7", "the chain has no q7 among its states"),
    chain(
        "a name of the chain",
        "m: 0.3}",
        "m: 0.3, pole_mass: 1}",
        "model.links.0.mass",
        "pole_mass is already declared under parameters",
        line=10,
    ),
    chain(
        "one angle twice",
        "length: 0.2",
        "length: 0.2, angle: q1",
        "model.links.1.angle",
        "two coordinates are called q1",
    ),
    chain(
        "an angle called as the cart", "length: 0.2", "length: 0.2, angle: x", "model.links.1.angle", "another state"
    ),
    chain(
        "an angle called as a rate", "length: 0.2", "length: 0.2, angle: dq1", "model.links.1.angle", "another state"
    ),
    flying("a motor in flight", "mass: m,", "mass: m, motor: u,", "model.links.0.motor", "could push against"),
    chain(
        "a force on no link",
        "  links:",
        "  forces: [{link: pol, x: u}]\n  links:",
        "model.forces.0.link",
        "did you mean pole?",
    ),
    chain(
        "a loop on no link",
        "  links:",
        "  loops: [{link: pol}]\n  links:",
        "model.loops.0.link",
        "did you mean pole?",
    ),
    chain(
        "a loop that holds all",
        "  links:",
        "  loops: [{link: pole, x: 1}, {link: bob}]\n  links:",
        "model.loops",
        "nothing is left",
    ),
    chain(
        "a loop to itself",
        "  links:",
        "  loops: [{link: pole, to: pole}]\n  links:",
        "model.loops.0.to",
        "pinned to itself",
    ),
    chain(
        "a loop to two places",
        "  links:",
        "  loops: [{link: pole, to_at: 1}]\n  links:",
        "model.loops.0.to_at",
        "a point of a link, and the loop goes to base",
    ),
    walker("a foot that is none", "foot: swing", "foot: toe", "model.step.foot", "the links are stance, swing"),
    walker(
        "a leg that is none", "[[stance, swing]]", "[[stanze, swing]]", "model.step.swap.0.0", "did you mean stance?"
    ),
    walker(
        "legs that differ",
        "com: l - c",
        "com: c",
        "model.step",
        "after a step stance is not what and where swing was",
        line=11,
    ),
    walker(
        "a step of a cart",
        "zero: up",
        "base: cart\n  cart: {mass: 1}",
        "model.step",
        "the base is cart; write base: fixed",
        line=12,
    ),
    relative("a zero of a relative angle", "zero: down", "zero: up", "model.links.1.zero", "remove zero:"),
    relative(
        "a step in relative angles",
        "states:",
        "  step: {foot: swing, swap: []}\nstates:",
        "model.step",
        "write angles: absolute",
    ),
]
