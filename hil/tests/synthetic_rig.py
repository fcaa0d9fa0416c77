# SPDX-License-Identifier: Apache-2.0
"""A rig without a bus: drawn frames pass through the gateway's own code, and what a step tells the plant is encoded."""
import random

from voltlap_hil.faults import Gateway
from voltlap_hil.frame import Frame
from voltlap_hil.odometer import Odometer
from voltlap_hil.rig import Bench, Rig
from voltlap_hil.signals import Signals
from voltlap_hil.trace import Trace

_TICKS_A_STEP = 3  # of each run and wait; the rest of its time passes without frames
_FRAMES_A_TICK = 12


class _DrawnClock:
    """Ticks of frames with any content, some sealed, some of another length than the DBC files say."""

    def __init__(self, dbc, draw):
        self._dbc, self._draw, self.gateway, self.tick = dbc, draw, Gateway(dbc), 0
        self._car = [m for m in dbc.messages.values() if m.file != "lockstep.dbc"]

    @property
    def now_ms(self):
        return 10.0 * self.tick

    def advance(self):
        self.tick += 1
        out = []
        for sender, mark, side in (("PLANT", "Sync", 0), ("BMS", "DoneBms", 1), ("MASTER", "DoneMaster", 1)):
            own = [m for m in self._car if m.sender == sender]
            for message in self._draw.sample(own, min(len(own), _FRAMES_A_TICK)):
                out += self.gateway.forward(self._frame(message), side)
            tick = self._dbc.message(mark)
            out += self.gateway.forward(Frame(tick.id, tick.encode({"Tick": self.tick})), side)
        assert all(len(f.data) <= 8 for f in out)
        return [f._replace(time_ms=self.now_ms) for f in out if not f.lockstep]

    def _frame(self, message):
        length = message.dlc if self._draw.random() < 0.9 else self._draw.randrange(9)
        data = self._draw.randbytes(length)
        return Frame(message.id, message.seal(data, self.tick) if length == message.dlc else data)

    def tell(self, message, **values):
        self._dbc.message(message).encode({"Tick": self.tick, **values})

    def send(self, frames):
        for frame in frames:
            self.gateway.forward(frame, 0)


class SyntheticRig(Rig):
    """The rig's own steps and gateway, on a clock of drawn frames; nothing is waited for."""

    def __init__(self, dbc, seed):
        self.bench, self.dbc, self.trace, self.signals = Bench(far="vcan1"), dbc, Trace(dbc), Signals(dbc)
        self.clock = _DrawnClock(dbc, random.Random(seed))
        self._driver = {"Accelerator": None, "Brake": None}
        self._recorder, self._gateway, self._automatic = None, self.clock.gateway, True
        self._odometer = Odometer(dbc)
        self._alive = {"bms", "master"}

    def run(self, duration):
        super().run(f"{10 * _TICKS_A_STEP} ms")

    def wait(self, condition, within):
        self.run(within)
        return condition.holds({s.name: self.signals[s.name].value for s in condition.signals})

    def start_up(self, to="ready_to_drive"):
        self.driver(accelerator=0, brake=50, ts_on="On")

    def drive(self, to_m, within):
        self.run(within)

    def reset(self, node, off="10 ms"):
        assert node in ("bms", "master")

    def kill(self, node):
        self._alive.remove(node)


def act_out(scenario, dbc, seed):
    """Every step, check and watched signal of a scenario, once."""
    rig = SyntheticRig(dbc, seed)
    rig._ids_of(scenario.watch)
    for step in scenario.steps:
        step.act(rig)
        rig.run("30 ms")
    return [check.measure(rig.trace, 30.0) for check in (*scenario.then, *scenario.always)]
