# SPDX-License-Identifier: Apache-2.0
"""Every scenario in one process, with its event and without it: what holds on a CAN interface holds here."""
from pathlib import Path

import pytest

from voltlap_hil.runner import run
from voltlap_hil.scenario_file import load

FILES = sorted((Path(__file__).resolve().parents[1] / "scenarios").glob("*.yaml"))


@pytest.mark.parametrize("with_event", [True, False], ids=["with", "without"])
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_reaction_is_seen_when_and_only_when_its_cause_is_there(path, with_event, dbc, open_rig):
    outcome = run(load(path, dbc), open_rig, with_event)
    assert outcome.good, "\n".join(map(str, [*outcome.then, *outcome.always]))
