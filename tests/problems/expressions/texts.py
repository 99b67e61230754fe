"""Expressions at random, and values of their names."""

import random

NAMES = {"x": 0.7, "y": -0.3, "q1": 1.9, "u_max": 2.5}


def random_text(rng: random.Random, depth: int) -> str:
    """An expression that is finite at NAMES: arguments and divisors are kept where every function is defined."""
    if depth == 0:
        return rng.choice([*NAMES, "pi", "2", "0.25", "1e-1", ".5"])
    a, b = (random_text(rng, depth - 1) for _ in range(2))
    return rng.choice(
        [
            f"{a} + {b}",
            f"{a} - ({b})",
            f"({a})*({b})",
            f"({a})/(3 + sin({b}))",
            f"-({a})",
            f"sin({a})**{rng.choice([1, 2, 3])}",
            f"-cos({a})**2",
            f"(1.5 + cos({a}))**-{rng.choice(['1', '0.5', '2'])}",
            f"(2 + sin({a}))**sin({b})",
            f"{rng.choice(['sin', 'cos', 'atan', 'tanh'])}({a})",
            f"{rng.choice(['tan', 'asin', 'acos', 'sinh', 'cosh', 'exp'])}(sin({a})/2)",
            f"{rng.choice(['log', 'sqrt'])}(2 + sin({a}))",
        ]
    )
