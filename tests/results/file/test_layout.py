"""What is written is what the layout declares: nothing else, and nothing missing."""

from fnmatch import fnmatch

import h5py
import pytest
from hostile.files import RESULTS, good_results

from trajopt.results.declared.layout import MESH, PHASE, RESULT, SOLVER
from trajopt.results.declared.words import Array, Each, Group
from trajopt.results.file.arrays import NO_VARIABLE


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """One for each kind of method and problem, solved and not, with and without what is optional."""
    return good_results(tmp_path_factory.mktemp("good"), list(RESULTS))


def declared(name, members):
    """What a name is declared as: itself, or what stands for many."""
    return members.get(name) or next((own for key, own in members.items() if fnmatch(name, key)), None)


def seen(node, layout, where=""):
    """(declared place, place) of all that is in a group, as far as it is declared; what is not has no first."""
    members = layout.members if isinstance(layout, Group) else {"*": layout.member}
    attributes = layout.attributes if isinstance(layout, Group) else {}
    for name in node.attrs:
        yield (id(declared(name, attributes)) if declared(name, attributes) else None), f"{where} {name}"
    for name, child in node.items():
        own = declared(name, members)
        yield (id(own) if own else None), f"{where}/{name}"
        if own and not isinstance(own, Array):
            yield from seen(child, own, f"{where}/{name}")


def test_nothing_is_written_that_is_not_declared(results):
    for path in results:
        with h5py.File(path) as file:
            assert [place for known, place in seen(file, RESULT) if known is None] == [], path.stem


def required(layout):
    """Whatever is declared within a layout, under its id, with its path."""
    if isinstance(layout, Each):
        yield layout.member
        yield from required(layout.member)
    elif isinstance(layout, Group):
        yield from layout.attributes.values()
        for member in layout.members.values():
            yield member
            yield from required(member)


def test_all_that_is_declared_is_written_by_one_method_or_another(results):
    written = set()
    for path in results:
        with h5py.File(path) as file:
            written |= {known for known, _ in seen(file, RESULT)}
    assert {id(own) for own in required(RESULT)} <= written


def test_arrays_of_numbers_have_check_sums(results):
    for path in results:
        with h5py.File(path) as file:
            found = []
            file.visititems(lambda name, own, found=found: found.append(own) if isinstance(own, h5py.Dataset) else None)
            valued = [own for own in found if not own.attrs.get("NAME", b"").startswith(NO_VARIABLE.encode())]
            summed = [own.fletcher32 for own in valued if own.dtype.kind in "fiu" and own.ndim and own.size]
            assert len(summed) > 30 and all(summed)


def test_the_layout_is_that_of_the_drawing():
    from trajopt.results.file import write

    for layout in (RESULT, PHASE, PHASE.members["points"], PHASE.members["error"], MESH, SOLVER):
        names = [name for name in (*layout.members, *layout.attributes) if "*" not in name]
        assert [name for name in names if name not in write.__doc__ and not name.startswith("overshoot_")] == []
