# SPDX-License-Identifier: Apache-2.0
"""The table of faults: every row of the project's is read, and each mistake in one is told with its line and field."""
import pytest

from voltlap_hil.errors import InputError
from voltlap_hil.fault_table import TABLE, load_table, whole_bound

HEAD = """\
situations:
  full:
    what: full pedal
    sound: BmsStatus.State = TsActive
    given: [start_up: ready_to_drive]
rows:
"""
ROW = ("  - {id: one, group: g, what: w, proves: MST-002, drive: full, when: {kill: bms}, "
       "sees: BmsStatus.State = Fault, seen_within: 100 ms}\n")


@pytest.fixture
def load(tmp_path, dbc):
    def loaded(*rows):
        path = tmp_path / "faults.yaml"
        path.write_text(HEAD + "".join(rows))
        return load_table(path, dbc)
    return loaded


@pytest.fixture(scope="module")
def table():
    from voltlap_hil.dbc import Dbc
    return load_table(TABLE, Dbc.of_project())


def test_the_table_of_the_project_is_right_and_large(table):
    assert len(table) >= 120
    assert len({row.id for row in table}) == len(table)


def test_a_row_is_one_line(table):
    lines = TABLE.read_text().splitlines()
    for row in table:
        assert lines[row.line - 1].startswith(f"  - {{id: {row.id}, ")


def test_a_representative_part_runs_on_an_interface(table):
    """A third of them, of each group; what needs one process does not ask for an interface."""
    groups = {row.group for row in table}
    assert 3 * sum(row.vcan for row in table) >= len(table)
    assert len({row.group for row in table if row.vcan}) >= len(groups) - 1
    assert not [row.id for row in table if row.vcan and row.scenario.needs_process]


def test_every_safety_frame_is_lost_in_every_way(table):
    ids = {row.id for row in table}
    for frame in ("pedals", "vehicle_io", "bms_limits", "bms_status", "contactor_command", "inverter_status",
                  "inverter_command", "pack_sensor", "cell_voltages", "temperatures", "master_status"):
        assert {f"{frame}_lost", f"{frame}_lost_1", f"{frame}_lost_3", f"{frame}_loss_2", f"{frame}_loss_5"} <= ids


def test_a_row_becomes_a_scenario(load):
    row, = load(ROW)
    assert (row.line, row.id, row.answers_to) == (7, "one", "MST-002")
    assert row.seen is not None and row.scenario.observe_ms == 200.0
    assert not row.scenario.needs_gateway


@pytest.mark.parametrize(("old", "new", "said"), [
    ("{kill: bms}", "{gateway: {drop: BmsStatus}}",
     ":7: row one.when: found BmsStatus, from bms to master, on the same side of the gateway, so that nothing"),
    ("when: {kill: bms}", "behind: bms, when: {gateway: {drop: Pedals}}",
     ":7: row one.when: found Pedals, from plant to master, on the same side of the gateway, so that nothing"),
    ("id: one", "id: One!", ":7: rows[0].id: found 'One!', expected 3 to 60 small letters"),
    ("drive: full", "drive: ful", ":7: row one.drive: found 'ful', expected one of full. Did you mean full?"),
    ("proves: MST-002", "proves: MST-999", ":7: row one.proves: found 'MST-999'"),
    ("proves: MST-002, ", "", ":7: row one: found neither 'rule' nor 'proves'"),
    ("proves: MST-002", "rule: X.1", ":7: row one.rule: found 'X.1', expected the id of a rule"),
    ("kill: bms", "kill: bmx", ":7: row one.when.kill: found 'bmx'"),
    ("Fault,", "Fualt,", ":7: row one.sees: BmsStatus.State cannot be = 'Fualt'. Did you mean Fault?"),
    ("seen_within: 100 ms", "seen_within: 100", ":7: row one.seen_within: found '100', expected a time with unit"),
    ("seen_within: 100 ms", "seen_within: 15 ms", ":7: row one.seen_within: found '15 ms', expected a multiple"),
    (", seen_within: 100 ms", "", ":7: row one: 'sees' and 'seen_within' go together"),
    ("seen_within: 100 ms", "seen_within: 100 ms, observe: 150 ms", ":7: row one.observe: found 150 ms"),
    ("{kill: bms}", "{reset: bms}, vcan: true", ":7: row one.vcan: found true beside 'reset'"),
    ("seen_within: 100 ms", "seen_within: 100 ms, vcan: maybe", ":7: row one.vcan: found 'maybe'"),
    ("sees: BmsStatus.State = Fault, seen_within: 100 ms", "torque_zero_within: 10 ms, goes_on: 1 s",
     ":7: row one.goes_on: found a car that goes on and one that is stopped"),
    (", sees: BmsStatus.State = Fault, seen_within: 100 ms", "", ":7: row one: nothing is expected"),
    ("{kill: bms}", "{gateway: {sensor: Pedals.Apps1}}", ":7: row one.when.gateway: found 0 ways to lie"),
    ("{kill: bms}", "{gateway: {sensor: Pedals.Apps9, stuck: 1 V}}", ":7: row one.when.gateway.sensor: Pedals has no"),
    ("{kill: bms}", "{gateway: {sensor: Pedals.Apps1, stuck: 9 V}}", ":7: row one.when.gateway.stuck: found '9 V'"),
    ("{kill: bms}", "{gateway: {sensor: Pedals.Counter, offset: 1}}", "is the counter of its frame"),
    ("{kill: bms}", "{gateway: {sensor: Pedals.Apps1, late: 2 s}}", "at most the 64 frames that are kept"),
    ("{kill: bms}", "{gateway: {drop: Pedals, share: 0 %}}", "found a share of 0 %"),
    ("{kill: bms}", "{plant: {fault: AirPlusChatters, value: 0 ms}}", ":7: row one.when.plant.value: found '0 ms'"),
    ("{kill: bms}", "{reset: {node: bms, off: 2 min}}", ":7: row one.when.reset.off: found 120000 ms"),
])
def test_a_mistake_is_told_with_line_and_field(load, old, new, said):
    assert old in ROW
    with pytest.raises(InputError) as told:
        load(ROW.replace(old, new))
    assert said in str(told.value)


def test_an_id_stands_once_and_every_mistake_is_told(load):
    with pytest.raises(InputError) as told:
        load(ROW, ROW, ROW.replace("id: one", "id: two").replace("kill: bms", "kill: me"))
    assert ":8: row one: the id 'one' stands here twice" in str(told.value)
    assert ":9: row two.when.kill" in str(told.value)


def test_a_bound_is_a_time_a_requirement_or_their_sum():
    assert whole_bound("110 ms") == 110
    assert whole_bound("MST-003") == 110
    assert whole_bound("MST-003 + 20 ms") == 130
    with pytest.raises(InputError, match="states no time"):
        whole_bound("BMS-003")
