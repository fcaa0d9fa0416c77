# SPDX-License-Identifier: Apache-2.0
"""A test rig: nodes started, the driver's pedals, planted faults, waiting for conditions. Plain pytest works with it.

>>> with Rig(Bench("vcan0")) as rig:
...     rig.start_up("ready_to_drive")
...     rig.driver(accelerator=100)
...     rig.wait("InverterStatus.PhaseCurrent > 300 A", within="1 s")
...     event = rig.now_ms
...     rig.plant("CellLost", index=4)
...     rig.run("800 ms")
...     assert checks.torque_zero_within(rig.dbc, 600).measure(rig.trace, event).held
"""
from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .condition import Condition
from .dbc import Dbc, Value
from .errors import HilError, InputError, did_you_mean
from .faults import Fault
from .frame import Frame
from .gateway import GatewayProcess
from .in_process import PROCESS, CarProcess, EcuPlace
from .lockstep import MEMBERS, BusClock, Clock, LockstepClock, ask_on_terminal
from .nodes import ECUS, Nodes
from .odometer import NEEDS as ODOMETER_NEEDS
from .odometer import Odometer
from .quantity import TICK_MS, duration_ms
from .record import Recorder
from .signals import Signals
from .tape import Tape
from .trace import Trace

STAGES = ("low_voltage", "tractive_system", "ready_to_drive", "automatic")
SWITCHES = {"ts_on": "TsOn", "ready_to_drive": "ReadyToDrive", "reset": "Reset", "shutdown": "Shutdown"}
_ALL_HEARD_MS = 300.0  # after power-on: every sensor has been heard
_LOST_AFTER_S = "60"  # wall time that a busy machine may take over a tick


@dataclass(frozen=True)
class Bench:
    """Where a run takes place.

    channel     the bus: the plant's side when there is a gateway; "process": car and firmware in one process
    far         the channel behind the gateway, None for a run without; "process" within one process
    behind      the ECUs behind the gateway
    start       False: the nodes run already, or the bus is a real one; then conditions use the bus's time
    interface   python-can's name of the kind of bus, for a run whose nodes are not started
    ecu         where the firmware runs when it is all one process
    operator    is told what a person has to do at a real car
    """

    channel: str = "vcan0"
    far: str | None = None
    behind: Sequence[str] = ECUS
    start: bool = True
    interface: str = "socketcan"
    ecu: EcuPlace = EcuPlace()
    operator: Callable[[str], None] = ask_on_terminal

    def __post_init__(self) -> None:
        if self.far == self.channel and not self.in_process:
            raise InputError(f"found {self.channel} on both sides of the gateway, expected two channels")
        for ecu in self.behind:
            if ecu not in ECUS:
                raise InputError(f"no ECU {ecu!r}.{did_you_mean(ecu, ECUS)} ECUs: {', '.join(ECUS)}")

    @property
    def in_process(self) -> bool:
        return self.channel == PROCESS

    def channel_of(self, ecu: str) -> str:
        return self.far if self.far and ecu in self.behind else self.channel


class Rig:
    """One run. Time goes on only in `run`, `wait` and `start_up`; with lockstep it is simulated time.

    watch       names of signals or messages to listen to, None for all; a short list is quicker
    record      file of all frames (see record.Recorder)
    arguments   more for `voltlap plant` and the ECUs, for example ["--vehicle", "vtm17e"]
    automatic   the plant's own driver powers up and drives laps, where no step takes a pedal or switch from him
    seed        of what gateway and sensors draw
    """

    def __init__(self, bench: Bench | None = None, watch: Iterable[str] | None = None, record: str | Path | None = None,
                 arguments: Sequence[str] = (), dbc: Dbc | None = None, **run: bool | int) -> None:
        self._automatic, self._seed = bool(run.pop("automatic", False)), int(run.pop("seed", 1))
        if run:
            raise InputError(f"no setting {', '.join(run)} of a rig")
        self._odometer = Odometer(dbc if dbc is not None else Dbc.of_project())
        self.bench = bench if bench is not None else Bench()
        self.dbc = dbc if dbc is not None else Dbc.of_project()
        self.trace = Trace(self.dbc)
        self.signals = Signals(self.dbc)
        self.nodes = Nodes()
        self._driver: dict[str, Value | None] = {"Accelerator": None, "Brake": None}
        self._recorder: Recorder | None = None
        self._gateway: GatewayProcess | CarProcess | None = None
        self._lockstep: LockstepClock | CarProcess | None = None
        self._closers: list[Callable[[], None]] = []
        try:
            if record:
                self._open_recorder(record)
            ids = None if watch is None or record else self._ids_of(watch)
            if self.bench.in_process:
                self.clock: Clock = self._open_process(ids, arguments)
            else:
                if self.bench.far:
                    self._open_gateway(self.bench.far)
                self.clock = self._open_clock(ids)
                if self.bench.start:
                    self._start_nodes(arguments)
            self.step()
        except BaseException:
            self.close()
            raise

    def _open_recorder(self, path: str | Path) -> None:
        self._recorder = Recorder(path, "vcan0" if self.bench.in_process else self.bench.channel)
        self._closers.append(self._recorder.close)

    def _open_gateway(self, far: str) -> None:
        self._gateway = GatewayProcess(self.bench.channel, far, self.dbc, self.bench.start, self._seed)
        self._closers.append(self._gateway.close)

    def _open_clock(self, ids: list[int] | None) -> Clock:
        clock: Clock
        if self.bench.start:
            clock = self._lockstep = LockstepClock(self.bench.channel, self.dbc, ids, self._check_processes)
        else:
            clock = BusClock(self.bench.channel, self.dbc, ids, self.bench.interface, self.bench.operator)
        self._closers.append(clock.close)
        return clock

    def _open_process(self, ids: list[int] | None, arguments: Sequence[str]) -> CarProcess:
        behind = self.bench.behind if self.bench.far else None
        car = CarProcess(self.dbc, ids, behind, [*self._driver_flags(), *arguments], self._seed, self.bench.ecu)
        self._closers.append(car.close)
        self._lockstep = car
        self._gateway = car if behind is not None else None
        return car

    def _driver_flags(self) -> list[str]:
        return ["--driver", "auto" if self._automatic else "none", "--seed", str(self._seed)]

    def _start_nodes(self, arguments: Sequence[str]) -> None:
        for ecu in ECUS:
            self.nodes.start(ecu, ["ecu", ecu, "--bus", self.bench.channel_of(ecu), *arguments])
        self.nodes.start("plant", ["plant", "--bus", self.bench.channel, "--members", "bms,master,hil",
                                   *self._driver_flags(), *(["--keep-going"] if self._automatic else []),
                                   "--lost-after", _LOST_AFTER_S, *arguments])

    def _check_processes(self) -> None:
        if self._gateway:
            self._gateway.check_alive()
        self.nodes.check_alive()

    def _ids_of(self, watch: Iterable[str]) -> list[int]:
        """Of signals, and of messages as a whole ("BmsStatus.")."""
        return sorted({(self.dbc.signal(name).message if signal else self.dbc.message(message)).id
                       for name in watch for message, _, signal in [name.partition(".")]})

    def __enter__(self) -> Rig:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the run and every process of it."""
        if self._lockstep is not None:
            self._lockstep.stop()
        self.nodes.close()
        for close in reversed(self._closers):
            close()
        self._closers.clear()
        self._lockstep = None

    # What boards in other programs leave behind, after close().

    @property
    def tape(self) -> Tape | None:
        return self.clock.tape if isinstance(self.clock, CarProcess) else None

    @property
    def ecu_account(self) -> dict[str, Any] | None:
        return self.clock.ecu_account if isinstance(self.clock, CarProcess) else None

    # Time

    @property
    def now_ms(self) -> float:
        return self.clock.now_ms

    def step(self) -> None:
        """To the next tick, or to the next frames of a bus without Sync."""
        frames = self.clock.advance()
        self.signals.now_ms = self.now_ms
        for frame in frames:
            self.signals.update(frame)
            self._odometer.update(frame)
        self.trace.extend(frames)
        if self._recorder:
            self._recorder.write(frames)

    def run(self, duration: object) -> None:
        end_ms = self.now_ms + duration_ms(duration)
        while self.now_ms < end_ms:
            self.step()

    def wait(self, condition: str | Condition, within: object) -> float:
        """Runs until the condition holds; the time it took in ms. HilError when it does not come in time."""
        wanted = condition if isinstance(condition, Condition) else Condition.parse(condition, self.dbc)
        start_ms, within_ms = self.now_ms, duration_ms(within)
        while not wanted.holds({s.name: self.signals[s.name].value for s in wanted.signals}):
            if self.now_ms - start_ms >= within_ms:
                seen = ", ".join(f"{s.name} = {self._seen(s.name)}" for s in wanted.signals)
                raise HilError(f"'{wanted.text}' did not come within {within_ms:g} ms; at {self.now_ms:g} ms {seen}")
            self.step()
        return self.now_ms - start_ms

    @property
    def distance_m(self) -> float:
        """What the front wheels have rolled since the start."""
        return self._odometer.distance_m

    def drive(self, to_m: float, within: object) -> None:
        """Runs until the car has come so far; HilError when it does not in time."""
        start_ms, within_ms = self.now_ms, duration_ms(within)
        while self.distance_m < to_m:
            if self.now_ms - start_ms >= within_ms:
                raise HilError(f"the car did not come to {to_m:g} m within {within_ms:g} ms; at {self.now_ms:g} ms it "
                               f"is at {self.distance_m:.1f} m")
            self.step()

    def _seen(self, name: str) -> str:
        reading = self.signals[name]
        bits = self.signals.bits(name)
        if reading.age_ms is None:
            return "never heard"
        return f"{' '.join(bits) if bits else reading.value} {reading.unit}".strip()

    # What acts on the car. All of it takes effect in the next tick.

    def driver(self, accelerator: float | None = None, brake: float | None = None, **switches: str) -> None:
        """Pedals in percent and switches On, Off or Automatic; what is not named stays as it was."""
        if accelerator is not None:
            self._driver["Accelerator"] = accelerator
        if brake is not None:
            self._driver["Brake"] = brake
        for name, state in switches.items():
            if name not in SWITCHES:
                raise InputError(f"no switch {name!r}.{did_you_mean(name, SWITCHES)} Switches: {', '.join(SWITCHES)}")
            self._driver[SWITCHES[name]] = state
        self.clock.tell("DriverOverride", **self._driver)

    def automatic(self) -> None:
        """Pedals and switches back to the plant's own driver."""
        if not self._automatic:
            raise InputError("the plant runs without a driver of its own: open the rig with automatic=True")
        self._driver = {"Accelerator": None, "Brake": None}
        self.clock.tell("DriverOverride", **self._driver)

    def plant(self, fault: str, index: int = 0, value: int = 0) -> None:
        """A fault of the plant by its name in lockstep.dbc, for example CellLost; ClearAll ends all."""
        self.clock.tell("PlantFault", Fault=fault, Index=index, Value=value)

    def gateway(self, kind: str, messages: Iterable[str | int], for_ms: float | None = None, **what: object) -> None:
        """A fault of the bus (see faults.Fault) on messages, groups, nodes or identifiers."""
        wanted = list(messages)
        ids = {m for m in wanted if isinstance(m, int)}
        ids |= {m.id for m in self.dbc.select(m for m in wanted if isinstance(m, str))}
        first = round(self.now_ms / TICK_MS) + 1
        until = None if for_ms is None else first + round(for_ms / TICK_MS)
        fault = Fault(kind, frozenset(ids), first, until, **what)  # type: ignore[arg-type]
        fault.check_fits(self.dbc)
        self._need_gateway().install(fault)

    def clear_gateway(self) -> None:
        self._need_gateway().clear()

    def _need_gateway(self) -> GatewayProcess | CarProcess:
        if self._gateway is None:
            raise InputError("there is no gateway: a second channel is needed for it (far='vcan1', --far vcan1)")
        return self._gateway

    def send(self, message: str, **values: Value | None) -> None:
        """A frame of the harness's own, over what was last seen of the message, with the next counter and its CRC."""
        self.clock.send([self.signals.write(message, values)])

    def send_frames(self, frames: list[Frame]) -> None:
        self.clock.send(frames)

    def kill(self, node: str) -> None:
        """Ends the process of a node and tells the plant not to wait for it."""
        if self._lockstep is None:
            raise InputError("only a node that the harness started can be killed")
        if node not in MEMBERS:
            raise InputError(f"no node {node!r}.{did_you_mean(node, MEMBERS)} Nodes: {', '.join(ECUS)}")
        if not self.bench.in_process:
            self.nodes.kill(node)
        self._lockstep.lost(node)

    def reset(self, node: str, off: object = "10 ms") -> None:
        """The supply of a control unit fails for so long; what it keeps over that is all it knows then."""
        if not isinstance(self.clock, CarProcess):
            raise InputError(f"the supply of {node} can be taken only where car and firmware are one process: channel "
                             f"{PROCESS}")
        self.clock.reset(node, round(duration_ms(off)))

    def start_up(self, to: str = "ready_to_drive") -> None:
        """Low voltage, tractive system, ready to drive, as the rules' procedure asks (EV.9), but without dawdling."""
        if to not in STAGES:
            raise InputError(f"no stage {to!r}.{did_you_mean(to, STAGES)} Stages: {', '.join(STAGES)}")
        if to == "automatic":
            self.automatic()
            self.wait("MasterStatus.DriveState = ReadyToDrive", within="20 s")
            return
        self.driver(accelerator=0, brake=0, ts_on="Off", ready_to_drive="Off", reset="Off", shutdown="On")
        self.run(f"{_ALL_HEARD_MS:g} ms")
        self.wait("BmsStatus.State = Idle and MasterStatus.DriveState = LvOn", within="2 s")
        if to == "low_voltage":
            return
        self.driver(ts_on="On")
        self.wait("MasterStatus.DriveState = TsActive", within="10 s")
        self.driver(ts_on="Off", brake=50)
        if to == "tractive_system":
            return
        self.wait("Pedals.BrakeFront > 10 bar", within="1 s")
        self.driver(ready_to_drive="On")
        self.wait("MasterStatus.DriveState = ReadyToDrive", within="1 s")
        self.driver(ready_to_drive="Off", brake=0)
        self.run("50 ms")


START_UP_NEEDS = ("BmsStatus.State", "MasterStatus.DriveState", "Pedals.BrakeFront")
DISTANCE_NEEDS = ODOMETER_NEEDS
