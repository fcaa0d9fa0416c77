# SPDX-License-Identifier: Apache-2.0
"""Measurement files as tables: what a group holds comes out as CSV, number for number."""
import csv
import gzip
import io
import json
import os
import sys
from pathlib import Path

import pytest

for package in ("asammdf", "pandas", "pyarrow"):
    pytest.importorskip(package, reason="needs toolchain/requirements/logs.txt")
import asammdf  # noqa: E402
import numpy as np  # noqa: E402
import pandas  # noqa: E402

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "plant_sim" / "python"))
from voltlap_logs import tables, write_signals  # noqa: E402

SEED = int(os.environ.get("VOLTLAP_TEST_SEED", "1"))


def run(capsys, *arguments):
    capsys.readouterr()
    code = tables.main([str(argument) for argument in arguments])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def columns_of(text):
    header, *rows = csv.reader(io.StringIO(text))
    return {name: [row[k] for row in rows] for k, name in enumerate(header)}


def numbers(cells):
    return [float(cell) if cell else np.nan for cell in cells]


@pytest.fixture(params=["mf4", "parquet"])
def run_file(request, tmp_path):
    """A run as two tables of their own rates, with a gap and value texts, and the numbers in it."""
    draw, folder, held, groups = np.random.default_rng(SEED), tmp_path / "signals", {}, []
    folder.mkdir()
    for name, rows in (("Pack", 500), ("Motor", 70)):
        held[name] = {"time_s": np.cumsum(draw.uniform(0.001, 0.1, rows)), "voltage_v": draw.normal(400, 10, rows),
                      "Current [A]": draw.normal(0, 50, rows), "State": draw.integers(0, 2, rows).astype(float)}
        held[name]["Current [A]"][3:9] = np.nan
        for k, values in enumerate(held[name].values()):
            values.tofile(folder / f"{name}{k}.f64")
        described = [("voltage_v", "V", None), ("Current", "A", None), ("State", "", {"0": "off", "1": "on"})]
        groups.append({"name": name, "bus": "can0", "id": 1, "rows": rows, "time": f"{name}0.f64", "columns": [
            {"name": f"{name}_{column}" if column == "State" else column, "unit": unit, "comment": "", "choices": texts,
             "file": f"{name}{k}.f64"} for k, (column, unit, texts) in enumerate(described, 1)]})
    (folder / "manifest.json").write_text(json.dumps({"origin_s": 0.0, "source": "run", "groups": groups}))
    out = tmp_path / f"run.{request.param}"
    assert write_signals.main(["--format", request.param, str(folder), str(out)]) == 0
    return out, held


def test_each_group_is_a_table_with_the_numbers_that_were_written(run_file, capsys):
    path, held = run_file
    for name, expected in held.items():
        code, out, err = run(capsys, "--csv", name, path)
        assert (code, err) == (0, ""), f"VOLTLAP_TEST_SEED={SEED}"
        got = columns_of(out)
        assert list(got) == ["time_s", f"{name}.voltage_v", f"{name}.Current [A]", f"{name}_State"]
        for cells, values in zip(got.values(), expected.values(), strict=True):
            assert np.array_equal(numbers(cells), values, equal_nan=True), f"VOLTLAP_TEST_SEED={SEED}"


def test_the_list_names_groups_channels_and_units(run_file, capsys):
    path, held = run_file
    _, out, _ = run(capsys, path)
    assert "Pack: 500 rows" in out and "Motor: 70 rows" in out and "Pack.Current [A]" in out
    listed = json.loads(run(capsys, "--json", path)[1])
    assert {group["name"].split(".")[-1]: group["rows"] for group in listed["groups"]} == {"Pack": 500, "Motor": 70}
    code, _, err = run(capsys, "--csv", "Brake", path)
    assert code == 2 and "there is no such group" in err and "Motor" in err


def test_a_packed_file_gives_the_same_table(run_file, capsys, tmp_path):
    path, _ = run_file
    packed = tmp_path / "packed.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    assert run(capsys, "--csv", "Pack", packed) == run(capsys, "--csv", "Pack", path)


@pytest.mark.parametrize("version", ["4.10", "3.30"])
def test_scaled_signals_texts_and_strings_of_another_program(version, tmp_path, capsys):
    times = np.arange(5) / 10
    with asammdf.MDF(version=version) as file:
        file.append([
            asammdf.Signal(np.arange(5, dtype=np.int16), times, name="Speed", unit="km/h",
                           conversion={"a": 0.5, "b": 3.0}),
            asammdf.Signal(np.array([0, 1, 0, 1, 1], np.uint8), times, name="Gear", conversion={
                "val_0": 0, "text_0": b"neutral", "val_1": 1, "text_1": b"first", "default_addr": b""}),
            asammdf.Signal(np.array([b"a", b"b,c", b'"', b"", b"e"]), times, name="Note", encoding="utf-8")])
        file.save(tmp_path / "a.mdf", overwrite=True)
    path = next(tmp_path.iterdir())
    got = columns_of(run(capsys, "--csv", "0", path)[1])
    assert got["time_s"] == ["0", "0.1", "0.2", "0.3", "0.4"]
    assert got["Speed [km/h]"] == ["3", "3.5", "4", "4.5", "5"]
    assert got["Gear"] == ["0", "1", "0", "1", "1"]
    assert got["Note"] == ["a", "b,c", '"', "", "e"]


def test_a_parquet_of_pandas(tmp_path, capsys):
    frame = pandas.DataFrame({"t": pandas.to_datetime([1000, 2500], unit="ms"), "v": [1.5, np.nan], "n": [1, 2],
                              "name": ["a", "b,c"]})
    frame.to_parquet(tmp_path / "a.parquet")
    code, out, _ = run(capsys, "--csv", "a", tmp_path / "a.parquet")
    assert (code, out) == (0, 't [s],v,n,name\n1,1.5,1,a\n2.5,,2,"b,c"\n')


def test_what_holds_no_table_is_told(tmp_path, capsys):
    for name, content in (("a.mf4", b"MDF     4.10    " + bytes(300)), ("a.parquet", b"PAR1" + bytes(100)),
                          ("a.blf", b"LOGG" + bytes(200)), ("a.txt", b"hello\n"), ("a", b"")):
        (tmp_path / name).write_bytes(content)
        code, out, err = run(capsys, tmp_path / name)
        assert code == 2 and not out and len(err.splitlines()) == 1 and name in err
