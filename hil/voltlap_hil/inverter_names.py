# SPDX-License-Identifier: Apache-2.0
"""A table, a scenario or an invariant says InverterStatus.PhaseCurrent, whichever inverter a car has. Of a car with a
PM100 or with four AMK inverters these names mean their frames: torque as the phase current that the firmware takes it
for, T / K. Of four inverters a message means the frames of all, and a signal that of one wheel of the axle with more
torque: its current is told as that of all four, by its share.
"""
from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .car import Car
from .checks import MOTOR_CONSTANT_NM_PER_A
from .dbc import Dbc, Message, Signal

AMK_WHEELS = ("FrontLeft", "FrontRight", "RearLeft", "RearRight")


@dataclass(frozen=True)
class _Names:
    """same: signals under another name; as_current: signals and the amperes in one of their units."""

    same: Mapping[str, str]
    as_current: Mapping[str, tuple[str, float]]
    frames: Mapping[str, Sequence[str]]


def _pm100(keys: Mapping[str, float]) -> _Names:
    a_per_nm = 1.0 / keys.get("master.motor_constant_nm_per_a", MOTOR_CONSTANT_NM_PER_A)
    return _Names(
        same={"InverterStatus.MotorSpeed": "Pm100MotorPosition.MotorSpeed",
              "InverterStatus.DcLinkVoltage": "Pm100Voltages.DcVoltage",
              "InverterCommand.Enable": "Pm100Command.Enable",
              "MotorTemperatures.Motor": "Pm100MotorTemperatures.Motor",
              "MotorTemperatures.Inverter": "Pm100ModuleTemperatures.ModuleA"},
        as_current={"InverterStatus.PhaseCurrent": ("Pm100Torque.Feedback", a_per_nm),
                    "InverterCommand.PhaseCurrent": ("Pm100Command.Torque", a_per_nm)},
        frames={"InverterStatus": ("Pm100Torque", "Pm100MotorPosition", "Pm100Currents", "Pm100Voltages",
                                   "Pm100States", "Pm100Faults"),
                "InverterCommand": ("Pm100Command",),
                "MotorTemperatures": ("Pm100MotorTemperatures", "Pm100ModuleTemperatures")})


def _amk(keys: Mapping[str, float]) -> _Names:
    front = keys.get("powertrain.front_torque_share", 0.5)
    wheel = "RearLeft" if front <= 0.5 else "FrontLeft"
    of_all = 2.0 / max(front, 1.0 - front)
    a_per_percent = (0.01 * keys.get("inverter.amk_nominal_torque_nm", 9.8) /
                     keys.get("master.motor_constant_nm_per_a", MOTOR_CONSTANT_NM_PER_A))
    return _Names(
        same={"InverterStatus.MotorSpeed": f"AmkActual1{wheel}.ActualVelocity",
              "InverterStatus.DcLinkVoltage": "DcLinkSensor.DcLinkVoltage",
              "InverterCommand.Enable": f"AmkSetpoints{wheel}.Enable",
              "MotorTemperatures.Motor": f"AmkActual2{wheel}.MotorTemperature",
              "MotorTemperatures.Inverter": f"AmkActual2{wheel}.IgbtTemperature"},
        as_current={"InverterStatus.PhaseCurrent": (f"AmkActual1{wheel}.TorqueCurrent", of_all),
                    "InverterCommand.PhaseCurrent": (f"AmkSetpoints{wheel}.TorqueLimitPositive",
                                                     of_all * a_per_percent)},
        frames={"InverterStatus": (f"AmkActual1{wheel}", "DcLinkSensor",
                                   *(f"AmkActual1{other}" for other in AMK_WHEELS if other != wheel)),
                "InverterCommand": (f"AmkSetpoints{wheel}",
                                    *(f"AmkSetpoints{other}" for other in AMK_WHEELS if other != wheel)),
                "MotorTemperatures": (f"AmkActual2{wheel}",
                                      *(f"AmkActual2{other}" for other in AMK_WHEELS if other != wheel))})


_PROTOCOLS = {"pm100": _pm100, "amk": _amk}


def names_of_car(dbc: Dbc, arguments: Sequence[str]) -> Dbc:
    """The same files, with the names that this car's inverter answers to."""
    car = Car(dbc, tuple(arguments))
    protocol = car.words.get("inverter.protocol", "")
    if protocol not in _PROTOCOLS:
        return dbc
    names = _PROTOCOLS[protocol](car.keys)
    out = copy.copy(dbc)
    out.other_signals = {name: _named(dbc.signal(real), name) for name, real in names.same.items()}
    out.other_signals |= {name: _as_current(dbc.signal(real), name, amperes)
                          for name, (real, amperes) in names.as_current.items()}
    out.other_messages = {name: [dbc.message(real) for real in frames] for name, frames in names.frames.items()}
    return out


def _named(signal: Signal, name: str) -> Signal:
    """Its message keeps what else is in the frame."""
    message: Message = copy.copy(signal.message)
    out = copy.copy(signal)
    out.name, out.message = name, message
    message.signals = {**message.signals, signal.short_name: out}
    return out


def _as_current(signal: Signal, name: str, amperes: float) -> Signal:
    """`amperes`: in one of the signal's units."""
    out = _named(signal, name)
    out.unit, out.scale = "A", signal.scale * amperes
    out.minimum, out.maximum = (end * amperes for end in signal.range)
    return out
