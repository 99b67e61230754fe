"""Mistakes in templates, each told at the line of the template."""

from .case import edits
from .good import GOOD

WITH_LOOPS = (
    GOOD.replace("  power: u*v\n", "  power: u*v\n  for i in 1..3:\n    part{i}: u*{i}\n")
    .replace("controls:\n", "controls:\n  w{i}: {for: i in 1..2, lower: -1, upper: 1}\n")
    .replace("(u - c*v)/m", '"(u - c*v + sum(i in 1..2, w{i}*part{i + 1}) + 0*part1)/m"')
)
edit = edits(WITH_LOOPS)


def loop(name: str, given: str, says: str, place: str = "controls.w{i}.for"):
    return edit(name, "for: i in 1..2", f"for: {given}", place, says)


def summed(name: str, given: str, says: str):
    return edit(name, "sum(i in 1..2, w{i}*part{i + 1})", given, "states.v.rate", says)


def part(name: str, key: str, value: str, says: str):
    return edit(name, "part{i}: u", f"{key}: {value}", f"expressions.for i in 1..3.{key}", says)


def bounds(name: str, given: str, place: str, says: str):
    return edit(name, "lower: -1, upper: 1}", f"{given}}}", f"controls.{place}", says)


LOOPS = [
    loop("a loop of a number", "3", "the number 3 says not what is repeated"),
    loop("a loop without in", "i = 1..2", "says not what is repeated; write a name and a range, i in 1..20"),
    loop("a loop over an unknown end", "i in 1..M", "M is no variable of a loop; "),
    loop("a loop over half a number", "i in 1..d/2", '"d/2" is 0.5, no whole number'),
    loop("a loop that is too long", "i in 1..10**6", "this makes more than 10000 entries"),
    loop("a variable that is a parameter", "m in 1..2", "m is a parameter already; give the variable another name"),
    loop("a variable twice", "[i in 1..2, i in 1..2]", "i is the variable of another loop already"),
    loop(
        "loops in quotes", '"[i in 1..2, k in 1..2]"', "is one text; write for: [i in 1..2, k in 1..2], without quotes"
    ),
    loop("one loop in quotes and brackets", "'[i in 1..2]'", "write for: i in 1..2, without quotes"),
    loop("loops in quotes without brackets", '"i in 1..2, k in 1..2"', "write for: [i in 1..2, k in 1..2], without"),
    loop("neither a range nor words", "i in 1:2", "is neither a range nor a list of words"),
    edit("a key without the variable", "w{i}: {for", "w: {for", "controls.w", '"w" is the same for all'),
    part("an index that nobody knows", "part{i}", "u*{j}", "j is no var"),
    part("an index that is no arithmetic", "part{i}", "u*{i+}", "ends with"),
    part("a name made twice", "part{i - i}", "u", "is made more than once"),
    bounds("a template of a mistake", "lower: -1, uper: 1", "w{i}.uper", 'unknown key "uper"'),
    bounds("a bound of a template", "lower: q, upper: 1", "w{i}.lower", 'unknown name "q"'),
    summed("a sum without its term", "sum(i in 1..2)", "is not complete; write sum(i in 1..20, x{i}**2)"),
    summed("a sum that is open", "sum(i in 1..2, w{i}", "( is never closed; add the missing )"),
    summed("a sum over nothing known", "sum(i in 1..K, w{i})", "K is no variable of a loop"),
    summed("a sum of what is not there", "sum(i in 1..3, w{i})", 'unknown name "w3"'),
]
