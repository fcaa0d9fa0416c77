# SPDX-License-Identifier: Apache-2.0
"""A drive as an Orion unit with its factory frames tells it (can_dbc/orion.dbc): cells with a straight OCV, a unit that
allows less than the firmware does and whose SOC jumps."""
import struct

CELLS, CAPACITY_AH, RESISTANCE = 12, 9.0, 0.003
PACK = f"""
name = "straight"
[battery]
cell = "molicel_p42a"
cells_in_series = {CELLS}
cells_in_parallel = 2
[bms]
capacity_ah = {CAPACITY_AH}
ocv_soc = [0.0, 1.0]
ocv_v = [3.0, 4.0]
resistance_ohm = {RESISTANCE}
cell_voltage_min_v = 3.1
cell_voltage_max_v = 4.1
cell_voltage_trip_low_v = 2.9
discharge_current_max_a = 300
charge_current_max_a = 100
"""
BEGIN_S = 1_700_000_000


def signed(identifier, data):
    """The unit's checksum: identifier, length and bytes, as a byte."""
    return data + bytes([(identifier + 8 + sum(data)) & 0xFF])


def current_at(time_s):
    return 0.0 if time_s < 1.5 or time_s % 2.0 > 1.6 else 60.0


def frames(seconds):
    """[(time in us, identifier, data)], one frame of cells and one of the pack every 10 ms, limits every 100 ms."""
    charge_ah = 0.0
    for tick in range(int(100 * seconds)):
        time_s = tick / 100
        amps = current_at(time_s)
        charge_ah += amps / 100 / 3600
        soc = 0.8 - charge_ah / CAPACITY_AH
        volts = 3.0 + soc - RESISTANCE * amps
        told = soc - (0.24 if time_s > 3.0 else 0.0)
        at_us = BEGIN_S * 10**6 + 10_000 * tick
        cell = struct.pack(">BHHH", tick % CELLS, round(1e4 * volts), 300, round(1e4 * (3.0 + soc)))
        yield at_us, 0x036, signed(0x036, cell)
        pack = struct.pack(">hHBH", round(10 * amps), round(10 * CELLS * volts), round(200 * told), 0)
        yield at_us + 1500, 0x6B0, signed(0x6B0, pack)
        if tick % 10 == 6:
            yield at_us + 2500, 0x6B1, signed(0x6B1, struct.pack(">HBBbbB", 120, 40, 0, 30, 29, 0))


def candump(path, seconds):
    path.write_text("".join(f"({t // 10**6}.{t % 10**6:06}) can0 {i:03X}#{d.hex().upper()}\n"
                            for t, i, d in frames(seconds)))
    return path
