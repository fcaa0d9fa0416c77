# SPDX-License-Identifier: Apache-2.0
"""voltlap identify as its users meet it, on tables of the virtual bench: methods, several cells, messages."""
import json
import math
import os
import pathlib
import random
import re
import subprocess
import tomllib

import pytest

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
METHODS = ["ipo", "fpo", "ilo", "flo", "ffo"]


def voltlap(*arguments, code=0):
    run = subprocess.run([BINARY, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert run.returncode == code, run.stderr
    return run


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """A pulse test of four unequal cells in series, their tables and their truth."""
    folder = tmp_path_factory.mktemp("bench")
    voltlap("bench-test", "pulse_15", "--set", "test.temperature_c=30", "test.current_a=300",
            "instruments.systematic=false", "--out", folder, "--truth", folder / "truth.csv.gz")
    tables = sorted(folder.glob("*_cell*.csv"))
    return tables, json.loads((folder / "campaign.json").read_text())["tests"][0]["truth"]


@pytest.fixture(scope="module")
def compared(bench, tmp_path_factory):
    path = tmp_path_factory.mktemp("compared") / "all.json"
    run = voltlap("identify", bench[0][0], "--method", "all", "--json", path)
    return {row["method"]: row for row in json.loads(path.read_text())["methods"]}, run.stdout


def test_five_methods_and_the_full_fit_stand_beside_the_studys_table(compared):
    rows, text = compared
    assert list(rows) == [*METHODS, "full"]
    assert rows["ffo"]["study"] == {"mean_v2": 6.3e-6, "median_v2": 4.5e-6, "snr": 1834, "minutes_per_cell": 120}
    assert rows["full"]["study"] is None
    for words in ("reference study, 2016", " 190 ", " 1500 ", "mV2", "120 min", "noise of the voltage's instrument"):
        assert words in text


def test_pulses_fit_best_by_themselves_and_only_the_full_fit_fits_the_test(compared):
    rows, _ = compared
    assert rows["fpo"]["section_mean_v2"] < rows["ipo"]["section_mean_v2"]
    assert rows["fpo"]["section_mean_v2"] < rows["flo"]["section_mean_v2"] < rows["ilo"]["section_mean_v2"]
    for name in METHODS[:-1]:
        assert rows[name]["whole_mean_v2"] > 10 * rows["ffo"]["whole_mean_v2"]


def test_full_fit_sits_at_the_noise_of_the_instrument(compared):
    rows, _ = compared
    # Eight readings with 1.5 mV of noise in steps of 1.5 mV make a row.
    floor = (1.5e-3**2 + 1.5e-3**2 / 12) / 8
    assert rows["full"]["noise_floor_v2"] == pytest.approx(floor, rel=0.05)
    # Under load the noise of the current comes on top, through R0: 4 % in this test.
    assert rows["full"]["whole_mean_v2"] < 1.1 * floor


@pytest.mark.parametrize("method", ["ipo", "flo", "ffo"])
def test_each_method_gives_a_cell_file_that_validate_takes(bench, tmp_path, method):
    cell = tmp_path / "cell.toml"
    run = voltlap("identify", bench[0][0], "--method", method, "--out", cell, "--json", tmp_path / "cell.json")
    voltlap("validate", cell, bench[0][0])
    r0 = json.loads((tmp_path / "cell.json").read_text())["tests"][0]["parameters"]["r0_ohm"]
    assert (r0["ci95_low"][0] is None) == (method != "ffo")
    assert ("no intervals" in run.stdout) == (method != "ffo")


def test_cells_in_series_give_a_mean_with_the_spread_of_the_truth(bench, tmp_path):
    tables, truth = bench
    run = voltlap("identify", *tables, "--out", tmp_path / "mean.toml", "--json", tmp_path / "mean.json")
    found = json.loads((tmp_path / "mean.json").read_text())
    assert "Mean of 4 cells" in run.stdout and "Spread between 4 cells" in run.stdout
    assert "# r0_ohm:" in (tmp_path / "mean.toml").read_text()
    assert len(found["cells"]) == 4

    def spread(values):
        mean = sum(values) / len(values)
        return (sum((v - mean) ** 2 for v in values) / (len(values) - 1)) ** 0.5 / mean

    assert found["capacity_spread_ah"] / found["capacity_ah"] == pytest.approx(spread(truth["capacity_ah"]), abs=0.004)
    assert found["tests"][0]["spread"]["r0_ohm"][8] == pytest.approx(spread(truth["resistance_scale"]), abs=0.005)
    voltlap("validate", tmp_path / "mean.toml", tables[1])


def test_cell_flag_says_whose_the_files_are(bench, tmp_path):
    one, two = bench[0][:2]
    run = voltlap("identify", "--cell", "a", one, "--cell", "b", two)
    assert "a: Capacity" in run.stdout and "Mean of 2 cells" in run.stdout


@pytest.mark.parametrize("flags, words", [(["--method", "fpq"], "fpo"),
                                          (["--method", "ipo", "--rc", "1"], "two branches"),
                                          (["--method", "ilo", "--blocks", "60:even"], "--blocks"),
                                          (["--method", "all", "--ocv", "aesc_e5_2p"], "--ocv")])
def test_what_methods_cannot_do_is_refused(bench, flags, words):
    assert words in voltlap("identify", bench[0][0], *flags, code=2).stderr


def test_drive_is_refused_by_a_pulse_method(tmp_path):
    table = tmp_path / "drive.csv"
    rows = [f"{t},{20 + 15 * ((t // 7) % 3)},{4.1 - 2e-4 * t - 1e-3 * (20 + 15 * ((t // 7) % 3))}" for t in range(3000)]
    table.write_text("time_s,current_a,voltage_v\n0,0,4.15\n" + "\n".join(rows[1:]) + "\n")
    assert "pulses with rests" in voltlap("identify", table, "--method", "ipo", code=2).stderr


def test_a_plain_circuit_is_written_with_one_value_and_without_a_slope(bench, tmp_path):
    cell = tmp_path / "plain.toml"
    voltlap("identify", bench[0][0], "--rc", 2, "--constant", "--out", cell)
    file = tomllib.loads(cell.read_text())
    for name in ("r0", "r1", "r2", "tau1", "tau2"):
        assert "per_kelvin" not in file[name]
        assert max(file[name]["value"]) == pytest.approx(min(file[name]["value"]), rel=1e-3)
    assert "A plain circuit" in cell.read_text()
    said = voltlap("identify", bench[0][0], "--constant", "--method", "ipo", code=2).stderr
    assert "--constant" in said and "--method" in said


def test_the_hold_that_is_declared_is_the_one_that_is_used(bench, tmp_path):
    # The bench's rows say what has flowed since the row before; told otherwise, a second of both lags goes to R0:
    # 0.4 mOhm / 64 s + 0.8 mOhm / 616 s make 7.5 uOhm.
    found = {}
    for hold in ("previous", "next"):
        path = tmp_path / f"{hold}.json"
        voltlap("identify", bench[0][0], "--rc", "2", "--hold", hold, "--json", path)
        found[hold] = json.loads(path.read_text())["tests"][0]
        assert found[hold]["files"][0]["current_hold_from"] == "the command"
    assert found["next"]["files"][0]["current_hold"] == "of each row held since the one before"
    assert found["previous"]["files"][0]["current_hold"] == "of each row held until the next"
    r0 = {hold: test["parameters"]["r0_ohm"]["value"][8] for hold, test in found.items()}
    assert r0["previous"] - r0["next"] == pytest.approx(7.5e-6, rel=0.3)


def test_errors_of_the_instruments_that_are_declared_widen_the_intervals(bench, tmp_path):
    def width(*flags):
        path = tmp_path / "width.json"
        voltlap("identify", bench[0][0], "--rc", "2", *flags, "--json", path)
        r0 = json.loads(path.read_text())["tests"][0]["parameters"]["r0_ohm"]
        return r0["ci95_high"][8] / r0["ci95_low"][8] - 1.0

    # 2 % of the current is 2 % of every resistance: +- 2 % and more at 95 %, beside what a hold that is assumed adds.
    assert width("--current-gain-error", "0.02") ** 2 - width() ** 2 > 0.04 ** 2
    assert width() < 0.08


def test_what_was_told_of_the_cell_is_what_an_endurance_drives_with(bench, tmp_path):
    seed = random.randrange(2**32)
    draw = random.Random(seed)
    edges = [round(draw.uniform(low, high), 1) for low, high in ((150, 300), (100, 250), (6, 30))]
    mass, heat = round(1e-6 * edges[0] * edges[1] * edges[2] * draw.uniform(1.8, 2.8), 4), draw.randrange(700, 1200)
    surface = 2e-6 * (edges[0] * edges[1] + edges[1] * edges[2] + edges[2] * edges[0])
    cell, found, run, page = (tmp_path / name for name in ("cell.toml", "cell.json", "run.json", "cell.html"))
    said = voltlap("identify", bench[0][0], "--rc", 1, "--mass", mass, "--size", "x".join(map(str, edges)),
                   "--heat-capacity", heat, "--out", cell, "--json", found, "--report", page).stdout
    voltlap("endurance", "--laps", 1, "--cells", "representative", "--set", f"battery.cell={cell}", "--json", run)
    told = {"mass_kg": mass, "surface_area_m2": surface, "heat_capacity_j_per_kg_k": heat}
    driven = json.loads(run.read_text())["parameters"]
    facts = {fact["key"]: fact for fact in json.loads(found.read_text())["facts"]}
    file = tomllib.loads(cell.read_text())
    for key, value in told.items():
        for where in (file[key], facts[key]["value"], driven[f"cell.{key}"]):
            assert where == pytest.approx(value, rel=1e-5), f"seed {seed}: {key}"
        assert facts[key]["origin"] == "told"
    origins = {"capacity_ah": "measured", "convection_w_per_m2_k": "assumed", "voltage_max_v": "measured"}
    assert {key: facts[key]["origin"] for key in origins} == origins
    assert "told      --mass" in said and "assumed   as aesc_e5_2p" in said
    rows = re.search('<table class="plain" id="facts">(.*?)</table>', page.read_text(), re.S)[1]
    assert "--mass" in rows and "--heat-capacity" in rows and "as aesc_e5_2p" in rows


def test_a_small_cell_is_assumed_to_be_round_and_an_impossible_one_is_said(bench, tmp_path):
    # The bench's cell, as if 17 were in parallel behind its current: 3.3 Ah each.
    cell = tmp_path / "cell.toml"
    arguments = ("identify", bench[0][0], "--rc", 1, "--cells-in-parallel", 17, "--out", cell)
    said = voltlap(*arguments).stdout
    assert "18650, a cylinder" in said and "mostly a 18650" in said and "Implausible" not in said
    assert tomllib.loads(cell.read_text())["mass_kg"] == pytest.approx(0.0464, abs=1e-4)
    said = voltlap(*arguments, "--mass", 0.46, "--size", "18650").stdout
    assert "kg/m3; cells have" in said and "Implausible" in cell.read_text()


@pytest.mark.parametrize("flags, words", [(("--mass", 70), "kg, not g"), (("--mass", 0), "kg, not g"),
                                          (("--size", "0.018x0.065"), "Millimetres, not metres"),
                                          (("--size", "127x42"), "a pouch or can has three numbers"),
                                          (("--heat-capacity", 50), "that of the whole cell is this times its mass")])
def test_a_cell_that_cannot_be_is_refused_before_anything_is_computed(bench, tmp_path, flags, words):
    run = voltlap("identify", bench[0][0], *flags, "--out", tmp_path / "cell.toml", code=2)
    assert words in run.stderr and "smoothness" not in run.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_temperature_column_that_is_blank_is_no_temperature(bench, tmp_path):
    lines = bench[0][0].read_text().splitlines()
    head, *rows = (line for line in lines if not line.startswith("#"))

    def without(*names):
        at = [head.split(",").index(name) for name in names]
        blank = [",".join("" if k in at else field for k, field in enumerate(row.split(","))) for row in rows]
        (tmp_path / "blank.csv").write_text("\n".join([head, *blank]) + "\n")

    without("temperature_c")
    said = voltlap("identify", tmp_path / "blank.csv", "--rc", 1).stdout
    assert "no temperature of the cell: it began as warm as the air, " in said
    without("temperature_c", "ambient_c")
    said = voltlap("identify", tmp_path / "blank.csv", "--rc", 1).stdout
    assert "no temperature: 25 degC assumed (--temperature)" in said
    assert "25 degC    assumed   neither recorded nor told (--temperature)" in said
    said = voltlap("identify", "--temperature", 31, tmp_path / "blank.csv", "--rc", 1).stdout
    assert "31 degC    measured" in said


def drive(path, *, ah=9.0, start_soc=0.9, rest_s=900, scale=(1.0, 1.0), extra=lambda t: 0.0):
    """A drive of a cell of 30 Ah with rests at both ends, written as a table; `scale` of current and voltage."""
    def ocv(soc):
        return 3.3 + 0.85 * soc - 0.2 * math.exp(-20 * soc)

    rows, soc, slow, t = ["time_s,current_a,voltage_v"], start_soc, 0.0, 0
    pulls = [75.0 if k // 20 % 2 == 0 else 15.0 for k in range(round(3600 * ah / 45))]
    for current in [0.0] * rest_s + pulls + [0.0] * rest_s:
        soc -= current / 3600 / 30
        slow += (1e-3 * current - slow) / 40
        volts = ocv(soc) - 1.5e-3 * current - slow + extra(t)
        rows.append(f"{t},{current * scale[0]:.6g},{volts * scale[1]:.6f}")
        t += 1
    path.write_text("\n".join(rows) + "\n")
    return path, [(k / 40, ocv(k / 40)) for k in range(41)]


def test_what_a_drive_drew_is_called_so_and_the_true_capacity_can_be_told(tmp_path):
    table, _ = drive(tmp_path / "drive.csv")
    found = {}
    for name, flags in (("drawn", []), ("told", ["--capacity", 30])):
        said = voltlap("identify", table, "--rc", 1, *flags, "--out", tmp_path / f"{name}.toml").stdout
        voltlap("identify", table, "--rc", 1, *flags, "--json", tmp_path / f"{name}.json")
        found[name] = json.loads((tmp_path / f"{name}.json").read_text()), said
    assert found["drawn"][0]["capacity_from"] == "drawn only" and found["told"][0]["capacity_from"] == "told"
    assert found["drawn"][0]["capacity_ah"] == pytest.approx(9.0, rel=0.01)
    assert found["told"][0]["capacity_ah"] == 30
    assert "only what the recordings drew" in found["drawn"][1] and "--capacity AH" in found["drawn"][1]
    assert re.search(r"capacity +30 Ah +told +--capacity", found["told"][1])
    assert tomllib.loads((tmp_path / "told.toml").read_text())["capacity_ah"] == 30
    assert found["drawn"][0]["capacity_ci95_ah"] is None


def test_two_rests_and_an_ocv_tell_the_capacity_with_its_interval(tmp_path):
    table, ocv = drive(tmp_path / "drive.csv", ah=12.0)
    cell = tmp_path / "like.toml"
    voltlap("identify", table, "--capacity", 30, "--rc", 1, "--out", cell)
    text = re.sub(r"(?s)\[ocv\].*?\n\[r0\]", "[ocv]\nsoc = {}\nvoltage_v = {}\n\n[r0]".format(
        [soc for soc, _ in ocv], [round(volts, 5) for _, volts in ocv]), cell.read_text())
    cell.write_text(text.replace("capacity_ah = 30.0", "capacity_ah = 25.0"))
    voltlap("identify", table, "--rc", 1, "--ocv", cell, "--json", tmp_path / "found.json")
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["capacity_from"] == "rests and OCV"
    assert 0 < found["capacity_ci95_ah"] < 3 and abs(found["capacity_ah"] - 30) < found["capacity_ci95_ah"]
    assert found["tests"][0]["files"][0]["soc_anchor"] == pytest.approx(0.9, abs=0.02)


def test_the_rms_that_is_printed_is_that_of_the_file_that_was_written(tmp_path):
    table, _ = drive(tmp_path / "drive.csv", rest_s=40)  # short rests: validate counts all of it
    cell = tmp_path / "cell.toml"
    said = voltlap("identify", table, "--capacity", 30, "--temperature", 25, "--out", cell).stdout
    voltlap("identify", table, "--capacity", 30, "--temperature", 25, "--json", tmp_path / "cell.json")
    voltlap("validate", cell, table, "--json", tmp_path / "validated.json")
    file = json.loads((tmp_path / "cell.json").read_text())["tests"][0]["files"][0]
    validated = json.loads((tmp_path / "validated.json").read_text())["files"][0]
    assert f"RMS {1e3 * file['rms_v']:.2f} mV over all rows" in said and "by the cell file read back" in said
    assert file["rms_v"] != file["fit_rms_v"]
    assert file["rms_v"] == pytest.approx(validated["rms_v"], rel=0.1, abs=2e-4)


def test_a_model_that_misses_its_recording_is_not_written(tmp_path):
    # The voltage of another battery goes up and down by 0.8 V every two minutes.
    table, _ = drive(tmp_path / "drive.csv", extra=lambda t: 0.4 if t // 120 % 2 else -0.4)
    run = subprocess.run([BINARY, "identify", table, "--rc", "1", "--out", tmp_path / "cell.toml",
                          "--json", tmp_path / "cell.json"], capture_output=True, text=True, timeout=300)
    assert run.returncode == 2, run.stdout
    assert "drive.csv" in run.stderr and "Nothing was written" in run.stderr
    assert sorted(file.name for file in tmp_path.iterdir()) == ["drive.csv"]


def test_the_count_that_was_forgotten_is_named(tmp_path):
    table, _ = drive(tmp_path / "drive.csv")
    cell = tmp_path / "cell.toml"
    voltlap("identify", table, "--capacity", 30, "--out", cell)
    parallel, _ = drive(tmp_path / "parallel.csv", scale=(8.0, 1.0))
    said = voltlap("validate", cell, parallel).stdout
    assert "hint" in said and "--cells-in-parallel 8 " in said
    assert "hint" not in voltlap("validate", cell, parallel, "--cells-in-parallel", 8).stdout
    series, _ = drive(tmp_path / "series.csv", scale=(1.0, 4.0))
    assert "--cells-in-series 4" in voltlap("identify", series, code=2).stderr


def test_no_number_is_shown_with_an_exponent_or_a_minus_before_a_zero(tmp_path):
    table, _ = drive(tmp_path / "drive.csv")
    said = voltlap("identify", table, "--rc", 2).stdout
    assert not re.search(r"\d[eE][+-]\d", said) and not re.search(r"-0\.?0*(?![\d.])", said)
    assert "(assumed)" in said and re.search(r"R[^\n]*assumed", said)


def test_a_flag_behind_the_files_is_of_all_and_one_more_behind_them_of_none(bench, tmp_path):
    table, path = bench[0][0], tmp_path / "cell.json"
    voltlap("identify", table, "--window", "0:4000", "--json", path)
    (recording,) = json.loads(path.read_text())["tests"][0]["files"]
    assert any("window" in repair for repair in recording["repairs"])
    run = voltlap("identify", "--window", "0:4000", table, "--window", "0:5000", code=2)
    assert "--window: found no file after it" in run.stderr
