# SPDX-License-Identifier: Apache-2.0
"""A pack file of ours from a profile: each key with the place that it comes from, and what has no counterpart.

Where the Orion has a table or a slope of the discharge limit in the heat and our BMS one line, the line lies nowhere
above them. The ranges are those of `voltlap list keys`."""
from __future__ import annotations

import dataclasses
import pathlib

from voltlap_orion.bean_file import ProfileRefused
from voltlap_orion.cell_choice import Cell
from voltlap_orion.profile import Profile
from voltlap_orion.settings import FIRST_C, SETTINGS, STEP_C, TABLES

OTHER_CELL_V = 0.2  # a charge limit so far below the cell's own is hardly meant
COLD_C, HOT_C = 10.0, 55.0  # where the resistance is followed
MOST_CELLS, MOST_PARALLEL, MOST_A = 144, 100, 1000.0
OWN_HOT_C, OWN_COLD_CHARGE_C = 60.0, 0.0  # of our BMS, where the profile says nothing
# Settings that no key of ours is, with what our BMS does in their place.
WITHOUT_COUNTERPART = {
    "maximumPackVoltage": "the limits of the cells hold", "maxChargePackVoltage": "there is no charger's mode",
    "maxChargeCellVoltage": "there is no charger's mode", "minimumChargeCellVoltage": "there is no charger's mode",
    "maxChargeAmperage": "there is no charger's mode",
    "minDclTemperature": "the discharge limit does not fall with the cold but by the resistance",
    "derateLowTempDCLStart": "as before", "derateLowTempDCLAmperage": "as before",
    "derateHighTempDCLAmperage": "the limit falls in a straight line to 0 at bms.temperature_max_c",
    "derateHighTempCCLStart": "the charge limit falls as the discharge limit", "derateHighTempCCLAmperage": "as before",
    "maxCclTemperature": "as before",
    "derateLowTempCCLStart": "the charge limit does not fall with the cold but by the resistance",
    "derateLowTempCCLAmperage": "as before",
    "derateLowSOCAmperage": "the limit falls in a straight line to 0 at SOC 0",
    "derateHighSOCStart": "the charge limit falls by bms.cell_voltage_max_v", "derateHighSOCAmperage": "as before",
    "depletedSOC": "SOC is that of the cell", "chargedSOC": "SOC is that of the cell",
    "balanceVoltage": "cells are balanced from bms.balancing_voltage_min_v on",
    "currentSensorSelected": "sensors.* of a vehicle file", "currentSensorType": "sensors.* of a vehicle file",
    "currentSensorMaxAmps": "sensors.* of a vehicle file", "currentSensorMinAmps": "sensors.* of a vehicle file",
    "canbusFrequency": "frames are those of can_dbc/", "canbus2Frequency": "frames are those of can_dbc/",
    "j1939Address": "frames are those of can_dbc/", "parallelStrings": "one string",
}


@dataclasses.dataclass(frozen=True)
class Line:
    key: str
    value: float
    why: str


def refuse(profile: Profile, name: str, found: str, expected: str, action: str) -> ProfileRefused:
    return ProfileRefused(profile.bean.where(name), found, expected, action)


def battery_lines(profile: Profile, cell: Cell) -> list[Line]:
    cells = profile.cells()
    if not 1 <= cells <= MOST_CELLS:
        raise refuse(profile, "totalCells", f"{cells} cells in series", f"1 to {MOST_CELLS} of our BMS",
                     "Make a pack file of each segment by hand")
    capacity_ah = profile.need("totalAmphours", "the capacity")
    parallel = min(max(round(capacity_ah / cell.capacity_ah), 1), MOST_PARALLEL)
    each_ah = capacity_ah / parallel
    if not 0.1 <= each_ah <= 1000.0:
        raise refuse(profile, "totalAmphours", f"{capacity_ah:g} Ah", "0.1 to 100000 Ah", "Correct the profile")
    where = "populationTable" if profile.populated() else "totalCells"
    return [Line("cells_in_series", cells, f"{where} (certain)"),
            Line("cells_in_parallel", parallel, f"assumed: cells of {cell.capacity_ah:g} Ah that come nearest to "
                                                f"{capacity_ah:g} Ah"),
            Line("capacity_ah", each_ah, f"totalAmphours, {capacity_ah:g} Ah (0.01 Ah, inferred), by that number")]


def current_line(profile: Profile, key: str, setting: str, table: str) -> Line:
    """The ceiling: that of the setting and the highest point of the table."""
    ceiling, points = profile.get(setting), profile.table(table)
    known = [value for value in (ceiling, max(points) if points else None) if value is not None]
    if not known:
        raise refuse(profile, setting, "nothing: the utility leaves out what has its default", f"it, or {table}",
                     "Set it in the utility to another value and back to yours")
    lowest = min(known)
    if lowest <= 0.0:
        raise refuse(profile, setting, "0 A", "a current", "Correct the profile")
    text = f"{setting} {ceiling:g} A" if ceiling is not None else f"no {setting}"
    text += f", {table} at most {max(points):g} A" if points else f", no {table}"
    return Line(key, min(lowest, MOST_A), f"{text} (inferred)" + (
        "; 1000 A is the most of our BMS" if lowest > MOST_A else ""))


def voltage_lines(profile: Profile) -> list[Line]:
    low = profile.need("minimumCellVoltage", "the lowest cell voltage")
    high = profile.need("maximumCellVoltage", "the highest cell voltage")
    if not 0.5 <= low < high <= 5.0:
        raise refuse(profile, "minimumCellVoltage", f"{low:g} V, with {high:g} V as maximumCellVoltage",
                     "0.5 V and more, below maximumCellVoltage, and that at most 5 V", "Correct the profile")
    return [Line("cell_voltage_min_v", low, "minimumCellVoltage (certain); the trip stays 0.1 V below it"),
            Line("cell_voltage_max_v", high, "maximumCellVoltage (certain); the trip stays 0.05 V above it")]


def end_of_slope_c(profile: Profile) -> float | None:
    """Where the discharge limit has fallen to nothing, by its slope."""
    start_c, per_k = profile.get("derateHighTempDCLStart"), profile.get("derateHighTempDCLAmperage")
    points = profile.table("dclTemperatureTable")
    if start_c is None or not per_k or not points:
        return None
    return start_c + max(points) / per_k


def temperature_lines(profile: Profile) -> list[Line]:
    ends = {name: profile.get(name) for name in ("hotPackTemperature", "maxDclTemperature")}
    ends["the end of the slope of the discharge limit"] = end_of_slope_c(profile)
    known = {name: value for name, value in ends.items() if value is not None}
    hot_c = min(known.values(), default=OWN_HOT_C)
    if not 0.0 < hot_c <= 100.0:
        raise refuse(profile, min(known, key=known.__getitem__), f"{hot_c:g} degC", "above 0, at most 100 degC",
                     "Correct the profile")
    said = ", ".join(f"{name} {value:g}" for name, value in known.items())
    out = [Line("temperature_max_c", hot_c, f"the lowest of {said} (inferred)" if known else
                "the profile does not say it: our default")]
    start_c = profile.get("derateHighTempDCLStart")
    if start_c is not None and -40.0 <= start_c < hot_c:
        out.append(Line("temperature_derating_start_c", start_c, "derateHighTempDCLStart (inferred)"))
    points, limit_c = profile.table("cclTemperatureTable"), profile.get("minCclTemperature")
    why = f"minCclTemperature {limit_c:g} (inferred)" if limit_c is not None else "no minCclTemperature"
    if points:
        coldest = FIRST_C + STEP_C * next((k for k, value in enumerate(points) if value > 0.0), 0)
        why += f", cclTemperatureTable from {coldest:g} degC on"
        limit_c = coldest if limit_c is None else max(limit_c, coldest)
    cold_c = OWN_COLD_CHARGE_C if limit_c is None else min(max(limit_c, OWN_COLD_CHARGE_C), 60.0)
    return [*out, Line("charge_temperature_min_c", cold_c, why + "; never below 0: lithium plates")]


def resistance_lines(profile: Profile, cell: Cell) -> list[Line]:
    """A straight line through the table's ends, raised until it lies nowhere below the table between them."""
    points_c = [COLD_C + STEP_C * k for k in range(round((HOT_C - COLD_C) / STEP_C) + 1)]
    known = [value for at_c in points_c if (value := profile.resistance_ohm(at_c)) is not None]
    if len(known) < len(points_c) or min(known) <= 0.0:
        return []
    slope = (known[-1] - known[0]) / (HOT_C - COLD_C)
    raised = max(value - slope * at_c for value, at_c in zip(known, points_c, strict=True))
    here = raised + slope * cell.reference_temperature_c
    if not 0.0 < here <= 1.0 or abs(slope / here) > 0.2:
        return []
    why = f"resistanceTable (0.01 mOhm) by intresDCMultiplier {profile.get('intresDCMultiplier'):g} (both inferred)"
    return [Line("resistance_ohm", here, f"at {cell.reference_temperature_c:g} degC, on a line above {why}"),
            Line("resistance_per_kelvin", slope / here, f"the line: nowhere below the table from {COLD_C:g} to "
                                                        f"{HOT_C:g} degC")]


def soc_and_balancing_lines(profile: Profile) -> list[Line]:
    out = []
    start_pct = profile.get("derateLowSOCStart")
    if start_pct is not None:
        out.append(Line("soc_derating_start", start_pct / 100.0, "derateLowSOCStart (1 %, inferred)"))
    least_v, delta_v = profile.get("minimumBalanceVoltage"), profile.get("balanceDeltaVoltage")
    if least_v is not None and least_v <= 5.0:
        out.append(Line("balancing_voltage_min_v", least_v, "minimumBalanceVoltage (inferred)"))
    if delta_v is not None and delta_v <= 5.0:
        out.append(Line("balancing_difference_v", delta_v, "balanceDeltaVoltage (inferred)"))
    return out


def cell_doubt(profile: Profile, cell: Cell) -> str:
    """Why the cell can hardly be the car's; empty: it may be."""
    high = profile.need("maximumCellVoltage", "the highest cell voltage")
    if cell.voltage_max_v - high <= OTHER_CELL_V:
        return ""
    return f"{cell.name} is full at {cell.voltage_max_v:g} V, and the profile ends at {high:g} V: another kind of cell?"


def bms_lines(profile: Profile, cell: Cell) -> list[Line]:
    return [current_line(profile, "discharge_current_max_a", "maximumDCL", "dclTemperatureTable"),
            current_line(profile, "charge_current_max_a", "maximumCCL", "cclTemperatureTable"),
            *voltage_lines(profile), *temperature_lines(profile), *resistance_lines(profile, cell),
            *soc_and_balancing_lines(profile)]


def sensor_line(profile: Profile) -> Line:
    least = -(-profile.cells() // 5)
    return Line("temperature_count", max(least, 1), "EV.7.5: a fifth of the cells; the thermistors are not read")


def text_of(line: Line) -> str:
    assignment = f"{line.key} = {line.value:.7g}"
    return f"{assignment:<38}# {line.why}"


def without_counterpart(profile: Profile) -> list[str]:
    out = []
    for name, instead in WITHOUT_COUNTERPART.items():
        value = profile.get(name)
        if value is not None:
            out.append(f"{name} {value:g} {SETTINGS[name].unit}".rstrip() + f": {instead}")
    for name, table in TABLES.items():
        if name != "resistanceTable" and profile.table(name):
            out.append(f"{name}: its highest point is the ceiling above; our BMS has no table of {table.what}")
    out.append("driftPoints: the SOC is started from the cell's OCV at rest, not drawn to points of voltage")
    return out


def pack_text(profile: Profile, cell: Cell) -> str:
    """The whole file; raises ProfileRefused for a profile that gives no pack of ours."""
    name = pathlib.Path(profile.bean.path).name
    shown = "".join(sign if sign.isprintable() and sign.isascii() else "?" for sign in name)
    battery, bms = battery_lines(profile, cell), bms_lines(profile, cell)
    by = "assumed: a profile does not say what cells it is for" if cell.assumed else "by --cell"
    doubt = cell_doubt(profile, cell)
    lines = [f"# Pack of an Orion BMS, from its profile {shown} by `voltlap orion import`; docs/orion.md says which",
             "# scales are certain and which are inferred.", 'name = "orion"', "", "[battery]",
             f"{'cell = ' + cell.toml_name():<38}# {by}", *([f"# {doubt}"] if doubt else []),
             *map(text_of, battery), "", "[bms]",
             *map(text_of, bms), "", "[sensors]", text_of(sensor_line(profile)), "",
             "# In the profile, without a counterpart here:",
             *(f"#   {line}" for line in without_counterpart(profile)),
             f"# Not understood, and used for nothing: {len(profile.not_understood())} properties; "
             "`voltlap orion show --all` lists them."]
    return "\n".join(lines) + "\n"
