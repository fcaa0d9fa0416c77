# SPDX-License-Identifier: Apache-2.0
"""A scenario file is read whole before anything runs, and a mistake is told with file, line, field and what fits."""
import pathlib

import pytest

from voltlap_hil.errors import InputError
from voltlap_hil.scenario_file import load

GOOD = """\
scenario: Lost pedals
proves: [MST-001]
given:
  - start_up: ready_to_drive
  - driver: {accelerator: 100 %, shutdown: closed}
  - wait: {for: InverterStatus.PhaseCurrent > 300 A, within: 1 s}
when:
  - gateway: {delay: Pedals, by: 60 ms, for: 300 ms}
meanwhile:
  - run: 100 ms
then:
  - torque_zero_within: 100 ms
  - reached: {condition: MasterStatus.Faults has PedalsLost, within: MST-001}
always:
  - contactors_open_within: {within: 250 ms, after: BmsStatus.State = Fault}
"""


@pytest.fixture
def read(tmp_path, dbc):
    def reading(text):
        path = tmp_path / "s.yaml"
        path.write_text(text)
        return load(path, dbc)
    return reading


class FakeRig:
    """Writes down what a step asks of a rig."""

    def __init__(self):
        self.calls = []

    def __getattr__(self, name):
        return lambda *a, **k: self.calls.append((name, a, k))


def calls_of(scenario, part="when"):
    rig = FakeRig()
    for step in getattr(scenario, part):
        step.act(rig)
    return rig.calls


def test_a_page_becomes_steps_and_checks(read):
    s = read(GOOD)
    assert (s.title, s.proves, s.behind) == ("Lost pedals", ["MST-001"], ("bms", "master"))
    assert [len(part) for part in (s.given, s.when, s.meanwhile, s.then, s.always)] == [3, 1, 1, 2, 1]
    assert s.needs_gateway
    assert s.then[1].lasts_ms == 50  # the bound of MST-001
    needed = {"Pedals.BrakeFront", "InverterStatus.PhaseCurrent", "MasterStatus.Faults", "BmsStatus.State"}
    assert needed <= set(s.watch)


def test_it_observes_until_every_bound_has_passed(read):
    assert read(GOOD).observe_ms == (250 + 100) + 500
    assert read(GOOD + "observe: 2 s\n").observe_ms == 2000


@pytest.mark.parametrize("step, call", [
    ("driver: {brake: 50 %, ts_on: pressed, shutdown: open}",
     ("driver", (), {"brake": 50.0, "ts_on": "On", "shutdown": "Off"})),
    ("plant: {fault: CellOffset, index: 3, value: 700 mV}", ("plant", ("CellOffset", 3, 700), {})),
    ("plant: {fault: ThermistorOffset, value: 40 degC}", ("plant", ("ThermistorOffset", 0, 400), {})),
    ("plant: {fault: CellResistanceScale, index: 1, value: 3}", ("plant", ("CellResistanceScale", 1, 300), {})),
    ("plant: {fault: CellGain, index: 1, value: 0.9}", ("plant", ("CellGain", 1, 900), {})),
    ("plant: {fault: CellFrozen, index: 5}", ("plant", ("CellFrozen", 5, 0), {})),
    ("plant: {fault: CurrentOffset, value: -2.5 A}", ("plant", ("CurrentOffset", 0, -250), {})),
    ("plant: {fault: DcLinkStuck, value: 96 V}", ("plant", ("DcLinkStuck", 0, 960), {})),
    ("plant: {fault: AirPlusWelded}", ("plant", ("AirPlusWelded", 0, 0), {})),
    ("clear: plant", ("plant", ("ClearAll",), {})),
    ("clear: gateway", ("clear_gateway", (), {})),
    ("kill: bms", ("kill", ("bms",), {})),
    ("run: 100 ms", ("run", ("100 ms",), {})),
    ("drive: {to: 300 m, within: 1 min}", ("drive", (300.0, "1 min"), {})),
    ("drive: {to: lap 1, within: 1 min}", ("drive", (0.0, "1 min"), {})),
    ("drive: {to: lap 2 + 100 m, within: 3 min}", ("drive", (914.061, "3 min"), {})),
    ("send: {message: BmsLimits, signals: {DischargeLimit: 10 A, DischargeReason: Fault}}",
     ("send", ("BmsLimits",), {"DischargeLimit": 10.0, "DischargeReason": "Fault"})),
    ("gateway: {silence: BMS}", ("gateway", ("silence", ["BMS"], None), {})),
    ("gateway: {drop: [Pedals, VehicleIo], every: 2, for: 1 s}",
     ("gateway", ("drop", ["Pedals", "VehicleIo"], 1000.0), {"every": 2})),
    ("gateway: {delay: Pedals, by: 30 ms}", ("gateway", ("delay", ["Pedals"], None), {"delay_ticks": 3})),
    ("gateway: {duplicate: Pedals}", ("gateway", ("duplicate", ["Pedals"], None), {"copies": 1})),
    ("gateway: {corrupt: Pedals}", ("gateway", ("corrupt", ["Pedals"], None), {"bit": None})),
    ("gateway: {corrupt: Pedals, bit: 13}", ("gateway", ("corrupt", ["Pedals"], None), {"bit": 13})),
    ("gateway: {replay: Pedals, frames: 5}", ("gateway", ("replay", ["Pedals"], None), {"copies": 5})),
    ("gateway: {stuck_counter: CellVoltages}", ("gateway", ("stuck_counter", ["CellVoltages"], None), {})),
    ("gateway: {babble: [0x001], frames: 50}", ("gateway", ("babble", [1], None), {"copies": 50})),
    ("gateway: {second_sender: Pedals, counter_ahead: 2, signals: {Apps1: 4.5 V, Apps2: invalid}}",
     ("gateway", ("second_sender", ["Pedals"], None), {"signals": {"Apps1": 4.5, "Apps2": None}, "counter_ahead": 2}))])
def test_every_step_says_to_the_rig_what_stands_in_the_file(read, step, call):
    s = read(f"scenario: x\nwhen:\n  - {step}\nthen:\n  - torque_zero_within: 1 s\n")
    assert calls_of(s) == [call]


@pytest.mark.parametrize("check, title", [
    ("contactors_commanded_open_within: BMS-030", "contactors commanded open"),
    ("limit_obeyed_within: 1 s", "limit obeyed"),
    ("no_torque_above_limit_within: 20 ms", "no torque above limit"),
    ("settled: {condition: BmsStatus.State = Fault, within: 1 s}", "for good BmsStatus.State = Fault"),
    ("stays: {condition: BmsStatus.State = Fault, for: 1 s, from: 100 ms}", "stays BmsStatus.State = Fault"),
    ("reached: {condition: BmsStatus.State = Fault, within: 1 s, not_before: 30 ms}", "BmsStatus.State = Fault"),
    ("counted: {message: Pedals, at_least: 10, during: 1 s}", "Pedals seen")])
def test_every_check_is_read(read, check, title):
    assert read(f"scenario: x\nwhen:\n  - run: 10 ms\nthen:\n  - {check}\n").then[0].title == title


MISTAKES = [
    ("scenario: Lost pedals", "scenari: Lost pedals", 1, "found 'scenari', expected one of scenario, proves"),
    ("MST-001]", "MST-099]", 2, "proves[0]: found 'MST-099', expected the id of a requirement. Did you mean"),
    ("ready_to_drive", "ready", 4, "given[0].start_up: found 'ready', expected one of low_voltage"),
    ("100 %", "100", 5, "given[1].driver.accelerator: found '100', expected a number with unit, such as '10 %'"),
    ("100 %", "120 %", 5, "expected 0 % to 100 %"),
    ("shutdown: closed", "shutdown: pressed", 5, "expected one of closed, open, automatic"),
    ("shutdown: closed", "clutch: closed", 5, "found 'clutch', expected one of accelerator"),
    ("InverterStatus.PhaseCurrent", "InverterStatus.Current", 6,
     "given[2].wait.for: InverterStatus has no signal 'Current'"),
    ("within: 1 s", "within: 1 hour", 6, "given[2].wait.within: found '1 hour', expected a time"),
    (", within: 1 s", "", 6, "given[2].wait: 'within' is missing"),
    ("delay: Pedals", "delay: Pedal", 8,
     "when[0].gateway.delay: 'Pedal' is no message, group of messages or node. Did you mean Pedals"),
    ("by: 60 ms", "by: 65 ms", 8, "multiple of 10 ms"),
    ("by: 60 ms", "copies: 2", 8, "delay has no 'copies'; it has for, by"),
    ("by: 60 ms, ", "", 8, "'by' is missing"),
    ("delay: Pedals, by: 60 ms", "drop: Pedals, every: 0", 8, "drop: found every 0, expected at least 1"),
    ("delay: Pedals, by: 60 ms", "corrupt: Pedals, bit: 64", 8, "found bit 64, expected one below 64: Pedals has 8"),
    ("always:", "observe: 50 ms\nalways:", 14,
     "observe: found 50 ms, expected at least the 350 ms that the checks need"),
    ("delay: Pedals, ", "", 8, "found 0 faults, expected one of drop, silence"),
    ("run: 100 ms", "walk: 100 ms", 10, "found 'walk', expected one of start_up"),
    ("run: 100 ms", "run: [100 ms]", 10, "meanwhile[0].run: found a list, expected text or a number"),
    ("torque_zero_within: 100 ms", "torque_zero_within: MST-020", 12, "MST-020 states no time"),
    ("torque_zero_within", "torque_zero", 12, "found 'torque_zero', expected one of torque_zero_within"),
    ("has PedalsLost", "has PedalLost", 13,
     "then[1].reached.condition: MasterStatus.Faults has no bit 'PedalLost'. Did you mean PedalsLost"),
    ("{within: 250 ms, ", "{", 15, "always[0].contactors_open_within: 'within' is missing"),
    ("given:\n", "given: {\n", 4, "this is no YAML"),
    ("proves:", "scenario:", 2, "'scenario' stands here twice"),
    ("when:", "meanwhile:", 9, "'meanwhile' stands here twice")]


@pytest.mark.parametrize("right, wrong, line, complaint", MISTAKES)
def test_a_mistake_is_told_with_file_line_field_and_what_fits(read, right, wrong, line, complaint):
    assert right in GOOD
    with pytest.raises(InputError) as error:
        read(GOOD.replace(right, wrong, 1))
    assert f"s.yaml:{line}: " in str(error.value)
    assert complaint in str(error.value)


@pytest.mark.parametrize("plant, complaint", [
    ("{fault: CellOffset, index: 1}", "'value' is missing: CellOffset needs one, with unit mV"),
    ("{fault: AirPlusWelded, value: 3 mV}", "AirPlusWelded has no value"),
    ("{fault: AirWelded}", "Did you mean AirPlusWelded")])
def test_a_fault_of_the_plant_has_a_value_where_it_needs_one(read, plant, complaint):
    with pytest.raises(InputError, match=complaint):
        read(f"scenario: x\nwhen:\n  - plant: {plant}\nthen:\n  - torque_zero_within: 1 s\n")


@pytest.mark.parametrize("text, complaint", [("", "the file is empty"), ("- a\n", "found a list, expected a mapping"),
                                             ("scenario: x\nwhen: []\nthen: []\n", "need at least one entry")])
def test_a_file_that_is_no_scenario_is_told(read, text, complaint):
    with pytest.raises(InputError, match=complaint):
        read(text)


def test_a_file_that_is_not_there_is_told(dbc):
    with pytest.raises(InputError, match="none.yaml: No such file"):
        load("none.yaml", dbc)


SHIPPED = sorted((pathlib.Path(__file__).resolve().parents[1] / "scenarios").glob("*.yaml"))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_scenario_of_the_project_is_right(path, dbc):
    scenario = load(path, dbc)
    assert scenario.when and scenario.then and scenario.title


def test_there_are_scenarios_and_each_has_a_title_of_its_own(dbc):
    titles = [load(path, dbc).title for path in SHIPPED]
    assert len(titles) >= 25 and len(set(titles)) == len(titles)
