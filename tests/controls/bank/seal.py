# SPDX-License-Identifier: Apache-2.0
"""Labels that nobody can change or read until all answers are in.

Before the tool runs, the hash of each label with a random salt is written and flushed; label and salt stay in this
process's memory. Afterwards both are written beside the hashes, and anybody can check them.
"""

import hashlib
import json
import os
import secrets
from pathlib import Path


def digest(label, salt):
    return hashlib.sha256((salt + json.dumps(label, sort_keys=True)).encode()).hexdigest()


class Ledger:
    def __init__(self, folder):
        self.commitments, self.revealed = Path(folder) / "commitments.txt", Path(folder) / "revealed.jsonl"
        self._secrets = {}
        self._file = self.commitments.open("x")

    def commit(self, name, label):
        """Before the tool sees the folder `name`."""
        salt = secrets.token_hex(16)
        self._secrets[name] = (label, salt)
        self._file.write(f"{name} {digest(label, salt)}\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def reveal(self):
        """After the last answer. Returns {name: label}."""
        self._file.close()
        with self.revealed.open("x") as out:
            for name, (label, salt) in self._secrets.items():
                out.write(json.dumps({"name": name, "salt": salt, "label": label}, sort_keys=True) + "\n")
        verify(self.commitments, self.revealed)
        return {name: label for name, (label, _) in self._secrets.items()}


def verify(commitments, revealed):
    """Raises ValueError when a label is not the one that was committed to."""
    promised = dict(line.split() for line in Path(commitments).read_text().splitlines())
    shown = [json.loads(line) for line in Path(revealed).read_text().splitlines()]
    if {entry["name"] for entry in shown} != promised.keys():
        raise ValueError("labels were added or left out after the commitment")
    for entry in shown:
        if digest(entry["label"], entry["salt"]) != promised[entry["name"]]:
            raise ValueError(f"label of {entry['name']} is not the one that was committed to")
