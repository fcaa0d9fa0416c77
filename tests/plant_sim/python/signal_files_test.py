# SPDX-License-Identifier: Apache-2.0
"""Decoded signals as MF4, MCAP and Parquet, read back by the libraries that a user has: the same numbers at the same
times, with names, units and value texts."""
import json
import math
import random
import sys
from pathlib import Path

import pytest

for package in ("asammdf", "mcap", "pandas", "pyarrow", "google.protobuf"):
    pytest.importorskip(package, reason="needs toolchain/requirements/logs.txt")
import asammdf  # noqa: E402
import mcap.reader  # noqa: E402
import numpy as np  # noqa: E402
import pandas  # noqa: E402
import pyarrow.parquet as parquet  # noqa: E402
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory  # noqa: E402
from recordings import SEED, told  # noqa: E402

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "plant_sim" / "python"))
from voltlap_logs import write_signals  # noqa: E402

ORIGIN_S = 1763828454.25
DRAWS = range(4)
TEXTS = {"0": "off", "1": "precharge", "2": "on"}


def drawn_column(draw, group, k, rows):
    values = np.round(draw.normal(0, 100, rows), 2)
    column = {"name": f"Signal{group}_{k}", "unit": "V", "comment": f"number {k}", "choices": None}
    kind = draw.integers(0, 5)
    if kind == 0:
        values[draw.random(rows) < 0.5] = np.nan
    elif kind == 1:
        values, column["choices"], column["unit"] = draw.integers(0, 3, rows).astype(float), TEXTS, ""
    elif kind == 2:  # a value without a text
        values, column["choices"] = draw.integers(0, 9, rows).astype(float), TEXTS
    elif kind == 3:
        column["name"], column["unit"] = "Counter", ""
    return column, values


def drawn_folder(folder, seed, groups=6):
    """The manifest, and what its files hold: {(group, column): values}, {group: times}."""
    draw, values, times, described = np.random.default_rng([SEED, seed]), {}, {}, []
    folder.mkdir()
    for group in range(groups):
        rows = int(draw.choice([0, 1, 50, 700]))
        times[group] = np.sort(np.round(draw.uniform(0, 60, rows), 6))
        times[group].astype("<f8").tofile(folder / f"{group}.time.f64")
        columns = []
        for k in range(int(draw.integers(1, 20))):
            column, values[group, k] = drawn_column(draw, group, k, rows)
            if column["name"] in [other["name"] for other in columns]:
                column["name"] = f"Signal{group}_{k}"
            columns.append(column | {"file": f"{group}.{k}.f64"})
            values[group, k].astype("<f8").tofile(folder / f"{group}.{k}.f64")
        described.append({"name": f"Frame{group // 2 * 2}", "bus": f"can{group % 2}", "id": 256 + group, "rows": rows,
                          "time": f"{group}.time.f64", "columns": columns})
    if not sum(len(t) for t in times.values()):
        return drawn_folder(folder.with_name(folder.name + "_again"), seed + 1000, groups)
    manifest = {"origin_s": ORIGIN_S, "source": "drive.log", "groups": described}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder, manifest, values, times


def written(key, tmp_path, seed):
    folder, manifest, values, times = drawn_folder(tmp_path / "signals", seed)
    out = tmp_path / f"out.{key}"
    assert write_signals.main(["--format", key, str(folder), str(out)]) == 0
    present = [(k, group) for k, group in enumerate(manifest["groups"]) if group["rows"]]
    return out, present, values, times


def unique_names(present):
    """{(group, column): name}: the frame, or bus and frame, before a signal that is not alone."""
    signals = [column["name"] for _, group in present for column in group["columns"]]
    frames = [group["name"] for _, group in present]
    names = {}
    for k, group in present:
        frame = group["name"] if frames.count(group["name"]) == 1 else f"{group['bus']}.{group['name']}"
        for c, column in enumerate(group["columns"]):
            names[k, c] = column["name"] if signals.count(column["name"]) == 1 else f"{frame}.{column['name']}"
    return names


@pytest.mark.parametrize("draw", DRAWS)
def test_mf4_has_the_numbers_units_and_texts(draw, tmp_path):
    out, present, values, times = written("mf4", tmp_path, draw)
    names = unique_names(present)
    with asammdf.MDF(out) as file:
        assert file.header.abs_time == round(ORIGIN_S * 1e9)
        assert len(file.groups) == len(present)
        for at, (k, group) in enumerate(present):
            for c, column in enumerate(group["columns"]):
                signal = file.get(names[k, c], group=at, raw=True)
                there = ~np.isnan(values[k, c])
                assert np.array_equal(signal.samples, values[k, c][there]), told(draw)
                assert np.array_equal(signal.timestamps, times[k][there]), told(draw)
                assert (signal.unit, signal.comment.split(" (")[0]) == (column["unit"], column["comment"])
                if column["choices"]:
                    known = set(values[k, c]) <= {0.0, 1.0, 2.0}
                    shown = file.get(names[k, c], group=at).samples
                    assert [text.decode() for text in shown] == [TEXTS[f"{v:g}"] for v in values[k, c]] if known else (
                        np.array_equal(shown, values[k, c]) and "precharge" in signal.comment)


def protobuf_class(schema):
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name))


@pytest.mark.parametrize("draw", DRAWS)
def test_mcap_has_a_message_for_each_frame_in_order(draw, tmp_path):
    out, present, values, times = written("mcap", tmp_path, draw)
    seen, last, classes = {k: 0 for k, _ in present}, 0, {}
    of_topic = {f"/{group['bus']}/{group['name']}": (k, group) for k, group in present}
    with out.open("rb") as file:
        reader = mcap.reader.make_reader(file)
        assert reader.get_summary().statistics.message_count == sum(group["rows"] for _, group in present)
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            k, group = of_topic[channel.topic]
            row, seen[k] = seen[k], seen[k] + 1
            assert last <= message.log_time == round(ORIGIN_S * 1e9) + round(times[k][row] * 1e9), told(draw)
            last = message.log_time
            kind = classes.setdefault(schema.id, protobuf_class(schema))
            decoded = kind.FromString(message.data)
            for c, column in enumerate(group["columns"]):
                got, expected = getattr(decoded, column["name"]), values[k, c][row]
                assert got == expected or math.isnan(got) and math.isnan(expected), told(draw)
                assert channel.metadata.get(f"{column['name']}.unit", "") == column["unit"]
        assert next(reader.iter_metadata()).metadata["source"] == "drive.log"
    assert seen == {k: group["rows"] for k, group in present}


@pytest.mark.parametrize("draw", DRAWS)
def test_parquet_is_a_frame_a_row_for_pandas(draw, tmp_path):
    out, present, values, times = written("parquet", tmp_path, draw)
    names = unique_names(present)
    table, schema = pandas.read_parquet(out), parquet.read_schema(out)
    assert table["time_s"].is_monotonic_increasing
    assert len(table) == sum(group["rows"] for _, group in present)
    for k, group in present:
        own = table[(table["frame"] == group["name"]) & (table["bus"] == group["bus"])]
        assert np.allclose(own["time_s"], times[k] + ORIGIN_S, rtol=0, atol=1e-6), told(draw)
        for c, column in enumerate(group["columns"]):
            assert np.array_equal(own[names[k, c]].to_numpy(float), values[k, c], equal_nan=True), told(draw)
            assert table[names[k, c]].count() == np.count_nonzero(~np.isnan(values[k, c])), "null in other frames"
            assert schema.field(names[k, c]).metadata.get(b"unit", b"").decode() == column["unit"]


def test_names_that_protobuf_does_not_take_and_many_columns(tmp_path):
    folder = tmp_path / "signals"
    folder.mkdir()
    names = ["1st cell", "Cell-1", "cell_1", "Spannung Ö", *(f"c{k}" for k in range(2100))]
    columns = []
    for k, name in enumerate(names):
        np.array([k + 0.5]).tofile(folder / f"{k}.f64")
        columns.append({"name": name, "unit": "", "comment": "", "file": f"{k}.f64", "choices": None})
    np.array([1.0]).tofile(folder / "t.f64")
    (folder / "manifest.json").write_text(json.dumps({"origin_s": -5.0, "source": "", "groups": [
        {"name": "Zellen/1", "bus": "", "id": 1, "rows": 1, "time": "t.f64", "columns": columns}]}))
    for key in ("mcap", "mf4", "parquet"):
        assert write_signals.main(["--format", key, str(folder), str(tmp_path / f"a.{key}")]) == 0
    with (tmp_path / "a.mcap").open("rb") as file:
        schema, _, message = next(mcap.reader.make_reader(file).iter_messages())
    decoded = protobuf_class(schema).FromString(message.data)
    fields = [field.name for field in type(decoded).DESCRIPTOR.fields]
    assert fields[:4] == ["_1st_cell", "Cell_1", "cell_1_2", "Spannung__"] and message.log_time == 0
    assert [getattr(decoded, name) for name in fields] == [k + 0.5 for k in range(len(names))]


def damage_manifest(folder):
    (folder / "manifest.json").write_text("{")


def damage_field(folder):
    manifest = json.loads((folder / "manifest.json").read_text())
    del manifest["groups"][0]["rows"]
    (folder / "manifest.json").write_text(json.dumps(manifest))


def damage_column(folder):
    manifest = json.loads((folder / "manifest.json").read_text())
    group = next(group for group in manifest["groups"] if group["rows"])
    (folder / group["columns"][0]["file"]).write_bytes(b"12345")


def damage_rows(folder):
    (folder / "manifest.json").write_text(json.dumps({"origin_s": 0, "source": "a", "groups": []}))


@pytest.mark.parametrize("key", ["mf4", "mcap", "parquet"])
@pytest.mark.parametrize("damage", [damage_manifest, damage_field, damage_column, damage_rows])
def test_a_folder_that_is_not_right_is_told_and_the_old_file_stays(damage, key, tmp_path, capsys):
    folder = drawn_folder(tmp_path / "signals", random.Random(SEED).randrange(1000))[0]
    damage(folder)
    out = tmp_path / f"out.{key}"
    out.write_text("old")
    assert write_signals.main(["--format", key, str(folder), str(out)]) == 2
    words = capsys.readouterr().err
    assert len(words.splitlines()) == 1 and str(folder) in words
    assert out.read_text() == "old" and not list(tmp_path.glob(".*"))
