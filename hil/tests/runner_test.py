# SPDX-License-Identifier: Apache-2.0
"""A scenario with its event and without it, on a rig that answers at once."""
import pytest

from voltlap_hil.runner import run
from voltlap_hil.scenario_file import load
from voltlap_hil.trace import Trace

FILE = """\
scenario: The button makes torque go away
given:
  - run: 100 ms
when:
  - driver: {shutdown: open}
then:
  - torque_zero_within: 50 ms
always:
  - stays: {condition: BmsStatus.State = TsActive, for: 100 ms}
"""


class ObedientRig:
    """A car whose torque ends 30 ms after the shutdown circuit was opened."""

    def __init__(self, dbc, frame):
        self.trace, self._frame, self.now_ms, self._ends_ms = Trace(dbc), frame, 0.0, None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def driver(self, **_):
        self._ends_ms = self.now_ms + 30

    def run(self, duration):
        for _ in range(round(float(duration.split()[0]) / 10)):
            self.now_ms += 10
            on = self._ends_ms is None or self.now_ms < self._ends_ms
            self.trace.extend([self._frame("InverterStatus", self.now_ms, PhaseCurrent=300.0 if on else 0.0),
                               self._frame("BmsStatus", self.now_ms, State="TsActive")])


@pytest.fixture
def outcome_of(tmp_path, dbc, frame):
    def running(with_event, text=FILE):
        path = tmp_path / "s.yaml"
        path.write_text(text)
        return run(load(path, dbc), lambda **_: ObedientRig(dbc, frame), with_event)
    return running


def test_with_its_event_the_checks_hold_and_say_what_they_measured(outcome_of):
    outcome = outcome_of(True)
    assert outcome.held and outcome.good
    assert outcome.event_ms == 100 and outcome.then[0].measured == 30


def test_without_its_event_no_reaction_is_seen_and_what_always_holds_does(outcome_of):
    outcome = outcome_of(False)
    assert not outcome.held and outcome.contrary and outcome.good


def test_a_check_that_holds_without_the_event_is_no_check(outcome_of):
    text = FILE.replace("torque_zero_within: 50 ms", "stays: {condition: BmsStatus.State = TsActive, for: 50 ms}")
    assert outcome_of(True, text).good and not outcome_of(False, text).good


def test_what_must_always_hold_counts_in_both_runs(outcome_of):
    text = FILE.replace("State = TsActive", "State = Fault")
    assert not outcome_of(True, text).good and not outcome_of(False, text).good


def test_it_observes_as_long_as_its_checks_ask(outcome_of):
    outcome = outcome_of(True)
    assert outcome.scenario.observe_ms == 150
