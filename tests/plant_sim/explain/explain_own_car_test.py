# SPDX-License-Identifier: Apache-2.0
"""A car as `voltlap new` writes it: tyres that corners hold back, a rotor with inertia, a winding that warms, cells
that are warmer than their surface, weighed without its pack. Drawn; VOLTLAP_TEST_SEED repeats a draw."""
import pathlib
import re
import tomllib

import pytest

from drawn_drives import Draw, explained, rows_of, run, write

DBC = pathlib.Path(__file__).parents[3] / "can_dbc" / "car.dbc"
CURRENT = "0B0"  # identifier of the frame that has it
AIR = "26.85"  # degC, of the car that `new` begins with
MOTORS = {"emrax_228_mv": (72, 108), "emrax_208_hv": (84, 111), "emrax_188_hv": (66, 84), "emrax_228_hv": (100, 138)}


def own_car(draw, folder, least_parallel=3):
    motor = draw.random.choice(sorted(MOTORS))
    cells = f"{draw.random.randint(*MOTORS[motor])}x{draw.random.randint(least_parallel, 6)}"
    cell = draw.random.choice(("molicel_p45b", "sony_vtc6", "samsung_30q"))
    words = ["--mass", f"{draw.random.uniform(190, 290):.0f}", "--tyre-radius", f"{draw.random.uniform(0.2, 0.26):.3f}",
             "--gear", f"{draw.random.uniform(3.0, 5.5):.2f}", "--motor", motor, "--cells", cells, "--cell", cell]
    print(" ".join(words))
    run("new", "car", folder / "ours", *words)
    return folder / "ours.toml"


def drive(draw, car, *keys):
    """Its CSV and its candump."""
    out = car.with_name(f"drive{draw.random.randrange(10**9)}")
    track = draw.random.choice(("michigan_2014", "michigan_2015"))
    run("endurance", "--vehicle", car, "--laps", 3, "--track", track, "--csv", f"{out}.csv", "--candump", f"{out}.log",
        *(("--set", *keys) if keys else ()))
    return pathlib.Path(f"{out}.csv"), pathlib.Path(f"{out}.log")


@pytest.mark.parametrize("number", range(3))
def test_sound_drive_of_an_own_car_shows_no_discrepancy(tmp_path, number):
    draw = Draw(f"own{number}")
    car = own_car(draw, tmp_path)
    for log in drive(draw, car):
        answer, said = explained(tmp_path, log, model=car)
        assert answer["verdict"] == "no_discrepancy", (log.suffix, said)
        assert ("forces on the car and what its tyres slip are not judged" in said) == (log.suffix == ".log"), said


def test_its_mass_is_found_and_written_where_the_file_has_it(tmp_path):
    draw = Draw("own mass")
    # A pack whose limit cuts the torque on and off between two rows hides it: 0.07 m/s are left by the true mass.
    car = own_car(draw, tmp_path, least_parallel=4)
    without_pack = tomllib.loads(car.read_text())["vehicle"]["mass_without_pack_kg"]
    more = draw.random.choice((-1.0, 1.0)) * draw.random.uniform(15.0, 35.0)
    log, _ = drive(draw, car, f"vehicle.mass_without_pack_kg={without_pack + more:.2f}")
    better = tmp_path / "better.toml"
    answer, said = explained(tmp_path, log, "--write-model", better, model=car)
    named = [cause["name"] for cause in answer["causes"]]
    others = [name for names in answer.get("alternatives", ()) for name in names]
    # Beside a motor whose speed is reckoned from the car's, what it slips may be told by others as well.
    assert "mass" in [*named, *others], (more, said)
    if "mass" not in named:
        return
    vehicle = tomllib.loads(better.read_text())["vehicle"]
    assert vehicle.keys() == {"mass_without_pack_kg"}, vehicle
    assert vehicle["mass_without_pack_kg"] == pytest.approx(without_pack + more, abs=0.35 * abs(more)), (more, said)


def test_true_air_makes_no_sound_log_wrong(tmp_path):
    """The current of a car is switched between rows of 0.1 s: what it heats is more than a straight line's."""
    draw = Draw("own air")
    car = own_car(draw, tmp_path)
    log, _ = drive(draw, car)
    names, rows = rows_of(log)
    plain = {"time_s": "time_s", "pack_current_a": "current_a", "pack_voltage_v": "pack_voltage_v",
             **{name: f"cell_voltage_{name.split('_')[1]}_v" for name in names
                if name.startswith("cell_") and name.endswith("_voltage_v")},
             **{name: f"temperature_{name.split('_')[1]}_c" for name in names
                if name.startswith("cell_") and name.endswith("_temperature_c")}}
    columns = [names.index(name) for name in plain]
    with_air = write(tmp_path / "air.csv", [*plain.values(), "ambient_c"],
                     [[*(row[k] for k in columns), AIR] for row in rows])
    answer, said = explained(tmp_path, with_air, "--set", "cell.surface_lag_s=0", model=car)
    assert answer["verdict"] == "no_discrepancy", said


def test_columns_of_motor_and_corners_are_known_by_their_names(tmp_path):
    """Without them the torque is guessed from the pedal, and what corners take is not known."""
    draw = Draw("own columns")
    car = own_car(draw, tmp_path, least_parallel=4)
    log, _ = drive(draw, car)
    names, rows = rows_of(log)
    german = {"time_s": "Zeit [s]", "pack_current_a": "Strom [A]", "pack_voltage_v": "Spannung [V]",
              "dc_link_v": "Zwischenkreisspannung [V]", "phase_current_a": "Motorstrom [A]",
              "speed_mps": "Geschwindigkeit [m/s]", "accelerator": "Gaspedal", "brake": "Bremse",
              "lateral_mps2": "Querbeschleunigung [g]"}
    columns = [names.index(name) for name in german]
    lateral = list(german).index("lateral_mps2")
    table = [[row[k] for k in columns] for row in rows]
    for row in table:
        row[lateral] = f"{float(row[lateral]) / 9.80665:.5f}"
    answer, said = explained(tmp_path, write(tmp_path / "log.csv", list(german.values()), table), model=car)
    for role in ("motor_current", "bus_voltage", "lateral_acceleration"):
        assert f"{role} from" in said, said
    assert answer["verdict"] == "no_discrepancy", said


def table_of_frames(log, folder, every_s, torque=False, cells=True, pack=True):
    """What `log decode` makes of a candump, as a team takes it to a spreadsheet: current, voltage, pedals, speed,
    thermistors, with `cells` every cell (each held from the time at which its frame came), with `torque` what the
    inverter says; without the pack's voltage where not `pack`."""
    decoded = folder / "decoded.csv"
    run("log", "decode", log, "--dbc", DBC, "--every", f"{every_s:g}", "--out", decoded)
    names, rows = rows_of(decoded)
    wanted = {"time_s": "time_s", "PackCurrent": "Pack Current [A]", "FrontLeft": "Speed [m/s]",
              "Accelerator": "Accelerator [%]", "BrakeFront": "Brake Pressure [bar]", "MotorSpeed": "Motor Speed [rpm]",
              **({"PackVoltage": "Pack Voltage [V]"} if pack else {}),
              **({"PhaseCurrent": "Motor Current [A]"} if torque else {})}
    columns = {}
    for k, name in enumerate(names):
        signal = name.split(".")[-1].split(" ")[0]
        if name == "time_s" or (signal in wanted and wanted[signal] not in columns):
            columns[wanted.get(signal, name)] = k
        of_three = re.match(r"(Temperatures|CellVoltages)_(\w+)\.(?:Temperature|Cell)(\d)", name)
        if of_three and (cells or of_three[1] == "Temperatures") and any(row[k] for row in rows):
            what, unit = ("Temp", "degC") if of_three[1] == "Temperatures" else ("Cell", "V")
            columns[f"{what} {3 * int(of_three[2]) + int(of_three[3]) + 1} [{unit}]"] = k
    return write(folder / f"every{every_s:g}.csv", list(columns), [[row[k] for k in columns.values()] for row in rows])


@pytest.mark.parametrize("every_s", [0.05, 0.1, 0.5, 1.0])
def test_what_decode_writes_of_a_sound_drive_is_sound(tmp_path, every_s):
    """Rows that are far apart, values that were held, a pedal whose torque is cut by limits that no column says, slow
    messages that have not come yet in the first row, cells that are of another time than the current of their row."""
    draw = Draw(f"decoded{every_s:g}")
    car = own_car(draw, tmp_path, least_parallel=2)
    _, log = drive(draw, car)
    torque = draw.random.random() < 0.5
    for cells, pack in ((False, True), (True, True), (True, False)):
        table = table_of_frames(log, tmp_path, every_s, torque, cells, pack)
        answer, said = explained(tmp_path, table, model=car)
        assert answer["verdict"] == "no_discrepancy", (cells, pack, said)


def cells_in_turn(draw, log, folder, turn_s, every):
    """A logger's table of a battery unit that reads one cell after the other, each once in `turn_s`, and holds it;
    with or without the pack's voltage, steps and noise as they come."""
    pack, step_v, noise_v = draw.random.random() < 0.6, draw.random.choice((1e-3, 1e-4)), draw.random.choice((0, 1e-3))
    names, rows = rows_of(log)
    cells = [k for k, name in enumerate(names) if re.fullmatch(r"cell_\d+_voltage_v", name)]
    plain = {"time_s": "Time [s]", "pack_current_a": "Pack Current [A]", "speed_mps": "Speed [m/s]",
             **({"pack_voltage_v": "Pack Voltage [V]"} if pack else {})}
    held, table = {}, []
    for n, row in enumerate(rows):
        for j, k in enumerate(cells):
            turn = int((float(row[0]) - j * turn_s / len(cells)) / turn_s + 1e-9)
            if held.get(k, (None,))[0] != turn:
                held[k] = turn, round(round((float(row[k]) + draw.random.gauss(0, noise_v)) / step_v) * step_v, 5)
        if n % every == 0:
            table.append([row[names.index(name)] for name in plain] + [f"{held[k][1]:g}" for k in cells])
    print(f"turn {turn_s} s, row {every / 10} s, pack {pack}, steps {step_v} V, noise {noise_v} V")
    return write(folder / f"turn{turn_s}_{every}.csv",
                 [*plain.values(), *(f"Cell {j + 1} [V]" for j in range(len(cells)))], table)


TURNS = ((0.3, 2), (0.72, 1), (0.72, 5), (2.4, 1), (2.4, 10))


def test_cells_that_were_read_in_turn_and_held_are_no_error(tmp_path):
    draw = Draw("held cells")
    car = own_car(draw, tmp_path, least_parallel=2)
    log, _ = drive(draw, car)
    for turn_s, every in TURNS:
        answer, said = explained(tmp_path, cells_in_turn(draw, log, tmp_path, turn_s, every), model=car)
        assert answer["verdict"] == "no_discrepancy", said


def test_a_weak_cell_is_found_among_cells_that_were_held(tmp_path):
    draw = Draw("held weak cell")
    car = own_car(draw, tmp_path, least_parallel=5)
    cell, scale = draw.random.randint(1, 60), draw.random.uniform(1.4, 1.7)
    log, frames = drive(draw, car, f"battery.cells.{cell}.resistance_scale={scale:.3f}")
    for table in (cells_in_turn(draw, log, tmp_path, 0.3, 2), table_of_frames(frames, tmp_path, 0.1)):
        answer, said = explained(tmp_path, table, model=car)
        found = [(c["name"], c["parameters"]["cell"]["value"]) for c in answer["causes"] if "cell" in c["parameters"]]
        assert found == [("weak_cell", cell)], (cell, scale, said)


def lost(draw, log, frame, share):
    """A candump from which a logger lost some of a frame."""
    lines = log.read_text(encoding="ascii").splitlines(keepends=True)
    kept = [line for line in lines if f" {frame}#" not in line or draw.random.random() > share]
    out = log.with_name(f"lost_{share:.5f}.log")
    out.write_text("".join(kept), encoding="ascii")
    print(f"{len(lines) - len(kept)} frames lost")
    return out


@pytest.mark.parametrize("number", range(2))
def test_frames_of_the_current_that_a_logger_lost_change_no_answer(tmp_path, number):
    """What was read while a load came or went that no frame tells is off by all of it, once."""
    draw = Draw(f"lost{number}")
    car = own_car(draw, tmp_path, least_parallel=5)  # a weak cell of a small pack ends the drive
    cell, by = draw.random.randint(1, 60), draw.random.choice(("resistance_scale", "capacity_scale"))
    scale = draw.random.uniform(1.4, 1.7) if by == "resistance_scale" else draw.random.uniform(0.7, 0.8)
    _, log = drive(draw, car, f"battery.cells.{cell}.{by}={scale:.3f}")
    for share in (0.0, *(10 ** draw.random.uniform(-3.5, -1.5) for _ in range(3))):
        answer, said = explained(tmp_path, lost(draw, log, CURRENT, share), model=car)
        found = [(c["name"], c["parameters"]["cell"]["value"]) for c in answer["causes"] if "cell" in c["parameters"]]
        assert found == [("weak_cell", cell)], (cell, by, scale, share, said)


def test_a_weak_cell_is_found_in_a_table_beside_a_reference(tmp_path):
    """What a reference leaves is what its rows make of its cells: steps of a load, no error of the model."""
    draw = Draw("weak beside reference")
    car = own_car(draw, tmp_path, least_parallel=5)
    cell, scale = draw.random.randint(1, 60), draw.random.uniform(0.65, 0.78)
    logs = []
    for k, keys in enumerate(((f"battery.cells.{cell}.capacity_scale={scale:.3f}",), ())):
        (tmp_path / str(k)).mkdir()
        logs.append(drive(draw, car, *keys)[1].rename(tmp_path / str(k) / "drive.log"))
    for pack in (True, False):
        weak, reference = (table_of_frames(log, log.parent, 0.1, False, True, pack) for log in logs)
        answer, said = explained(tmp_path, weak, "--reference", reference, model=car)
        found = {(name, c["parameters"]["cell"]["value"]) for c in answer["causes"] if "cell" in c["parameters"]
                 for name in (c["name"], *c["equivalent_to"])}
        assert ("weak_cell", cell) in found, (cell, scale, pack, said)


def test_power_in_rows_far_apart_needs_the_motors_speed(tmp_path):
    """Two rows a second, the motor's current and the car's speed: a wheel that spun in between is no load."""
    draw = Draw("seldom power")
    car = own_car(draw, tmp_path)
    log, _ = drive(draw, car)
    names, rows = rows_of(log)
    plain = {"time_s": "time_s", "pack_current_a": "Pack Current [A]", "pack_voltage_v": "Pack Voltage [V]",
             "phase_current_a": "Motor Current [A]", "speed_mps": "Speed [m/s]"}
    columns = [names.index(name) for name in plain]
    table = write(tmp_path / "seldom.csv", list(plain.values()), [[row[k] for k in columns] for row in rows[::5]])
    answer, said = explained(tmp_path, table, model=car)
    assert answer["verdict"] == "no_discrepancy", said


@pytest.mark.parametrize("every_s", [0.2, 1.0])
def test_a_pedal_that_limits_cut_is_no_error_beside_a_reference(tmp_path, every_s):
    """A small pack gives less than the foot asks; a reference of another course tells how well the rest is known."""
    draw = Draw(f"cut{every_s:g}")
    car = own_car(draw, tmp_path, least_parallel=2)
    tables = []
    for k in range(2):
        folder = tmp_path / str(k)
        folder.mkdir()
        tables.append(table_of_frames(drive(draw, car)[1], folder, every_s))
    answer, said = explained(tmp_path, tables[0], "--reference", tables[1], model=car)
    assert answer["verdict"] == "no_discrepancy", said


@pytest.mark.parametrize("every_s", [0.25, 1.0])
def test_beside_a_reference_a_resistance_in_rows_far_apart_has_no_wrong_name(tmp_path, every_s):
    """Cells alone, of other times than the current, say not what heats them: a resistance was named as air 10 K warmer,
    a heat capacity, an entropy. With the pack's voltage, four times a second, it is found."""
    draw = Draw(f"far apart{every_s:g}")
    car = own_car(draw, tmp_path, least_parallel=2)
    more = draw.random.uniform(0.003, 0.006)
    logs = []
    for k, keys in enumerate(((), (), (f"cell.effects.series_ohm={more:.5f}",))):
        (tmp_path / str(k)).mkdir()
        logs.append(drive(draw, car, *keys)[1].rename(tmp_path / str(k) / "drive.log"))
    for cells, pack in ((False, True), (True, True), (True, False)):
        sound, reference, wrong = (table_of_frames(log, log.parent, every_s, False, cells, pack) for log in logs)
        answer, said = explained(tmp_path, sound, "--reference", reference, model=car)
        assert answer["verdict"] == "no_discrepancy", (cells, pack, said)
        answer, said = explained(tmp_path, wrong, "--reference", reference, model=car)
        sets = [[c["name"], *c["equivalent_to"]] for c in answer["causes"]] + (answer.get("alternatives") or [])
        named = {name for one in sets for name in one}
        assert not named or named & {"series_resistance", "contact_resistance"}, (cells, pack, more, said)
        assert named or not pack or every_s > 0.25, (cells, more, said)


def test_a_resistance_is_found_in_what_decode_writes(tmp_path):
    """Rows of 0.1 s hide five millivolts of some cars, not a third of a resistance."""
    draw = Draw("decoded resistance")
    car = own_car(draw, tmp_path)
    more = draw.random.uniform(0.003, 0.006)
    _, log = drive(draw, car, f"cell.effects.series_ohm={more:.5f}")
    answer, said = explained(tmp_path, table_of_frames(log, tmp_path, 0.1), model=car)
    named = {name for cause in answer["causes"] for name in (cause["name"], *cause["equivalent_to"])}
    others = {name for names in answer.get("alternatives", ()) for name in names}
    assert answer["verdict"] in ("named", "ambiguous"), (more, said)
    assert named | others >= {"series_resistance"}, (more, said)


def test_cells_a_current_and_a_stamp_of_time_are_enough(tmp_path):
    """No unit, no voltage of the pack; seconds since 1970, or milliseconds."""
    draw = Draw("own cells")
    car = own_car(draw, tmp_path)
    log, _ = drive(draw, car)
    names, rows = rows_of(log)
    cells = [name for name in names if name.startswith("cell_") and name.endswith("_voltage_v")]
    begin, per_second = draw.random.uniform(1.4e9, 1.9e9), draw.random.choice((1.0, 1e3))
    columns = [names.index(name) for name in ("time_s", "pack_current_a", *cells)]
    table = [[row[k] for k in columns] + [AIR] for row in rows]
    for row in table:
        row[0] = f"{(begin + float(row[0])) * per_second:.3f}"
        row[2:-1] = (f"{float(v) + draw.random.gauss(0.0, 1e-3):.4f}" for v in row[2:-1])  # no two read the same
    order = list(range(2, 2 + len(cells)))
    draw.random.shuffle(order)
    plain = write(tmp_path / "plain.csv", ["timestamp", "pack_current", *(f"cell{k - 1}" for k in order), "ambient"],
                  [[row[0], row[1], *(row[k] for k in order), row[-1]] for row in table])
    answer, said = explained(tmp_path, plain, model=car)
    assert "counts since 1970" in said and f"{len(cells) - 1} more like it" in said, said
    assert 'ambient is column "ambient"' in said, said
    assert answer["verdict"] == "no_discrepancy", said


# The kept draw was told as +1.10 mV/K of +0.82: the temperature of the cells was that of the model without the heat.
@pytest.mark.parametrize("label", ("cold21", None))
def test_reversible_heat_of_a_cold_pack_has_its_size(tmp_path, label):
    draw = Draw(label, seed=21) if label else Draw("cold")
    uniform, cells = draw.random.uniform, draw.random.randint(84, 108)
    air, kept = uniform(2.0, 14.0), draw.random.choice(("sony_vtc6", "molicel_p45b", "samsung_30q"))
    entropy = draw.random.choice((-1.0, 1.0)) * uniform(4e-4, 9e-4)
    (tmp_path / "car.toml").write_text(
        f'name = "car"\nbase = "vtm16e"\n[battery]\ncell = "{kept}"\ncells_in_series = {cells}\n'
        f"cells_in_parallel = {draw.random.randint(5, 7)}\n[environment]\nambient_c = {air:.1f}\n"
        f"[sensors]\ntemperature_count = {-(-cells // 4)}\n")

    def driven(name, *keys):
        log = tmp_path / f"{name}.log"
        run("endurance", "--vehicle", tmp_path / "car.toml", "--laps", 6, "--seed", draw.random.randrange(2**31),
            "--candump", log, "--set", f"battery.initial_soc={uniform(0.6, 0.95):.3f}",
            f"battery.initial_temperature_c={air + uniform(1.0, 4.0):.2f}",
            f"driver.grip_use={uniform(0.86, 0.97):.3f}", *keys)
        return log

    sound = driven("sound")
    answer, said = explained(tmp_path, driven("drive", f"cell.effects.entropy_v_per_k={entropy:.7f}"), "--reference",
                             sound, model=tmp_path / "car.toml")
    found = {cause["name"]: cause["parameters"] for cause in answer["causes"]}
    assert "entropic_heat" in found, (entropy, said)
    assert found["entropic_heat"]["entropy_v_per_k"]["value"] == pytest.approx(entropy, rel=0.2), (entropy, said)
