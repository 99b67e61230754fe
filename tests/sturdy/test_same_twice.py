"""The same input gives the same result, bit for bit: in one process, whatever it solved before, and in two."""

import h5py
import pytest
from command_line import process, trajopt

CASES = {
    "one phase": ["cartpole", "--refine", "1e-4"],
    "phases": ["block_move_three_phases"],
    "other starts": ["cartpole", "--segments", "6", "--starts", "3"],
    "shooting": ["block_move_min_force", "--method", "runge-kutta-4"],
}


def content(path) -> dict[str, bytes]:
    """Every array and attribute, but for when and how long."""
    found = {}

    def keep(name, node):
        if isinstance(node, h5py.Dataset):
            values = node[()]
            found[name] = str(values).encode() if node.dtype == object else values.tobytes()
        found.update({f"{name} {key}": str(value) for key, value in node.attrs.items() if lasting(key)})

    with h5py.File(path) as file:
        keep("", file)
        file.visititems(keep)
    return found


def lasting(key: str) -> bool:
    lists = ("DIMENSION_LIST", "REFERENCE_LIST")  # where HDF5 has put the arrays
    return not key.startswith("seconds_") and key not in ("created", "command", *lists)


@pytest.mark.parametrize("case", CASES)
def test_the_same_input_gives_the_same_bits(case, tmp_path):
    first, again, other = (tmp_path / f"{name}.h5" for name in ("first", "again", "other"))
    codes = [trajopt("solve", *CASES[case], "-q", "-o", path).exit_code for path in (first, again)]
    codes.append(process("solve", *CASES[case], "-q", "-o", other).returncode)
    assert len(set(codes)) == 1 and codes[0] in (0, 4)
    assert content(first) == content(again) == content(other) and len(content(first)) > 100
