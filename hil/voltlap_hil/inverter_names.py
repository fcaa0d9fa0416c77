# SPDX-License-Identifier: Apache-2.0
"""A table, a scenario or an invariant says InverterStatus.PhaseCurrent, whichever inverter a car has. Of a car with a
PM100 these names mean its frames: torque as the phase current that the firmware takes it for, T / K.
"""
from __future__ import annotations

import copy
from collections.abc import Sequence

from .car import Car
from .checks import MOTOR_CONSTANT_NM_PER_A
from .dbc import Dbc, Message, Signal

_SAME = {"InverterStatus.MotorSpeed": "Pm100MotorPosition.MotorSpeed",
         "InverterStatus.DcLinkVoltage": "Pm100Voltages.DcVoltage",
         "InverterCommand.Enable": "Pm100Command.Enable",
         "MotorTemperatures.Motor": "Pm100MotorTemperatures.Motor",
         "MotorTemperatures.Inverter": "Pm100ModuleTemperatures.ModuleA"}
_AS_CURRENT = {"InverterStatus.PhaseCurrent": "Pm100Torque.Feedback",
               "InverterCommand.PhaseCurrent": "Pm100Command.Torque"}
_FRAMES = {"InverterStatus": ("Pm100Torque", "Pm100MotorPosition", "Pm100Currents", "Pm100Voltages", "Pm100States",
                              "Pm100Faults"),
           "InverterCommand": ("Pm100Command",),
           "MotorTemperatures": ("Pm100MotorTemperatures", "Pm100ModuleTemperatures")}


def names_of_car(dbc: Dbc, arguments: Sequence[str]) -> Dbc:
    """The same files, with the names that this car's inverter answers to."""
    car = Car(dbc, tuple(arguments))
    if car.words.get("inverter.protocol") != "pm100":
        return dbc
    constant = car.keys.get("master.motor_constant_nm_per_a", MOTOR_CONSTANT_NM_PER_A)
    out = copy.copy(dbc)
    out.other_signals = {name: _named(dbc.signal(real), name) for name, real in _SAME.items()}
    out.other_signals |= {name: _as_current(dbc.signal(real), name, constant) for name, real in _AS_CURRENT.items()}
    out.other_messages = {name: [dbc.message(real) for real in frames] for name, frames in _FRAMES.items()}
    return out


def _named(signal: Signal, name: str) -> Signal:
    """Its message keeps what else is in the frame."""
    message: Message = copy.copy(signal.message)
    out = copy.copy(signal)
    out.name, out.message = name, message
    message.signals = {**message.signals, signal.short_name: out}
    return out


def _as_current(signal: Signal, name: str, constant_nm_per_a: float) -> Signal:
    out = _named(signal, name)
    out.unit, out.scale = "A", signal.scale / constant_nm_per_a
    out.minimum, out.maximum = (end / constant_nm_per_a for end in signal.range)
    return out
