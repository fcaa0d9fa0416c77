# SPDX-License-Identifier: Apache-2.0
"""Every scenario on the real bus, with its event and without it: the reaction must be seen, and seen only then.
Without it a third of them, drawn by VOLTLAP_TEST_SEED; all with VOLTLAP_TEST_WHOLE=1: each starts plant and ECUs.

The measured times are left in hil_scenarios.html and .md of the build folder.
"""
import os
import random
from functools import partial
from pathlib import Path

import pytest

from voltlap_hil import report
from voltlap_hil.runner import run
from voltlap_hil.scenario_file import load

FILES = sorted((Path(__file__).resolve().parents[1] / "scenarios").glob("*.yaml"))
SEED = os.environ.get("VOLTLAP_TEST_SEED") or str(random.randrange(2**32))
WHOLE = os.environ.get("VOLTLAP_TEST_WHOLE") == "1"
WITHOUT_EVENT = sorted(FILES if WHOLE else random.Random(SEED).sample(FILES, (len(FILES) + 2) // 3))
CASES = [pytest.param(path, with_event, id=f"{path.stem}-{'with' if with_event else 'without'}_event")
         for with_event, paths in ((True, FILES), (False, WITHOUT_EVENT)) for path in paths]


@pytest.fixture(scope="module")
def outcomes():
    gathered = []
    yield gathered
    if folder := os.environ.get("VOLTLAP_BUILD_DIR"):
        for suffix in (".html", ".md"):
            report.write(Path(folder) / f"hil_scenarios{suffix}", gathered)


@pytest.mark.parametrize(("path", "with_event"), CASES)
def test_the_reaction_is_seen_when_and_only_when_its_cause_is_there(path, with_event, dbc, open_rig, outcomes):
    print(f"VOLTLAP_TEST_SEED={SEED}")
    outcome = run(load(path, dbc), partial(open_rig), with_event)
    outcomes.append(outcome)
    assert outcome.good, "\n".join(map(str, [*outcome.then, *outcome.always]))
