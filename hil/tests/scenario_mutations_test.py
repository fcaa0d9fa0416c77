# SPDX-License-Identifier: Apache-2.0
"""Whatever becomes of a scenario file, it is read, and then runs, or its mistake is told with a line of the file."""
import copy
import os
import pathlib
import random
import re
import time

import pytest
import yaml

from synthetic_rig import act_out
from voltlap_hil.car import Car
from voltlap_hil.car_quantities import filled
from voltlap_hil.dbc import Dbc
from voltlap_hil.errors import InputError
from voltlap_hil.scenario_file import load

SHIPPED = sorted((pathlib.Path(__file__).resolve().parents[1] / "scenarios").glob("*.yaml"))
MUTATIONS_A_FILE = int(os.environ.get("VOLTLAP_SCENARIO_CHANGES", "16"))  # `voltlap fuzz` draws on and on
LONGEST_S = 2.0

AWKWARD = [
    None, True, False, "", " ", 0, -1, 1, 2, 7, 15, 16, 17, 63, 64, 255, 256, 65536, 10**9, -10**9, 10**40, 0.0, 0.5,
    2.0, -0.5, 1e300, float("nan"), float("inf"), float("-inf"), "0 ms", "10 ms", "-10 ms", "5 ms", "15 ms", "1e300 s",
    "100 min", "24 h", "99999999999 s", "9" * 400 + " s", "10", "ms", "100 GA", "0 %", "120 %", "-1 %", "0 A", "600 A",
    "1e9 A", "nan A", "-0.05 A", "0x001", "0x7E5", "0x800", "0x1FFFFFFF", "0x20000000", "0xZZ", "0x", "BMS", "PLANT",
    "MASTER", "Pedals", "CellVoltages", "Sync", "PackBroadcast", "BmsStatus", "BmsStatus.State", "invalid",
    "BmsStatus.State = Fault", "Sync.Tick > 3", "PackSensor.PackCurrent > 1e9 A",
    "InverterStatus.PhaseCurrent = 0.05 A", "VehicleIo.AirPlusAux > 1", "and", "= = =",
    "BmsStatus.Faults has MasterLost", "MST-001", "MST-020", "BMS-999", "ready_to_drive", "low_voltage", "pressed",
    "bms", "--laps", "--set", "--vehicle", "battery.initial_soc=2", "CellLost", "CellOffset", "BrakeLost", "ClearAll",
    "automatic", "\x00", "\ud800", "\x85", "\ufeff", "a" * 5000, "über", "!!python/none", "*a", "&a", "<<", [], {},
    [[]], [None], [[[]]], {"a": 1}, {"run": "10 ms"}, [{"run": "10 ms"}], {"within": "10 ms"}, ["Pedals", "BMS"],
    {None: None}]
NAMES = ["drop", "silence", "delay", "duplicate", "corrupt", "replay", "stuck_counter", "babble", "second_sender",
         "every", "by", "copies", "bit", "frames", "counter_ahead", "signals", "for", "within", "after", "condition",
         "from", "not_before", "during", "at_least", "message", "index", "value", "fault", "run", "kill", "clear",
         "wait", "send", "plant", "gateway", "driver", "start_up", "observe", "arguments", "behind_gateway", "always",
         "meanwhile", "<<"]
SCRAPS = [b"\t", b"\x00", b"\x07", b"\xff", b"\xe4", b"\xc3", b"[", b"]", b"{", b"}", b": ", b"- ", b"#", b"'", b'"',
          b"|", b">", b"&a ", b"*a ", b"!!python/object:os.system ", b"!x ", b"---\n", b"...\n", b"%YAML 9\n",
          b"<<: *a\n", b"? ", b"\r", b"\r\n", b"\xef\xbb\xbf", b"\xff\xfe", b"\xe2\x80\xa8", b"\xc2\x85",
          b'"\\UFFFFFFFF"', b'"\\ud800"', b'"\\0"', b"[" * 2000, b"{a: " * 300, b"- " * 300, b"x" * 2000, b" " * 500]


def places(tree, at=()):
    """Every path into a tree of lists and mappings; a swap may have put a part of it into itself."""
    if len(at) > 8 or not isinstance(tree, (dict, list)):
        return
    rows = tree.items() if isinstance(tree, dict) else enumerate(tree)
    for key, value in rows:
        yield (*at, key)
        yield from places(value, (*at, key))


def inside(tree, path):
    for key in path:
        tree = tree[key]
    return tree


def changed_tree(text, draw):
    tree = yaml.safe_load(filled(text, Car(Dbc.of_project()), SHIPPED[0]))
    for _ in range(draw.choice((1, 1, 1, 2, 3))):
        known = list(places(tree))
        if not known:
            break
        *above, key = draw.choice(known)
        parent = inside(tree, above)
        change = draw.choice(("replace", "replace", "replace", "delete", "repeat", "swap", "rename", "add"))
        if change == "delete":
            del parent[key]
        elif change == "repeat" and isinstance(parent, list):
            parent.insert(draw.randrange(len(parent) + 1), parent[key])
        elif change == "swap":
            parent[key] = inside(tree, draw.choice(known))
        elif change == "rename" and isinstance(parent, dict):
            parent[draw.choice(NAMES)] = parent.pop(key)
        elif change == "add" and isinstance(parent[key], dict):
            parent[key][draw.choice(NAMES)] = copy.deepcopy(draw.choice(AWKWARD))
        else:
            parent[key] = copy.deepcopy(draw.choice(AWKWARD))
    return written(tree).encode("utf-8", "surrogatepass")


def written(tree):
    return yaml.safe_dump(tree, sort_keys=False, allow_unicode=True)


def changed_words(text, draw):
    words = list(re.finditer(r"[^\s{}\[\],:]+(?: (?:ms|s|%|A|V))?", text))
    word = draw.choice(words)
    return (text[:word.start()] + str(draw.choice([*AWKWARD, *NAMES])) + text[word.end():]).encode("utf-8", "replace")


def changed_lines(text, draw):
    lines = text.splitlines(keepends=True)
    i, j = draw.randrange(len(lines)), draw.randrange(len(lines))
    change = draw.randrange(4)
    if change == 0:
        del lines[i]
    elif change == 1:
        lines.insert(j, lines[i])
    elif change == 2:
        lines[i], lines[j] = lines[j], lines[i]
    else:
        lines[i] = " " * draw.randrange(1, 5) + lines[i]
    return "".join(lines).encode()


def changed_bytes(text, draw):
    data = bytearray(text.encode())
    change = draw.randrange(4)
    if change == 0:
        return bytes(data[:draw.randrange(len(data))])
    for _ in range(draw.choice((1, 1, 2, 5))):
        at = draw.randrange(len(data))
        if change == 1:
            data[at] ^= 1 << draw.randrange(8)
        elif change == 2:
            data[at] = draw.randrange(256)
        else:
            data[at:at] = draw.choice(SCRAPS)
    return bytes(data)


def check(path, dbc, words):
    """None when the file was read and acted out, else its mistake."""
    lines = len(path.read_bytes().replace(b"\r\n", b"\n").replace(b"\r", b"\n").splitlines())
    begin = time.process_time()
    try:
        scenario = load(path, dbc)
    except InputError as error:
        place = re.match(re.escape(str(path)) + r":(\d+): \S", str(error))
        assert place, f"{words}: the mistake is told without its line: {error}"
        assert 1 <= int(place[1]) <= max(1, lines), f"{words}: no such line: {error}"
        return str(error)
    except Exception as error:
        raise AssertionError(f"{words}: {type(error).__name__} instead of a mistake with its place") from error
    finally:
        took = time.process_time() - begin
        assert took < LONGEST_S, f"{words}: reading took {took:.1f} s"
    try:
        act_out(scenario, dbc, seed=1)
    except Exception as error:
        raise AssertionError(f"{words}: was read, and a step or check ended in {error!r}") from error
    return None


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_changed_file_runs_or_its_mistake_is_told_with_its_line(path, tmp_path, dbc):
    seed = random.randrange(2**32)
    draw = random.Random(seed)
    text, changed = path.read_text(), tmp_path / "s.yaml"
    assert check(path, dbc, "unchanged") is None
    for number in range(MUTATIONS_A_FILE):
        change = draw.choice((changed_tree, changed_tree, changed_words, changed_lines, changed_bytes))
        changed.write_bytes(change(text, draw))
        check(changed, dbc, f"seed {seed}, change {number} ({change.__name__}) of {path.name}, now "
                            f"{changed.read_bytes()[:3000]!r}")
