# SPDX-License-Identifier: Apache-2.0
import pytest

from voltlap_hil.errors import InputError
from voltlap_hil.quantity import duration_ms, number, ticks


def test_times_carry_their_unit():
    assert [duration_ms(t) for t in ("100 ms", "2.5 s", "1min", "0 ms")] == [100.0, 2500.0, 60_000.0, 0.0]


def test_ticks_are_whole():
    assert ticks("120 ms") == 12
    with pytest.raises(InputError, match="multiple of 10 ms"):
        ticks("125 ms")


@pytest.mark.parametrize("text", ["100", "ms", "-1 s", "1 hour", ""])
def test_what_is_no_time_is_refused(text):
    with pytest.raises(InputError, match="expected a time with unit"):
        duration_ms(text)


def test_a_number_carries_its_own_unit_and_no_other():
    assert number("-3.2 A", "A") == -3.2 and number(7, "") == 7.0
    for text, unit in (("3 V", "A"), ("3", "A"), ("3 A", "")):
        with pytest.raises(InputError, match="expected a number"):
            number(text, unit)
