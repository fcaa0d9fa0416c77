# SPDX-License-Identifier: Apache-2.0
"""Logs of one to five rows a second, as many loggers write them: what was switched between the rows is no finding, and
an error of the cells' heat is found all the same. VOLTLAP_TEST_SEED repeats a draw."""
import pytest

from drawn_drives import Draw, explained, rows_of, write

AIR = 26.85  # degC of vtm16e and vtm17e


@pytest.mark.parametrize("rate", [1, 2, 5])
@pytest.mark.parametrize("number", range(3))
def test_a_sound_log_of_few_rows_shows_no_discrepancy(tmp_path, rate, number):
    """Seven of thirteen were told a polarization or a relaxation of 0.03 to 0.13 mOhm."""
    draw = Draw(f"few{rate}/{number}")
    car = tmp_path / "car.toml"
    car.write_text(f'name = "few"\nbase = "{draw.random.choice(("vtm16e", "vtm17e", "vtm17e"))}"\n'
                   f"[powertrain]\nfinal_drive = {draw.random.uniform(3.0, 4.2):.2f}\n")
    log = draw.drive(tmp_path, vehicle=car, rate=rate, laps=draw.random.randrange(6, 10))
    answer, said = explained(tmp_path, log, model=car)
    assert answer["verdict"] == "no_discrepancy", (car.read_text(), said)


@pytest.mark.parametrize("rate", [1, 2])
@pytest.mark.parametrize("column", [False, True])
def test_a_heat_capacity_is_found_in_few_rows_where_the_air_is_known(tmp_path, rate, column):
    """By a column of the log, or as who asks says it: 3 K of air hide a half of it otherwise."""
    draw = Draw(f"capacity{rate}{column}")
    change = draw.random.choice((draw.random.uniform(-0.6, -0.45), draw.random.uniform(0.6, 0.9)))
    log = draw.drive(tmp_path, f"cell.heat_capacity_j_per_kg_k={747.0 * (1.0 + change):.1f}", rate=rate, laps=14)
    if column:
        names, rows = rows_of(log)
        log = write(tmp_path / "air.csv", [*names, "ambient_c"], [[*row, f"{AIR}"] for row in rows])
    known = [] if column else ["--set", f"environment.ambient_c={AIR}"]
    answer, said = explained(tmp_path, log, *known)
    names = [{c["name"], *c["equivalent_to"]} for c in answer["causes"]]
    alternatives = {name for names_of_one in answer.get("alternatives", []) for name in names_of_one}
    assert len(names) == 1 and "heat_capacity" in names[0] | alternatives, (change, said)
    if answer["causes"][0]["name"] == "heat_capacity":
        off = 0.2 if rate == 1 else 0.12
        low, high = (1.0 + change) * (1.0 - off) - 1.0, (1.0 + change) * (1.0 + off) - 1.0
        assert low < answer["causes"][0]["parameters"]["change"]["value"] < high, (change, said)
    assert "how warm the air was" not in said


def test_air_that_hides_an_error_is_said_with_what_it_is_taken_as(tmp_path):
    draw = Draw("air hides")
    change = draw.random.uniform(0.4, 0.6)
    log = draw.drive(tmp_path, f"cell.heat_capacity_j_per_kg_k={747.0 * (1.0 + change):.1f}", rate=1, laps=14)
    answer, said = explained(tmp_path, log)
    hidden = answer["verdict"] == "no_discrepancy"
    assert not hidden or "the log does not say how warm the air was: it is taken as" in said, (change, said)
    answer, told = explained(tmp_path, log, "--set", f"environment.ambient_c={AIR}")
    assert answer["verdict"] != "no_discrepancy" and "how warm the air was" not in told, (change, told)
    sound = draw.drive(tmp_path, rate=1, laps=14)
    _, of_sound = explained(tmp_path, sound)
    assert "how warm the air was" not in of_sound, of_sound
