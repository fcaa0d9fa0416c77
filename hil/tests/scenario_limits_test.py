# SPDX-License-Identifier: Apache-2.0
"""Every number, name and list of a scenario has a range, and what is outside of it is told before anything runs."""
import random

import pytest

from synthetic_rig import act_out
from voltlap_hil.errors import InputError
from voltlap_hil.nodes import program
from voltlap_hil.scenario_file import load

STEP = "scenario: x\nwhen:\n  - {}\nthen:\n  - torque_zero_within: 1 s\n"
CHECK = "scenario: x\nwhen:\n  - run: 10 ms\nthen:\n  - {}\n"
TOP = "scenario: x\nwhen:\n  - run: 10 ms\nthen:\n  - torque_zero_within: 1 s\n{}\n"


def built():
    try:
        return program().exists()
    except InputError:
        return False


needs_program = pytest.mark.skipif(not built(), reason="the program, which knows the cars, is not built")


@pytest.fixture
def read(tmp_path, dbc):
    def reading(text):
        path = tmp_path / "s.yaml"
        path.write_text(text)
        return load(path, dbc)
    return reading


BAD_STEPS = [
    ("run: 0 ms", "run: found '0 ms', expected a time from 10 ms to 24 h"),
    ("run: -10 ms", "expected a time with unit"),
    ("run: 1e300 s", "expected a time with unit"), ("run: 25000 min", "expected a time from 10 ms to 24 h"),
    ("run: " + "9" * 400 + " s", "expected a time from"), ("run: .inf", "expected a time with unit"),
    ("run: true", "found 'true'"), ("run:", "run: found nothing"), ("run: {a: 1}", "found a mapping"),
    ("drive: {to: lap 0, within: 1 s}", "found 'lap 0', expected a distance such as '300 m', 'lap 3' or"),
    ("drive: {to: lap 2 + 10, within: 1 s}", "found '10', expected a number with unit, such as '10 m'"),
    ("drive: {to: 10 km, within: 1 s}", "found '10 km', expected a number with unit, such as '10 m'"),
    ("driver: {}", "found nothing to do"), ("driver: {brake: -1 %}", "expected 0 % to 100 %"),
    ("driver: {brake: 100 GA}", "expected a number with unit"), ("driver: {reset: true}", "expected one of pressed"),
    ("wait: {for: BmsStatus.State = Fault, within: 0 ms}", "wait.within: found '0 ms', expected a time from 10 ms"),
    ("wait: {for: Sync.Tick > 3, within: 1 s}", "Sync.Tick is of the frames that keep the nodes in step"),
    ("wait: {for: PackSensor.PackCurrent > 1001 A, within: 1 s}", "found '1001 A', expected -1000 A to 1000 A"),
    ("wait: {for: PackSensor.PackCurrent > 1000 A, within: 1 s}", "found > '1000 A', which never holds"),
    ("wait: {for: VehicleIo.AirPlusAux = 2, within: 1 s}", "found '2', expected 0 to 1"),
    ("wait: {for: InverterStatus.PhaseCurrent = 0.05 A, within: 1 s}", "expected a multiple of 0.1 A"),
    ("gateway: {drop: Pedals, every: -1}", "gateway.every: drop: found every -1, expected at least 1"),
    ("gateway: {drop: Pedals, every: 1.5}", "gateway.every: found '1.5', expected a whole number"),
    ("gateway: {drop: Pedals, every: 2 %}", "expected a whole number"),
    ("gateway: {drop: Pedals, every: yes}", "found 'yes'"),
    ("gateway: {drop: Pedals, every: .nan}", "found '.nan', expected a whole number"),
    ("gateway: {drop: Pedals, for: 0 ms}", "gateway.for: found '0 ms', expected a time from 10 ms"),
    ("gateway: {drop: Pedals, for: 15 ms}", "multiple of 10 ms"),
    ("gateway: {drop: []}", "lists need at least one entry"),
    ("gateway: {drop: [Pedals, [BMS]]}", "drop[1]: found a list"), ("gateway: {drop: Sync}", "'Sync' is no message"),
    ("gateway: {delay: Pedals, by: 0 ms}", "gateway.by: found '0 ms'"),
    ("gateway: {delay: Pedals, by: -10 ms}", "by: found"),
    ("gateway: {duplicate: Pedals, copies: 0}", "gateway.copies: duplicate: found number of frames or copies 0"),
    ("gateway: {duplicate: Pedals, copies: 101}", "at most 100"),
    ("gateway: {duplicate: Pedals, copies: 99999999999999999999}", "expected a whole number"),
    ("gateway: {corrupt: Pedals, bit: -1}", "gateway.bit: corrupt: found bit -1"),
    ("gateway: {corrupt: Pedals, bit: 64}", "gateway.bit: found bit 64, expected one below 64: Pedals has 8 bytes"),
    ("gateway: {replay: Pedals, frames: 65}",
     "gateway.frames: replay: found 65 frames, expected at most the 64 that are kept"),
    ("gateway: {stuck_counter: PackBroadcast}", "no message with a rolling counter"),
    ("gateway: {second_sender: Pedals, counter_ahead: 256}", "at most 255"),
    ("gateway: {second_sender: Pedals, counter_ahead: -1}",
     "gateway.counter_ahead: second_sender: found counter_ahead -1"),
    ("gateway: {second_sender: PackBroadcast, counter_ahead: 1}", "PackBroadcast has no rolling counter"),
    ("gateway: {second_sender: [Pedals, VehicleIo], signals: {Apps1: 1 V}}", "found 'Apps1', expected one of Counter"),
    ("gateway: {second_sender: Pedals, signals: {Apps1: 9 V}}", "signals.Apps1: found '9 V', expected 0 V to 5 V"),
    ("gateway: {second_sender: Pedals, signals: {Crc: 1}}", "Pedals.Crc is the crc that each frame gets"),
    ("gateway: {babble: 0x800000000}", "found '0x800000000', expected an identifier"),
    ("gateway: {babble: 0x20000000}", "expected an identifier from 0x000 to 0x7FF"),
    ("gateway: {babble: 0x}", "found '0x'"),
    ("gateway: {babble: 0x7E0}", "which keep the nodes in step"), ("gateway: {babble: -1}", "'-1' is no message"),
    ("gateway: {babble: PLANT, frames: 100}", "expected at most 1000 in all"),
    ("send: {message: Sync, signals: {Tick: 1}}", "send.message: found 'Sync'"),
    ("send: {message: BmsLimits, signals: {DischargeReason: Fualt}}",
     "signals.DischargeReason: BmsLimits.DischargeReason cannot be"),
    ("send: {message: BmsLimits, signals: {DischargeReason: 6}}", "cannot be '6'"),
    ("send: {message: BmsLimits, signals: {DischargeLimit: 1001 A}}", "expected 0 A to 1000 A"),
    ("send: {message: BmsLimits, signals: {DischargeLimit: -1 A}}", "expected 0 A to 1000 A"),
    ("send: {message: BmsLimits, signals: {LimitingCell: invalid}}", "no code for 'no measurement'"),
    ("send: {message: BmsLimits, signals: []}", "signals: found a list, expected a mapping"),
    ("plant: {fault: CellLost, index: -1}", "expected a whole number from 0 to"),
    ("plant: {fault: CellLost, index: 1.5}", "expected a whole number"),
    ("plant: {fault: ThermistorLost, index: 36}", "found 36, expected a whole number from 0 to"),
    ("plant: {fault: BrakeLost, index: 2}", "found 2, expected a whole number from 0 to 1"),
    ("plant: {fault: AirPlusWelded, index: 1}", "AirPlusWelded has no index"),
    ("plant: {fault: CellOffset, value: 32768 mV}", "expected -32768 mV to 32767 mV"),
    ("plant: {fault: ThermistorOffset, value: 3277 degC}", "expected -3276.8 degC to 3276.7 degC"),
    ("plant: {fault: CellResistanceScale, value: 0}", "expected 0.01 to 327.67"),
    ("plant: {fault: CellResistanceScale, value: -3}", "expected 0.01 to 327.67"),
    ("kill: bms\n  - kill: bms", "when[1]: found that bms is killed twice"),
    ("kill: hil", "expected one of bms, master")]
BAD_CHECKS = [
    ("torque_zero_within: -1 ms", "expected a time with unit"),
    ("torque_zero_within: 24 h", "expected a time with unit"),
    ("torque_zero_within: 1440 min", "checks that need more than 24 h"), ("torque_zero_within: []", "found a list"),
    ("torque_zero_within:", "found nothing"), ("torque_zero_within: {}", "'within' is missing"),
    ("reached: {condition: BmsStatus.State = Fault, within: 1 s, not_before: 2 s}", "not_before: found 2000 ms"),
    ("reached: {condition: [BmsStatus.State = Fault], within: 1 s}", "reached.condition: found a list"),
    ("reached: {condition: '', within: 1 s}", "expected a condition such as"),
    ("stays: {condition: BmsStatus.State = Fault, for: 0 ms}", "stays.for: found '0 ms'"),
    ("counted: {message: Pedals, at_least: 0, during: 1 s}", "at_least: found 0, expected a whole number from 1"),
    ("counted: {message: Pedals, at_least: 1.5, during: 1 s}", "at_least: found '1.5'"),
    ("counted: {message: Pedals, at_least: 1, during: 0 ms}", "during: found '0 ms'"),
    ("counted: {message: Sync, at_least: 1, during: 1 s}", "message: found 'Sync'")]
BAD_TOPS = [
    ("given:", "given: found nothing"), ("given: []", "given: found an empty list"),
    ("always: {}", "always: found 0 of them"),
    ("observe: 0 ms", "expected at least the 1100 ms"), ("observe: 1 s", "expected at least the 1100 ms"),
    ("proves: MST-999", "proves: found 'MST-999'"), ("proves: {a: 1}", "proves: found a mapping"),
    ("proves: [MST-001, MST-001]", "proves[1]: 'MST-001' stands here twice"), ("proves: [1]", "proves[0]: found '1'"),
    ("behind_gateway: [bms, hil]", "behind_gateway[1]: found 'hil'"),
    ("behind_gateway: [bms, bms]", "stands here twice"),
    ("behind_gateway: []", "at least one entry"), ("arguments: {a: 1}", "found a mapping"),
    ("arguments: [--set]", "without its"),
    ("arguments: [--laps, 3]", "found '--laps', expected --vehicle NAME or --set KEY=VALUE"),
    ("arguments: [--vehicel, x]", "Did you mean --vehicle"), ("arguments: [--set, [a]]", "arguments[1]: found a list"),
    ("arguments: [--set, true]", "arguments[1]: found true, which YAML takes for a truth value"),
    ("arguments: [--set, a]", "found 'a', expected KEY=VALUE"),
    ("arguments: [--set, ~]", "arguments[1]: found nothing")]


@pytest.mark.parametrize("page, row, complaint", [
    *((STEP, *row) for row in BAD_STEPS), *((CHECK, *row) for row in BAD_CHECKS), *((TOP, *row) for row in BAD_TOPS)])
def test_what_is_out_of_its_range_is_told_with_its_place(read, page, row, complaint):
    with pytest.raises(InputError) as error:
        read(page.replace("{}", row, 1))
    line = 1 + page[:page.index("{}")].count("\n")
    assert f"s.yaml:{line}: " in str(error.value) or "\n" in row or "24 h" in complaint
    assert complaint in str(error.value)


@pytest.mark.parametrize("title", ["true", "~", "''", "", "[a]", "{a: 1}"])
def test_a_title_is_text(read, title):
    with pytest.raises(InputError, match="s.yaml:1: scenario: found"):
        read(TOP.replace("x", title, 1).replace("{}", ""))


@needs_program
@pytest.mark.parametrize("arguments, complaint", [
    ("--set, battery.initial_soc=7", "found 7; expected a number from 0 to 1"),
    ("--set, battery.initial_so=0.1", "unknown key"), ("--vehicle, nope", "neither a known name")])
def test_arguments_are_what_the_program_takes(read, arguments, complaint):
    with pytest.raises(InputError, match=f"s.yaml:6: arguments: .*{complaint}"):
        read(TOP.replace("{}", f"arguments: [{arguments}]"))


@needs_program
@pytest.mark.parametrize("arguments, last", [("", 23), ("arguments: [--set, battery.cells_in_series=30]\n", 29)])
def test_a_cell_is_one_of_the_car_that_the_arguments_choose(read, arguments, last):
    step = arguments + STEP.replace("{}", "plant: {fault: CellLost, index: %d}")
    assert read(step % last).when
    with pytest.raises(InputError, match=f"found {last + 1}, expected a whole number from 0 to {last}"):
        read(step % (last + 1))


def test_without_the_program_a_cell_is_one_that_the_messages_can_carry(read, monkeypatch, tmp_path):
    monkeypatch.setenv("VOLTLAP_BUILD_DIR", str(tmp_path))
    step = "arguments: [--vehicle, unheard_of]\n" + STEP.replace("{}", "plant: {fault: CellLost, index: %d}")
    assert read(step % 143).when
    with pytest.raises(InputError, match="from 0 to 143"):
        read(step % 144)


@pytest.mark.parametrize("text, can_id", [("0x7FF", None), ("0x001", 1), ("0x800", 0x8000_0800),
                                          ("0x1FFFFFFF", 0x9FFF_FFFF),
                                          ("0x00000123", 0x8000_0123)])
def test_an_identifier_of_29_bits_is_sent_as_one(read, text, can_id):
    if can_id is None:
        with pytest.raises(InputError, match="keep the nodes in step"):
            read(STEP.replace("{}", f"gateway: {{babble: {text}}}"))
        return
    told = []
    rig = type("Rig", (), {"gateway": lambda self, kind, ids, *_, **__: told.extend(ids)})()
    read(STEP.replace("{}", f"gateway: {{babble: {text}}}")).when[0].act(rig)
    assert told == [can_id]


NUMBERS = ["-1", "0", "1", "2", "63", "64", "65", "101", "255", "256", "1000", "1000000", "1000001", "1.5", "1e3"]
TIMES = ["0 ms", "10 ms", "20 ms", "15 ms", "0.01 s", "0.57 s", "1 min", "24 min"]
TARGETS = ["Pedals", "PLANT", "BMS", "MASTER", "CellVoltages", "Temperatures", "PackBroadcast", "VehicleIo", "0x001",
           "0x7E5", "0x801", "0x1FFFFFFF"]
SIGNALS = ["{Apps1: 4.5 V}", "{Apps1: invalid, Apps2: 5 V}", "{Cell0: 6.5 V}", "{Cell1: invalid}", "{AirPlusAux: 1}",
           "{}", "{PackCurrent: -3276.8 A}", "{PackSoc: 100 %}", "{State: Fault}", "{Temperature0: -40 degC}"]
KINDS = {"drop": ["every"], "silence": [], "delay": ["by"], "duplicate": ["copies"], "corrupt": ["bit"],
         "replay": ["frames"],
         "stuck_counter": [], "babble": ["frames"], "second_sender": ["signals", "counter_ahead"]}


def drawn_fault(draw):
    kind = draw.choice(list(KINDS))
    fields = {kind: f"[{', '.join(draw.sample(TARGETS, draw.choice((1, 1, 1, 2))))}]"}
    for word in [*KINDS[kind], "for"]:
        if draw.random() < 0.7:
            fields[word] = draw.choice(TIMES if word in ("by", "for") else SIGNALS if word == "signals" else NUMBERS)
    return f"gateway: {{{', '.join(f'{name}: {value}' for name, value in fields.items())}}}"


def test_every_fault_of_the_bus_that_is_read_acts_on_any_frame(read, dbc):
    """What is accepted goes through the gateway's code with drawn frames, alone and with others."""
    seed = random.randrange(2**32)
    draw, accepted = random.Random(seed), 0
    for number in range(400):
        steps = "\n  - ".join(drawn_fault(draw) for _ in range(draw.choice((1, 1, 2))))
        try:
            scenario = read(STEP.replace("{}", steps))
        except InputError as error:
            assert "s.yaml:" in str(error), f"seed {seed}, draw {number}: {steps}: {error}"
            continue
        accepted += 1
        try:
            act_out(scenario, dbc, seed + number)
        except Exception as error:
            raise AssertionError(f"seed {seed}, draw {number}: {steps} was read, and ended in {error!r}") from error
    assert accepted > 40, f"seed {seed}: only {accepted} of 400 were read"
