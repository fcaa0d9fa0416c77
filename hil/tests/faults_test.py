# SPDX-License-Identifier: Apache-2.0
"""What the gateway does to frames, tick by tick; side 0 is the plant's, side 1 that of the ECUs."""
import pytest

from voltlap_hil.errors import InputError
from voltlap_hil.faults import Gateway, Fault
from voltlap_hil.frame import Frame

PEDALS, STATUS, LIMITS, COMMAND, INVERTER = 0xB1, 0xC1, 0xC0, 0xA0, 0xA1
TICKS = 12


@pytest.fixture
def drive(dbc, frame):
    """drive(gateway): ticks of a bus with Pedals, BmsStatus and InverterCommand; what left, as (tick, frame) by id.

    Apps1 and Soc say in which tick a frame was made.
    """
    def lockstep(name, tick):
        row = dbc.message(name)
        return Frame(row.id, row.encode({"Tick": tick}))

    def run(gateway, begin=0, ticks=TICKS):
        out = {}
        for tick in range(begin, begin + ticks):
            inputs = [(frame("Pedals", tick * 10, tick % 16, Apps1=tick * 0.1), 0), (lockstep("Sync", tick), 0),
                      (frame("BmsStatus", tick * 10, tick % 16, Soc=tick), 1), (lockstep("DoneBms", tick), 1),
                      (frame("InverterCommand", tick * 10, tick % 16, PhaseCurrent=tick), 1),
                      (lockstep("DoneMaster", tick), 1)]
            for one, side in inputs:
                for left in gateway.forward(one, side):
                    out.setdefault(left.id, []).append((tick, left))
        return out
    return run


def ticks_of(rows):
    return [tick for tick, _ in rows]


def made_in(dbc, rows, signal="Pedals.Apps1", unit=0.1):
    return [round(dbc.signal(signal).read(f.data) / unit) for _, f in rows]


def fault(kind, *ids, **what):
    return Fault(kind, frozenset(ids or [PEDALS]), **what)


def test_without_a_fault_everything_passes_unchanged(dbc, drive):
    out = drive(Gateway(dbc))
    assert {i: ticks_of(rows) for i, rows in out.items()} == {
        i: list(range(TICKS)) for i in (PEDALS, STATUS, INVERTER, 0x7E0, 0x7E9, 0x7EA)}
    assert made_in(dbc, out[PEDALS]) == list(range(TICKS))


def test_drop_acts_from_and_until_a_tick_on_its_ids_only(dbc, drive):
    gateway = Gateway(dbc)
    gateway.install(fault("drop", from_tick=3, until_tick=6))
    out = drive(gateway)
    assert ticks_of(out[PEDALS]) == [0, 1, 2, 6, 7, 8, 9, 10, 11]
    assert ticks_of(out[STATUS]) == list(range(TICKS))


def test_a_frame_of_an_ecu_belongs_to_the_tick_of_the_last_sync(dbc, drive):
    gateway = Gateway(dbc)
    gateway.install(fault("drop", STATUS, INVERTER, from_tick=3, until_tick=6))
    out = drive(gateway)
    assert ticks_of(out[STATUS]) == ticks_of(out[INVERTER]) == [0, 1, 2, 6, 7, 8, 9, 10, 11]


def test_drop_takes_every_nth_frame(dbc, drive):
    gateway = Gateway(dbc)
    gateway.install(fault("drop", from_tick=2, every=3))
    assert ticks_of(drive(gateway)[PEDALS]) == [0, 1, 3, 4, 6, 7, 9, 10]


@pytest.mark.parametrize("ids, signal, unit", [(PEDALS, "Pedals.Apps1", 0.1), (STATUS, "BmsStatus.Soc", 1),
                                               (INVERTER, "InverterCommand.PhaseCurrent", 1)])
def test_delay_counts_simulated_time_and_keeps_the_order(dbc, drive, ids, signal, unit):
    gateway = Gateway(dbc)
    gateway.install(fault("delay", ids, from_tick=2, delay_ticks=3))
    rows = drive(gateway)[ids]
    assert ticks_of(rows) == [0, 1, 5, 6, 7, 8, 9, 10, 11]
    assert made_in(dbc, rows, signal, unit) == [0, 1, 2, 3, 4, 5, 6, 7, 8]


def test_a_delayed_frame_comes_before_the_mark_of_its_tick(dbc, frame):
    gateway = Gateway(dbc)
    gateway.install(fault("delay", delay_ticks=1))
    sync = [Frame(0x7E0, dbc.message("Sync").encode({"Tick": t})) for t in range(2)]
    pedals = frame("Pedals")
    assert gateway.forward(pedals, 0) == []
    assert gateway.forward(sync[0], 0) == [sync[0]]
    assert gateway.forward(sync[1], 0) == [pedals, sync[1]]


def test_what_is_held_back_still_comes_after_the_fault_has_ended(dbc, drive):
    gateway = Gateway(dbc)
    gateway.install(fault("delay", from_tick=2, until_tick=4, delay_ticks=4))
    rows = drive(gateway)[PEDALS]
    assert ticks_of(rows) == [0, 1, 4, 5, 6, 6, 7, 7, 8, 9, 10, 11]
    assert gateway.idle is False


def test_duplicates_follow_their_frame(dbc, drive):
    gateway = Gateway(dbc)
    gateway.install(fault("duplicate", from_tick=10, copies=2))
    assert ticks_of(drive(gateway)[PEDALS])[10:] == [10, 10, 10, 11, 11, 11]


@pytest.mark.parametrize("bit", [None, 0, 13, 56])
def test_a_corrupt_frame_differs_in_one_bit_and_fails_its_crc(dbc, drive, bit):
    gateway = Gateway(dbc)
    gateway.install(fault("corrupt", from_tick=1, bit=bit))
    good, bad = drive(Gateway(dbc))[PEDALS], drive(gateway)[PEDALS]
    message = dbc.message("Pedals")
    assert message.sealed_ok(bad[0][1].data) and not any(message.sealed_ok(f.data) for _, f in bad[1:])
    changed = int.from_bytes(good[1][1].data, "little") ^ int.from_bytes(bad[1][1].data, "little")
    assert changed == 1 << (56 if bit is None else bit)


def test_replay_repeats_what_was_sent_before_the_fault(dbc, drive):
    gateway = Gateway(dbc)
    gateway.install(fault("replay", from_tick=4, until_tick=10, copies=3))
    rows = drive(gateway)[PEDALS]
    assert made_in(dbc, rows) == [0, 1, 2, 3, 1, 2, 3, 1, 2, 3, 10, 11]
    assert all(dbc.message("Pedals").sealed_ok(f.data) for _, f in rows)


def test_a_stuck_counter_has_new_content_and_a_good_crc(dbc, drive):
    gateway = Gateway(dbc)
    gateway.install(fault("stuck_counter", from_tick=4))
    rows, message = drive(gateway)[PEDALS], dbc.message("Pedals")
    assert made_in(dbc, rows) == list(range(TICKS))
    assert [message.counter_of(f.data) for _, f in rows] == [0, 1, 2, 3] + [3] * 8
    assert all(message.sealed_ok(f.data) for _, f in rows)


def test_a_second_sender_follows_each_frame_with_its_own_content_and_counter(dbc, drive):
    gateway = Gateway(dbc)
    gateway.install(fault("second_sender", from_tick=11, counter_ahead=7, signals={"Apps1": 4.5}))
    rows, message = drive(gateway)[PEDALS], dbc.message("Pedals")
    assert ticks_of(rows) == [*range(12), 11]
    assert [message.counter_of(f.data) for _, f in rows[-2:]] == [11, 18]
    assert message.read(rows[-1][1].data)["Apps1"] == 4.5 and message.sealed_ok(rows[-1][1].data)


def test_a_babbling_node_fills_every_tick_and_the_same_seed_says_the_same(dbc, drive):
    def babble():
        gateway = Gateway(dbc)
        gateway.install(fault("babble", 0x001, from_tick=5, until_tick=7, copies=20))
        return drive(gateway)[0x001]
    assert ticks_of(babble()) == [5] * 20 + [6] * 20
    assert babble() == babble()


def test_two_faults_act_one_after_the_other(dbc, drive):
    gateway = Gateway(dbc)
    gateway.install(fault("duplicate", from_tick=2))
    gateway.install(fault("delay", from_tick=2, delay_ticks=2))
    assert ticks_of(drive(gateway)[PEDALS])[2:] == [t for t in range(4, TICKS) for _ in range(2)]


def test_clear_ends_every_fault(dbc, drive):
    gateway = Gateway(dbc)
    gateway.install(fault("drop"))
    gateway.clear()
    assert len(drive(gateway)[PEDALS]) == TICKS and gateway.idle


def test_lockstep_frames_pass_whatever_a_rule_says(dbc, drive):
    gateway = Gateway(dbc)
    gateway.install(fault("drop", 0x7E0, 0x7E9, 0x7EA))
    assert len(drive(gateway)[0x7E0]) == TICKS


def test_without_sync_the_clock_releases_what_is_due(dbc, frame):
    gateway, pedals = Gateway(dbc), frame("Pedals")
    gateway.advance(99)
    gateway.install(fault("delay", from_tick=100, delay_ticks=3))
    assert gateway.forward(pedals, 0) == []
    assert gateway.advance(102) == [] and gateway.advance(103) == [(0, pedals)]


@pytest.mark.parametrize("kind, what, complaint", [
    ("dorp", {}, "no fault 'dorp'. Did you mean drop"), ("drop", {"every": 0}, "every 0, expected at least 1"),
    ("replay", {"copies": 0}, "copies 0, expected at least 1"), ("delay", {"delay_ticks": -1}, "delay -1"),
    ("drop", {"from_tick": 3, "until_tick": 3}, "ends before it begins"), ("corrupt", {"bit": -1}, "bit -1")])
def test_a_fault_that_cannot_be_is_refused(kind, what, complaint):
    with pytest.raises(InputError, match=complaint):
        fault(kind, **what)


def test_a_bit_beyond_the_message_is_refused_and_a_short_frame_of_another_passes(dbc):
    with pytest.raises(InputError, match="found bit 64, expected one below 64: Pedals has 8 bytes"):
        fault("corrupt", bit=64).check_fits(dbc)
    gateway = Gateway(dbc)
    gateway.install(fault("corrupt", bit=63))
    assert gateway.forward(Frame(PEDALS, b"\x01"), 0) == [Frame(PEDALS, b"\x01")]
