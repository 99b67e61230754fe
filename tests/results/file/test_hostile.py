"""A small sample of the campaign `python -m tests.hostile`, and the kinds of damage that it is about, by name."""

import json
import sys
from itertools import chain
from subprocess import PIPE, Popen

import h5py
import numpy as np
import pytest
from hostile.campaign import COMMANDS, campaign
from hostile.content import with_problem
from hostile.files import OLD, Bad, always, bad_files, good_results
from hostile.objects import ANY, ARRAYS, SECRET
from hostile.processes import preload

import trajopt
from trajopt.problems.errors import FileError
from trajopt.results.file.door import open_result
from trajopt.results.file.guess import lacking
from trajopt.results.file.read import read
from trajopt.results.file.reload import reload, stored_spec
from trajopt.results.file.summary import summarize

QUICK = ["show", "compare with it", "guess", "explain", "read"]


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    preload()
    return good_results(tmp_path_factory.mktemp("good"), ["collocation", "failed", OLD])


def ended_badly(bad, good, folder, commands=QUICK):
    return [
        (own.name, run.command, run.fault, run.err[-300:])
        for own, runs in campaign(bad, good[0], folder, commands)
        for run in runs
        if run.fault
    ]


def test_good_results_are_read_by_every_command(good, tmp_path):
    solved, failed, old = [Bad(path, path.stem, lambda path: None) for path in good]
    parts = [([solved], list(COMMANDS)), ([failed], ["show", "read", "report"]), ([old], ["show", "read", "verify"])]
    for own, runs in chain.from_iterable(campaign(files, good[0], tmp_path, commands) for files, commands in parts):
        for run in runs:
            good_codes = (0, 2) if run.command == "animate" else (0,)  # not every problem has a drawing
            assert not run.fault and (run.code in good_codes or own.name == "failed"), (own.name, run)


def test_what_is_no_result_and_what_holds_no_problem(good, tmp_path):
    assert ended_badly(always(good[0]), good, tmp_path, ["show", "explain"]) == []


@pytest.mark.parametrize("text", ["{}", '{"source": null}', '{"source": 3, "name": []}'])
def test_a_page_of_a_result_that_holds_little_of_its_problem(good, tmp_path, text):
    assert ended_badly([Bad(good[0], text, with_problem(lambda _: text))], good, tmp_path, ["report"]) == []


def test_a_sample_of_the_campaign(good, tmp_path):
    assert ended_badly(bad_files(good, 6, seed=7), good, tmp_path) == []


@pytest.fixture
def result(good, tmp_path):
    path = tmp_path / "a.h5"
    path.write_bytes(good[0].read_bytes())
    return path


def damaged(result, place, damage):
    parent, _, name = place.rpartition("/")
    with h5py.File(result, "r+") as file:
        damage(file[parent or "/"], name)
    return result


@pytest.mark.parametrize("read_it", [summarize, read, reload, stored_spec], ids=lambda own: own.__name__)
@pytest.mark.parametrize(
    ("place", "kind", "words"),
    [
        ("mesh/0/edges", "deleted", "/mesh/0/edges: it is missing"),
        ("solver/z_upper", "deleted", "/solver/z_upper: it is missing"),
        ("mesh", "deleted", "/mesh: it is missing"),
        ("phase/main/points/time", "group", "/phase/main/points/time: it is no array"),
        ("phase/main/dense/state/x", "shorter", "/phase/main/dense/state/x: it has"),
        ("phase/main/error/eta", "single", "/phase/main/error/eta: it has 0 axes, not 2"),
        ("phase/main/knots", "nan", "/phase/main/knots: not all of its values are finite"),
        ("sensitivity/value", "all nan", "/sensitivity/value: not all of its values are finite"),
        ("mesh/0/edges", "reversed", "/mesh/0/edges: its values do not rise"),
        ("solver/z", "text", "/solver/z: it holds a text, where a number is meant"),
        ("solver/z", "huge", "/solver/z: "),
        ("phase/main/dense/state/x", "bomb", "/phase/main/dense/state/x: "),
        ("phase/main/dense/state/x", "virtual", "its values are in another file"),
        ("phase/main/points/state/x", "outside", "it is a link to another place"),
        ("phase/main/points", "external", "it is a link to another place"),
        ("phase", "cycle", "it is missing"),
        ("phase/main/knots", "soft", "it is a link to another place"),
        ("spec/text", "no utf-8", "/spec/text: its byte 1 is no UTF-8"),
        ("phase/main/error/state", "no utf-8", "/phase/main/error/state: its byte 1 is no UTF-8"),
        ("sensitivity/note", "no utf-8", "/sensitivity/note: its byte 1 is no UTF-8"),
        ("phase/main/knots", "filter", "a filter that is not read"),
    ],
)
def test_damage_is_told_with_its_place(result, read_it, place, kind, words):
    damaged(result, place, {**ARRAYS, **ANY}[kind])
    with pytest.raises(FileError) as caught:
        read_it(result)
    told = str(caught.value)
    assert told.startswith(f"{result}: /") and words in told and "\n" not in told


def test_no_byte_of_another_file_is_shown(result):
    """The first bytes of a system file, as a dataset of bytes; and as one of the size that is meant."""
    with open(SECRET, "rb") as stream:
        assert stream.read()

    def outside(group, name):
        shape = group[name].shape
        del group[name]
        group.create_dataset(name, shape, "i1", external=[(SECRET, 0, h5py.h5f.UNLIMITED)])

    damaged(result, "solver/iterations/mode", outside)
    with pytest.raises(FileError, match="its values are in another file"):
        summarize(result)


@pytest.mark.parametrize("steering", ["\\u001b[31m", "\\u0007", "\\u009b2J"])
def test_nothing_that_python_raises_steers_a_terminal(result, steering):
    with_problem(lambda text: text.replace('"rate":"v"', f'"rate":"{steering}"'))(result)
    with pytest.raises(FileError) as caught:
        trajopt.read(result)
    assert str(caught.value).isprintable()


def test_phases_of_another_name(tmp_path):
    """`animate` and `report` look for the drawing of a phase that the problem does not have."""

    def renamed(path):
        with h5py.File(path, "r+") as file:
            file.move("phase/main", "phase/other")

    drawn = good_results(tmp_path, ["refined"])
    bad = [Bad(drawn[0], "a phase renamed", renamed)]
    assert ended_badly(bad, drawn, tmp_path, ["animate", "report"]) == []


@pytest.mark.parametrize("place", ["phase/main/dense/state/x", "solver/z", "phase/main/error/eta"])
def test_a_flipped_byte_in_the_values_is_found(result, place):
    with h5py.File(result) as file:
        where = file[place].id.get_chunk_info(0).byte_offset
    content = bytearray(result.read_bytes())
    content[where + 5] ^= 1
    result.write_bytes(content)
    with pytest.raises(FileError, match="its values cannot be read; it is damaged"), open_result(result) as file:
        file[place][()]


def test_a_file_that_another_program_writes(result):
    writing = "import h5py, sys; file = h5py.File(sys.argv[1], 'r+'); print('open', flush=True); sys.stdin.read()"
    with Popen([sys.executable, "-c", writing, str(result)], stdin=PIPE, stdout=PIPE) as other:
        assert other.stdout.readline() == b"open\n"
        with pytest.raises(FileError, match="another program has it open for writing"):
            summarize(result)
        other.stdin.close()


@pytest.mark.parametrize("version", [0, -3])
def test_a_version_that_there_was_never(result, version):
    with h5py.File(result, "r+") as file:
        file.attrs["format_version"] = version
    with pytest.raises(FileError, match=f"there is no format version {version}"):
        summarize(result)


def test_a_point_of_another_mesh(result):
    """Every array is as declared, but the unknowns are not those of the mesh."""
    with h5py.File(result, "r+") as file:
        solver = file["solver"]
        for name in ("unknown", "z", "z_lower", "z_upper"):
            values = solver[name][:-1]
            del solver[name]
            solver[name] = values
    summarize(result)
    with pytest.raises(FileError, match="the solver's point is not one of its problem on its mesh"):
        reload(result)


def test_compressed_results_are_read(result, tmp_path):
    """As h5repack makes them."""
    with h5py.File(result, "r+") as file:
        state = file["phase/main/dense/state"]
        values = state["x"][()]
        del state["x"]
        state.create_dataset("x", data=values, compression="gzip", shuffle=True)
    np.testing.assert_array_equal(read(result).phases[0].curves["state"]["x"].dense, values)


def test_what_is_not_declared_is_left_alone(result):
    with h5py.File(result, "r+") as file:
        file["notes of mine"] = h5py.ExternalLink(SECRET, "/")
        file["phase/main/mine"] = "hello"
        file["mesh/0"].attrs["mine"] = np.arange(3)
    assert "mine" not in summarize(result)["meshes"][0]


def test_a_stored_problem_loads_no_library(result):
    with h5py.File(result, "r+") as file:
        text = file["spec/full"].asstr()[()]
        del file["spec/full"]
        file["spec/full"] = text.replace('"solver":{', '"solver":{"hsllib":"/lib/evil.so","resto.output_file":"/x",')
    with h5py.File(result) as file:
        assert "evil" in file["spec/full"].asstr()[()]
    options = stored_spec(result).solver.model_dump()
    assert not {"hsllib", "resto.output_file"} & options.keys()


@pytest.mark.parametrize("place", ["mesh", "states", "time"])
def test_messages_about_a_stored_problem_steer_no_terminal(result, place):
    """Also those of exceptions, which nothing else cleans."""

    def change(text):
        return json.dumps({**json.loads(text), place: ["\x1b[31mred"]})

    with_problem(change)(result)
    with pytest.raises(FileError) as caught:
        stored_spec(result)
    assert str(caught.value).isprintable()


def test_a_result_without_the_guess_is_told_from_it(result):
    from trajopt.problems.build import build
    from trajopt.problems.load import load_text

    text = "trajopt: 1\nstates: {y: {rate: 1, initial: 0}}\ntime: {initial: 0, final: 1}\n"
    problem = build(load_text(f"{text}objective: {{minimize: {{terminal: 'y[final]'}}}}\n", "y.yaml"))
    (warning,) = lacking(result, problem)
    assert "it does not have y" in str(warning)


def test_texts_that_hdf5_would_read_for_ever(result):
    """Zeros in a heap of texts: the size of an object, by which HDF5 goes on to the next one, is 0."""
    content = bytearray(result.read_bytes())
    heap = content.index(b"GCOL\x01\0\0\0")
    content[heap + 16 : heap + 600] = bytes(584)
    result.write_bytes(content)
    with pytest.raises(FileError, match="its texts cannot be read"):
        summarize(result)


def test_what_only_some_results_have(tmp_path):
    """Times of arcs, and what a pair was allowed, are compared and printed: they are numbers."""
    sources = good_results(tmp_path, ["phases", "contact"])
    with h5py.File(sources[0]) as phases, h5py.File(sources[1]) as contact:
        places = [first(own, kind) for own, kind in ((phases, "arcs/end"), (contact, "allowed"))]
    for source, place in zip(sources, places, strict=True):
        with pytest.raises(FileError, match=f"/{place}: not all of its values are finite"):
            summarize(damaged(source, place, ARRAYS["minus inf"]))


def first(file, ending):
    """The path of the first array of that name."""
    return file.visit(lambda path: path if path.endswith(ending) else None)
