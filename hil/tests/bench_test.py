# SPDX-License-Identifier: Apache-2.0
"""Where a run takes place, told apart from what cannot be."""
import pytest

from voltlap_hil.errors import HilError, InputError
from voltlap_hil.nodes import Nodes
from voltlap_hil.rig import Bench


def test_an_ecu_is_behind_the_gateway_or_at_the_plant():
    bench = Bench("can0", "can1", behind=["bms"])
    assert (bench.channel_of("bms"), bench.channel_of("master")) == ("can1", "can0")
    assert Bench("can0").channel_of("bms") == "can0"


@pytest.mark.parametrize("what, complaint", [({"channel": "can0", "far": "can0"}, "expected two channels"),
                                             ({"behind": ["bsm"]}, "no ECU 'bsm'. Did you mean bms")])
def test_a_bench_that_cannot_be_is_refused(what, complaint):
    with pytest.raises(InputError, match=complaint):
        Bench(**what)


def test_a_node_is_started_once():
    nodes = Nodes()
    nodes._running["bms"] = None
    with pytest.raises(HilError, match="bms runs already"):
        nodes.start("bms", [])
