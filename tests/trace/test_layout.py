"""The places where compiled code looks for what arrays and tuples hold: tried at load, and not used if one is wrong."""

import subprocess
import sys

import numpy as np
import pytest

from holonom.trace.call import layout

WRONG = ("TYPE", "SIZE", "ITEMS", "DATA", "NDIM", "SHAPE", "STRIDES", "KIND", "FLAGS", "BYTE_ORDER", "TYPE_NUMBER")


def test_numpy_and_python_agree():
    assert layout.agrees()


@pytest.mark.parametrize("shift", [8, -8, 32])
@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_place_is_noticed(name, shift, monkeypatch):
    monkeypatch.setattr(layout, name, getattr(layout, name) + shift)
    assert not layout.agrees()


@pytest.mark.parametrize("name", ["C_CONTIGUOUS", "ALIGNED", "WRITEABLE"])
def test_a_wrong_flag_is_noticed(name, monkeypatch):
    monkeypatch.setattr(layout, name, getattr(layout, name) * 2)
    assert not layout.agrees()


def test_where_numpy_says_otherwise_all_goes_the_general_way():
    """A process in which the last element of an array is not where it is looked for."""
    script = (
        "import sys, numba, numpy as np\n"
        "if sys.argv[1] == 'other':\n"
        "    import ctypes\n"
        "    real, ctypes.string_at = ctypes.string_at, lambda *place: b'other'\n"
        "    import holonom.trace.call.layout\n"
        "    ctypes.string_at = real\n"
        "import holonom as hm\n"
        "arm, q = hm.load_arm('puma560'), np.linspace(0.1, 0.6, 6)\n"
        "print(arm.kernel('inverse_dynamics').single(q, q, q, np.empty(6)))\n"
        "print(*arm.inverse_dynamics(q, q, q))\n"
    )
    found = [
        subprocess.run([sys.executable, "-c", script, which], capture_output=True, text=True, check=True).stdout
        for which in ("this", "other")
    ]
    (used, ours), (not_used, general) = (text.splitlines() for text in found)
    assert (used, not_used) == ("0", "1")
    assert np.allclose(np.array(ours.split(), float), np.array(general.split(), float), rtol=0.0, atol=1e-12)
