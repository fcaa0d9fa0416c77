# SPDX-License-Identifier: Apache-2.0
"""Every check on a sequence that holds it, one that misses its bound and one in which nothing happens."""
import pytest

from voltlap_hil import checks
from voltlap_hil.condition import Condition

EVENT_MS = 100


def row(message, values_at, until_ms=400):
    """Frames every 10 ms; `values_at` gives the values from a time on."""
    rows, now = [], {}
    for time in range(0, until_ms, 10):
        now = {**now, **values_at.get(time, {})}
        rows.append((message, time, dict(now)))
    return rows


def falls(message, signal, at_ms, before=300.0, after=0.0):
    return row(message, {0: {signal: before}, at_ms: {signal: after}})


def measure(check, t):
    return check.measure(t, EVENT_MS)


def test_torque_zero_is_timed_from_the_event(dbc, trace):
    t = trace(*falls("InverterStatus", "PhaseCurrent", 160))
    held, late = checks.torque_zero_within(dbc, 60), checks.torque_zero_within(dbc, 50)
    assert measure(held, t).held and measure(held, t).measured == 60
    assert not measure(late, t).held and measure(late, t).measured == 60


def test_torque_that_comes_back_is_not_zero(dbc, trace):
    t = trace(*row("InverterStatus", {0: {"PhaseCurrent": 300.0}, 150: {"PhaseCurrent": 0.0},
                                      300: {"PhaseCurrent": 0.1}}))
    result = measure(checks.torque_zero_within(dbc, 100), t)
    assert not result.held and result.measured is None


def test_torque_that_was_zero_all_along_took_no_time(dbc, trace):
    assert measure(checks.torque_zero_within(dbc, 100), trace(*row("InverterStatus", {}))).measured == 0


def test_a_signal_that_was_never_heard_holds_nothing(dbc, trace):
    result = measure(checks.torque_zero_within(dbc, 100), trace(*row("VehicleIo", {})))
    assert not result.held and str(result) == "not held: torque zero: never, bound 100 ms"


def test_contactors_are_open_when_the_last_one_is(dbc, trace):
    t = trace(*row("VehicleIo", {0: {"AirPlusAux": 1, "AirMinusAux": 1}, 120: {"AirPlusAux": 0},
                                 150: {"AirMinusAux": 0}}))
    assert measure(checks.contactors_open_within(dbc, 50), t).measured == 50
    assert not measure(checks.contactors_open_within(dbc, 40), t).held


def test_a_contactor_that_does_not_open_fails_the_check_but_not_that_of_its_command(dbc, trace):
    t = trace(*row("VehicleIo", {0: {"AirPlusAux": 1}}), *falls("ContactorCommand", "AirPlusClose", 130, 1, 0))
    assert not measure(checks.contactors_open_within(dbc, 300), t).held
    assert measure(checks.contactors_commanded_open_within(dbc, 30), t).held


def test_a_state_is_reached_at_its_first_moment(dbc, trace):
    t = trace(*row("BmsStatus", {0: {"State": "TsActive"}, 180: {"State": "Fault"}, 200: {"State": "Open"}}))
    assert measure(checks.reached_state(dbc, "BmsStatus.State", "Fault", 80), t) == checks.Result(
        "BmsStatus.State = Fault", True, 80, "80 ms", "ms")
    assert not measure(checks.reached_state(dbc, "BmsStatus.State", "Fault", 70), t).held
    assert measure(checks.reached_state(dbc, "BmsStatus.State", "Idle", 70), t).measured is None


def test_a_state_may_be_reached_too_early(dbc, trace):
    t = trace(*row("BmsStatus", {0: {"State": "TsActive"}, 130: {"State": "Fault"}}))
    fault = Condition.parse("BmsStatus.State = Fault", dbc)
    assert measure(checks.reached(fault, 60, 30), t).held
    assert not measure(checks.reached(fault, 60, 40), t).held


def test_a_reaction_can_be_timed_from_a_moment_on_the_bus(dbc, trace):
    t = trace(*row("BmsStatus", {0: {"State": "TsActive"}, 200: {"State": "Fault"}}),
              *falls("InverterStatus", "PhaseCurrent", 250))
    t.frames.sort(key=lambda f: f.time_ms)
    check = checks.torque_zero_within(dbc, 60).starting_at(Condition.parse("BmsStatus.State = Fault", dbc))
    assert measure(check, t).measured == 50
    never = checks.torque_zero_within(dbc, 60).starting_at(Condition.parse("BmsStatus.State = Idle", dbc))
    assert not measure(never, t).held and "never came" in measure(never, t).detail


def test_settled_is_timed_to_the_last_change(dbc, trace):
    t = trace(*row("BmsStatus", {0: {"State": "Idle"}, 120: {"State": "Fault"}, 140: {"State": "Idle"},
                                 170: {"State": "Fault"}}))
    check = checks.settled("fault", Condition.parse("BmsStatus.State = Fault", dbc), 70)
    assert measure(check, t).measured == 70 and measure(check, t).held


def test_stays_asks_for_the_whole_window(dbc, trace):
    t = trace(*row("BmsStatus", {0: {"State": "Fault"}, 300: {"State": "Idle"}}))
    fault = Condition.parse("BmsStatus.State = Fault", dbc)
    assert measure(checks.stays(fault, 190), t).held
    broken = measure(checks.stays(fault, 200), t)
    assert not broken.held and broken.measured == 190 and "ended at 200 ms" in broken.detail
    assert not measure(checks.stays(fault, 500), t).held  # the trace ends too early to say
    idle = Condition.parse("BmsStatus.State = Idle", dbc)
    assert measure(checks.stays(idle, 50, 200), t).held


def limits(current, limit, extra=()):
    return [r for c, one in zip(row("PackSensor", current), row("BmsLimits", limit)) for r in (c, one)] + list(extra)


def test_a_limit_is_obeyed_when_no_excess_lasts_longer(dbc, trace):
    t = trace(*limits({0: {"PackCurrent": 200.0}, 150: {"PackCurrent": 40.0}, 200: {"PackCurrent": 60.0},
                       220: {"PackCurrent": 40.0}},
                      {0: {"DischargeLimit": 250.0}, 110: {"DischargeLimit": 40.0}}))
    assert measure(checks.limit_obeyed_within(dbc, 40), t).measured == 40
    assert measure(checks.limit_obeyed_within(dbc, 40), t).held
    assert not measure(checks.limit_obeyed_within(dbc, 30), t).held


def test_an_excess_that_does_not_end_lasts_until_the_trace_ends(dbc, trace):
    t = trace(*limits({0: {"PackCurrent": 40.0}, 200: {"PackCurrent": 200.0}}, {0: {"DischargeLimit": 40.0}}))
    assert measure(checks.limit_obeyed_within(dbc, 100), t).measured == 190


def test_a_limit_that_was_never_heard_is_not_obeyed(dbc, trace):
    assert not measure(checks.limit_obeyed_within(dbc, 100), trace(*row("PackSensor", {}))).held


@pytest.mark.parametrize("current, held", [(45.0, True), (45.1, False), (-15.0, True), (-15.1, False)])
def test_a_limit_has_a_margin_in_both_directions(dbc, trace, current, held):
    t = trace(*limits({0: {"PackCurrent": current}}, {0: {"DischargeLimit": 40.0, "ChargeLimit": 10.0}}))
    assert measure(checks.limit_obeyed_within(dbc, 100, margin_a=5.0), t).held is held


@pytest.mark.parametrize("phase, rpm, held", [(90.2, 6000, True), (90.3, 6000, False), (550.0, 0, True),
                                              (-550.0, 6000, True)])
def test_torque_above_the_limit_is_judged_by_the_balance_of_power(dbc, trace, phase, rpm, held):
    # 105 A, margin included, at 90 V and 90 % feed 8.51 kW; 0.15 Nm/A at 6000 rpm asks for that at 90.2 A.
    t = trace(*(r for time in range(0, 400, 10) for r in [
        ("InverterCommand", time, {"PhaseCurrent": phase}), ("InverterStatus", time, {"MotorSpeed": rpm}),
        ("PackSensor", time, {"PackVoltage": 90.0}), ("BmsLimits", time, {"DischargeLimit": 100.0})]))
    assert measure(checks.no_torque_above_limit_within(dbc, 100, margin_a=5.0), t).held is held


def test_frames_are_counted_after_the_event(trace):
    t = trace(*row("Pedals", {}))
    assert measure(checks.counted("Pedals", 10, 100), t).held
    assert not measure(checks.counted("Pedals", 11, 100), t).held


def test_a_check_says_what_it_looks_at_and_how_long(dbc):
    check = checks.torque_zero_within(dbc, 50).starting_at(Condition.parse("BmsStatus.State = Fault", dbc))
    assert set(check.needs) == {"InverterStatus.PhaseCurrent", "BmsStatus.State"}
    assert check.lasts_ms == 50 + checks.HOLD_MS
