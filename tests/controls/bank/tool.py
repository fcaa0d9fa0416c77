# SPDX-License-Identifier: Apache-2.0
"""One question to the tool: a folder with a neutral name, a log, its model and its references, and nothing else."""

import json
import os
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

VERDICTS = ("named", "ambiguous", "unknown", "no_discrepancy", "bad_data")
LONGEST_S = 300.0


@dataclass
class Answer:
    """What was said, by the contract of `voltlap explain --json`. `failed`: it ended without an answer, and how."""

    verdict: str = ""
    causes: list = field(default_factory=list)
    alternatives: list = field(default_factory=list)
    gain: dict = field(default_factory=dict)
    sentence: str = ""
    masked: list = field(default_factory=list)
    next_test: str | None = None
    seconds: float = 0.0
    failed: str = ""
    sound_rms: dict = field(default_factory=dict)  # by channel, of the same drive without the effect


def command(tool, folder, seed, without="", settings=()):
    """The command line, with names inside the folder alone."""
    names = sorted(path.name for path in folder.iterdir())
    log = next(name for name in names if name.startswith("log."))
    out = [str(tool), "explain", log, "--model", "model.toml", "--json", "answer.json", "--seed", str(seed)]
    references = [name for name in names if name.startswith("reference_")]
    if references:
        out += ["--reference", *references]
    if "map.toml" in names:
        out += ["--map", "./map.toml"]
    if without:
        settings = (*settings, f"explain.without={without}")
    if settings:
        out += ["--set", *settings]
    return out


def ask(tool, folder, seed, without, running, settings=()):
    """Asks about the log in the folder."""
    return run(command(tool, folder, seed, without, settings), folder, running)


def run(words, folder, running):
    """Runs the tool in the folder with an empty environment. `running`: where its process is kept, to be ended."""
    folder = Path(folder)
    environment = {"PATH": os.environ.get("PATH", ""), "LANG": "C.UTF-8", "HOME": str(folder)}
    before = os.times()
    process = subprocess.Popen(
        words,
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    running.add(process)
    try:
        _, errors = process.communicate(timeout=LONGEST_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return Answer(failed=f"no answer within {LONGEST_S:.0f} s")
    finally:
        running.discard(process)
    seconds = os.times().elapsed - before.elapsed
    if process.returncode != 0:
        last = [line for line in errors.splitlines() if line.strip()][-1:]
        return Answer(failed=f"exit code {process.returncode}: " + "".join(last)[-300:], seconds=seconds)
    return read(folder / "answer.json", seconds)


def read(path, seconds=0.0):
    try:
        data = json.loads(Path(path).read_text())
    except (OSError, ValueError) as error:
        return Answer(failed=f"answer.json cannot be read: {error}", seconds=seconds)
    missing = [
        key
        for key in (
            "verdict",
            "sentence",
            "causes",
            "unknown_in",
            "gain",
            "masked",
            "next_test",
            "extended_model",
            "mode",
            "seed",
            "version",
        )
        if key not in data
    ]
    if missing or data["verdict"] not in VERDICTS:
        return Answer(
            failed=f"answer.json breaks its contract: missing {missing}, verdict {data.get('verdict')}", seconds=seconds
        )
    return Answer(
        data["verdict"],
        data["causes"],
        data.get("alternatives") or [],
        data["gain"],
        data["sentence"],
        data["masked"],
        data["next_test"],
        seconds,
    )
