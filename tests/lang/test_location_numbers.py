"""A number of thousands of digits that is none is refused at once: a pattern does not go back into its digits."""

import time

import pytest

from holonom.app.fields.units import parse_quantity
from holonom.errors import InputError, ProgramError
from holonom.lang.locations import read_locations


def test_long_numbers_take_no_longer_than_their_length():
    begin = time.process_time()
    with pytest.raises(ProgramError, match="is no number"):
        read_locations(f"a = 1, 2, {'9' * 18_000} 48, 4, 5, 6\n", "taught.loc")
    with pytest.raises(InputError):
        parse_quantity("9" * 20_000 + " 48 mm", "length")
    assert time.process_time() - begin < 2.0  # a square of the length took a minute
