# SPDX-License-Identifier: Apache-2.0
"""Properties of a profile that are understood: unit, scale, whether both are certain or inferred, and what they say.

docs/orion.md has the evidence. Every other property is listed as not understood, and used for nothing."""
from __future__ import annotations

import dataclasses

CERTAIN, INFERRED, RAW = "certain", "inferred", "as recorded"


@dataclasses.dataclass(frozen=True)
class Setting:
    name: str
    unit: str
    scale: float  # value in `unit` = recorded x scale
    known: str    # CERTAIN, INFERRED, or RAW: its meaning is that of its name, its scale is not known
    least: float
    most: float   # of the value, in `unit`: what a battery can be set to at all
    what: str


def volts(name: str, known: str, what: str) -> Setting:
    return Setting(name, "V", 1e-4, known, 0.0, 6.5535, what)


def amperes(name: str, what: str) -> Setting:
    return Setting(name, "A", 1.0, INFERRED, 0.0, 65535.0, what)


def degrees(name: str, what: str) -> Setting:
    return Setting(name, "degC", 1.0, INFERRED, -128.0, 127.0, what)


def percents(name: str, what: str) -> Setting:
    return Setting(name, "%", 1.0, INFERRED, 0.0, 100.0, what)


def recorded(name: str, what: str) -> Setting:
    return Setting(name, "", 1.0, RAW, -2.0**31, 2.0**31, what)


GROUPS: dict[str, list[Setting]] = {
    "battery": [
        Setting("totalCells", "", 1.0, CERTAIN, 1.0, 1000.0, "cells in series"),
        Setting("totalAmphours", "Ah", 0.01, INFERRED, 0.01, 10000.0, "capacity"),
        recorded("parallelStrings", "strings in parallel, each with a BMS"),
    ],
    "voltage limits": [
        volts("maximumCellVoltage", CERTAIN, "the charge limit keeps every cell below it"),
        volts("minimumCellVoltage", CERTAIN, "the discharge limit keeps every cell above it"),
        volts("maxChargeCellVoltage", INFERRED, "of a cell, on the charger"),
        volts("minimumChargeCellVoltage", INFERRED, "of a cell, below which the charger stays off"),
        Setting("maximumPackVoltage", "V", 0.1, INFERRED, 0.0, 6553.5, "of the pack"),
        Setting("maxChargePackVoltage", "V", 0.1, INFERRED, 0.0, 6553.5, "of the pack, on the charger"),
    ],
    "current limits": [
        amperes("maximumDCL", "largest discharge limit"),
        amperes("maximumCCL", "largest charge limit"),
        amperes("maxChargeAmperage", "on the charger"),
        Setting("intresDCMultiplier", "", 0.1, INFERRED, 0.0, 25.5, "factor on the resistance of the table"),
    ],
    "temperature limits": [
        degrees("maxDclTemperature", "no discharge above"),
        degrees("minDclTemperature", "no discharge below"),
        degrees("maxCclTemperature", "no charge above"),
        degrees("minCclTemperature", "no charge below"),
        degrees("hotPackTemperature", "the pack counts as too hot"),
        degrees("derateHighTempDCLStart", "the discharge limit falls above"),
        amperes("derateHighTempDCLAmperage", "by this for each degC"),
        degrees("derateLowTempDCLStart", "the discharge limit falls below"),
        amperes("derateLowTempDCLAmperage", "by this for each degC"),
        degrees("derateHighTempCCLStart", "the charge limit falls above"),
        amperes("derateHighTempCCLAmperage", "by this for each degC"),
        degrees("derateLowTempCCLStart", "the charge limit falls below"),
        amperes("derateLowTempCCLAmperage", "by this for each degC"),
    ],
    "state of charge": [
        percents("depletedSOC", "counts as empty"),
        percents("chargedSOC", "counts as full"),
        percents("derateLowSOCStart", "the discharge limit falls below"),
        amperes("derateLowSOCAmperage", "by this for each percent"),
        percents("derateHighSOCStart", "the charge limit falls above"),
        amperes("derateHighSOCAmperage", "by this for each percent"),
    ],
    "balancing": [
        volts("balanceVoltage", INFERRED, "begins when a cell is above"),
        volts("minimumBalanceVoltage", INFERRED, "no balancing of a cell below"),
        volts("balanceDeltaVoltage", INFERRED, "ends when the cells are as close"),
    ],
    "current sensor": [recorded("currentSensorSelected", "which of the utility's list"),
                       recorded("currentSensorType", "kind"),
                       recorded("currentSensorMaxAmps", "largest current"),
                       recorded("currentSensorMinAmps", "smallest current")],
    "CAN": [recorded("canbusFrequency", "bit rate of bus 1, of the utility's list"),
            recorded("canbus2Frequency", "bit rate of bus 2, of the utility's list"),
            recorded("j1939Address", "source address")],
}
SETTINGS = {setting.name: setting for group in GROUPS.values() for setting in group}


@dataclasses.dataclass(frozen=True)
class Table:
    """A value every 5 degC from -40 degC on; a point that the file does not name is 0, as in a new Java array."""
    name: str
    points: int
    unit: str
    scale: float
    what: str


FIRST_C, STEP_C = -40.0, 5.0
TABLES = {
    "dclTemperatureTable": Table("dclTemperatureTable", 20, "A", 1.0, "discharge limit by temperature"),
    "cclTemperatureTable": Table("cclTemperatureTable", 20, "A", 1.0, "charge limit by temperature"),
    "resistanceTable": Table("resistanceTable", 25, "mOhm", 0.01, "resistance of a cell by temperature"),
}
