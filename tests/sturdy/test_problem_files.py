"""Problem files that are mutated, or made to be hard: `python -m tests.hostile problems` in small."""

import random

import pytest
from hostile.hard import HARD
from hostile.mutations import as_text, bases, mutated
from hostile.problem_files import Text, runs
from hostile.processes import preload
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from trajopt.problems.errors import SpecError
from trajopt.transcription.loading import build_checked, load_yaml

BASES = bases()


def mistakes_of(text: str) -> list[str]:
    """What `check` says, as sentences."""
    try:
        build_checked([load_yaml(text, file="hard.yaml")])
    except SpecError as error:
        return list(map(str, error.mistakes))
    return []


@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(name=st.sampled_from(sorted(BASES)), rng=st.randoms(use_true_random=False))
def test_a_mutated_file_is_right_or_told_in_sentences(name, rng):
    for told in mistakes_of(as_text(mutated(BASES[name], list(BASES.values()), rng), rng)):
        assert told.startswith("hard.yaml") and "\n" not in told and len(told) < 1000


@pytest.mark.parametrize(
    ("name", "place", "says"),
    [
        ("residual 1", "residuals.1", "the residual is a constant"),
        ("residual pi", "residuals.1", "the residual is a constant"),
        ("product of 98 sums", "states.x.rate", "a product of 98 different factors"),
        ("product of 100 cosines", "states.x.rate", "a product of 100 different factors"),
        ("product of 400 sums in the cost", "objective.minimize.integral", "a product of 400 different factors"),
        ("100 quotients", "states.x.rate", "a product of 100 different factors"),
        ("products of products", "states.x.rate", "a product of 400 different factors"),
        ("sums of products", "expressions.e0", "20 products of up to 20 different factors"),
        ("chain of sines, 300", "expressions.e", "functions are nested 151 deep"),
        ("chain of 1000", "expressions.e300", "more than 300 in a row"),
        ("steps", "mesh.0", "more than the 2000000 points"),
        ("two hundred thousand of Gauss", "mesh.0", "more than the 2000000 points"),
        ("a negative tolerance of the reference", "reference.tolerance", "the tolerance -1 is negative"),
        ("a library", "solver.linear_solver", "makes the solver load a library"),
        ("a loud solver", "solver.print_level", "makes the solver print all"),
        ("a unit that steers", "time.unit", "the character '\\x1b'"),
    ],
)
def test_what_is_too_hard_is_told_by_check(name, place, says):
    (told,) = mistakes_of(HARD[name])
    assert place in told and says in told


@pytest.mark.parametrize(
    "name", ["product of 1900", "product of 30 sums", "chain of sines, 100", "residual t - 1", "Horner's scheme of 100"]
)
def test_what_check_accepts_is_solved(name, tmp_path):
    preload()
    assert [
        (run.command, run.fault, run.err[-300:]) for run in runs(Text(name, HARD[name]), tmp_path) if run.fault
    ] == []


def test_a_sample_of_the_campaign(tmp_path):
    """Through the commands, each in a process of its own."""
    preload()
    for k in range(6):
        rng = random.Random(k)
        text = Text(f"sample {k}", as_text(mutated(BASES["goddard"], list(BASES.values()), rng), rng))
        for run in runs(text, tmp_path):
            assert not run.fault, (run, text.content)
