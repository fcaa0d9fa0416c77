# SPDX-License-Identifier: Apache-2.0
"""Survivors that no test can see, each with its reason: firmware/mutants.toml. An entry is known by file, function, the
text of its line and the change, so that edits elsewhere leave it."""
import tomllib

KEYS = ("file", "function", "line", "change")


class Malformed(Exception):
    """The file of explanations is not as it must be."""


def read(path, table="equivalent", keys=KEYS):
    """{(file, function, line, change): why}, or by other keys."""
    if not path.exists():
        return {}
    try:
        entries = tomllib.loads(path.read_text()).get(table, [])
    except tomllib.TOMLDecodeError as error:
        raise Malformed(f"{path}: {error}") from error
    found = {}
    for entry in entries:
        if set(entry) != {*keys, "why"} or not all(str(value).strip() for value in entry.values()):
            raise Malformed(f"{path}: an entry has {', '.join(keys)} and why, none of them empty: {entry}")
        key = tuple(entry[name] for name in keys)
        if key in found:
            raise Malformed(f"{path}: twice: {key}")
        found[key] = entry["why"]
    return found


def judge(rows, explained, files):
    """Marks survivors that are explained; entries of these files that explain nothing, as sentences. What was not drawn
    may survive."""
    there, needed = set(), set()
    for row in rows:
        key = tuple(row[name if name != "line" else "text"] for name in KEYS)
        there.add(key)
        if row["verdict"] == "survived" and key in explained:
            row["verdict"], row["why"] = "explained", explained[key]
            needed.add(key)
        elif row["verdict"] in ("not run", "not reached"):
            needed.add(key)
    stale = []
    for key in explained:
        if key[0] in files and key not in there:
            stale.append(f"{key[0]}: there is no such mutant any more: {key[1]}: {key[3]}")
        elif key[0] in files and key not in needed:
            stale.append(f"{key[0]}: a test sees it now: {key[1]}: {key[3]}")
    return stale
