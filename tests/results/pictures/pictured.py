"""Results whose pictures are looked at, and what stands in these."""

from command_line import solved_once

SOLVES = {
    "cartpole": ("cartpole", "--segments", "5"),
    "unsolved": ("cartpole", "--segments", "5", "--set", "solver.max_iter=2"),
    "pendulum": ("pendulum", "--segments", "20"),  # no costates
    "biped": ("biped", "--set", "mesh.-1.segments=5"),  # two meshes, algebraic variables
    "bounded": ("bryson_denham", "--segments", "6"),  # a path constraint on one state
}


def solved_in(folder):
    """name -> a result file in the folder, each solved once."""
    return lambda name: solved_once(folder / f"{name}.h5", *SOLVES[name], code=int(name == "unsolved"))


def titles(figure):
    return [ax.get_title(loc="left").replace("\n", " ") for ax in figure.axes]
