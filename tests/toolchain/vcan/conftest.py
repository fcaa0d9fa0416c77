# SPDX-License-Identifier: Apache-2.0
"""Each test of the user-mode kernel starts one: of them half, drawn by VOLTLAP_TEST_SEED; all with
VOLTLAP_TEST_WHOLE=1, or where one is named."""
import os
import random

SEED = os.environ.get("VOLTLAP_TEST_SEED") or str(random.randrange(2**32))
DRAWN_FROM = "uml_test.py"
drawn = []


def pytest_collection_modifyitems(config, items):
    one_is_named = any("::" in word for word in config.args)
    if os.environ.get("VOLTLAP_TEST_WHOLE") == "1" or one_is_named or config.option.keyword:
        return
    there = [item for item in items if item.path.name == DRAWN_FROM]
    left_out = random.Random(SEED).sample(there, len(there) // 2)
    if left_out:
        drawn[:] = [len(there) - len(left_out), len(there)]
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in left_out]


def pytest_terminal_summary(terminalreporter):
    if drawn:
        terminalreporter.write_line(f"VOLTLAP_TEST_SEED={SEED}: {drawn[0]} of {drawn[1]} tests of {DRAWN_FROM}")
