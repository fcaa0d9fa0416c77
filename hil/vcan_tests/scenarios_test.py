# SPDX-License-Identifier: Apache-2.0
"""Every scenario on the real bus, with its event and without it: the reaction must be seen, and seen only then.

The measured times are left in hil_scenarios.html and .md of the build folder.
"""
import os
from functools import partial
from pathlib import Path

import pytest

from voltlap_hil import report
from voltlap_hil.runner import run
from voltlap_hil.scenario_file import load

FILES = sorted((Path(__file__).resolve().parents[1] / "scenarios").glob("*.yaml"))


@pytest.fixture(scope="module")
def outcomes():
    gathered = []
    yield gathered
    if folder := os.environ.get("VOLTLAP_BUILD_DIR"):
        for suffix in (".html", ".md"):
            report.write(Path(folder) / f"hil_scenarios{suffix}", gathered)


@pytest.mark.parametrize("with_event", [True, False], ids=["with_event", "without_event"])
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_reaction_is_seen_when_and_only_when_its_cause_is_there(path, with_event, dbc, open_rig, outcomes):
    outcome = run(load(path, dbc), partial(open_rig), with_event)
    outcomes.append(outcome)
    assert outcome.good, "\n".join(map(str, [*outcome.then, *outcome.always]))
