# SPDX-License-Identifier: Apache-2.0
import pytest

from voltlap_hil.errors import InputError
from voltlap_hil.quantity import duration_ms, number, ticks, whole


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


def test_every_hundredth_of_a_second_is_a_whole_number_of_ticks():
    assert [ticks(f"{n / 100:g} s") for n in range(1000)] == list(range(1000))


@pytest.mark.parametrize("read, text", [
    (whole, "1.0"), (whole, "1e3"), (whole, "0x1"), (whole, "9" * 400), (whole, "\u0661"), (whole, "true"), (whole, ""),
    (lambda text: number(text, "A"), "9" * 400 + " A"), (lambda text: number(text, "A", 0.0, 5.0), "5.1 A"),
    (lambda text: number(text, "A"), "nan A"), (duration_ms, "9" * 400 + " s"), (duration_ms, "1441 min"),
    (duration_ms, "inf s"), (lambda text: duration_ms(text, 10.0), "9 ms"), (lambda text: ticks(text, 1), "0 ms")])
def test_a_number_out_of_its_range_is_refused(read, text):
    with pytest.raises(InputError, match="^found .*, expected"):
        read(text)
