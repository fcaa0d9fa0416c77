# SPDX-License-Identifier: Apache-2.0
"""The models that the tool is given: what a careful team would have identified from its own tests of a sound car.

Cells are pulsed at three temperatures and their tables come from `voltlap identify`; heat capacity and cooling from a
test with a constant current; a car's losses from one sound drive. The tool's model is another physics than the truth,
so it never fits exactly.
"""

import dataclasses
import re
import subprocess

import numpy as np
from truth import car as cars
from truth import cell as chemistry
from truth import drive, world

ZERO_C = 273.15
PULSE_STEP_S = 1.0
TEMPERATURES_C = (12.0, 25.0, 40.0)
RATES = (0.5, 1.5, 4.0)  # of the capacity in an hour: one test each, as the tables over current want them
HEAT_STEP_S = 1.0


def mean_cells(cells):
    """One cell a case: the mean of the pack's."""
    made = {}
    for each in dataclasses.fields(cells):
        value = np.asarray(getattr(cells, each.name), float)
        made[each.name] = value.mean(1, keepdims=True)
    return dataclasses.replace(cells, **made)


def _repeated(cells, times):
    return dataclasses.replace(
        cells, **{each.name: np.repeat(getattr(cells, each.name), times, 0) for each in dataclasses.fields(cells)}
    )


def pulse_tests(cells, family="particle"):
    """[case][test] -> (time_s, current_a, voltage_v, temperature_c) of mean cells, computed side by side.

    One test for each temperature and rate, temperatures outside.
    """
    cases, count = cells.capacity_ah.shape[0], len(TEMPERATURES_C) * len(RATES)
    shapes = [drive.pulse_test(1.0, PULSE_STEP_S, rate) for rate in RATES]
    longest = max(shape.size for shape in shapes)
    shapes = np.stack([np.pad(shape, (0, longest - shape.size)) for shape in shapes])
    shapes = np.tile(shapes, (len(TEMPERATURES_C), 1))
    current = (cells.capacity_ah.mean(1)[:, None, None] * shapes[None]).reshape(cases * count, longest)
    many = _repeated(mean_cells(cells), count)
    air_k = np.tile(np.repeat(np.array(TEMPERATURES_C) + ZERO_C, len(RATES)), cases)
    pack = world.FAMILIES[family](many, np.ones((cases * count, 1)), air_k[:, None])
    # A temperature box blows: the cells hardly warm.
    pack.p.air_w_per_k *= 20.0
    history = chemistry.run(
        pack, PULSE_STEP_S, air_k, np.zeros((cases * count, longest), bool), current
    )
    return [
        [
            (
                history.time_s,
                current[k * count + j],
                history.voltage_v[k * count + j, :, 0],
                history.surface_k[k * count + j, :, 0] - ZERO_C,
            )
            for j in range(count)
        ]
        for k in range(cases)
    ]


def heat_of(cells, family="particle"):
    """Heat capacity [J/K], way to the air [W/K] and lag of the surface [s], (cases, 3), from ten minutes at 2C and a rest.

    With T of the surface above the air, which is L behind one mass of heat: (C + h L) T + C L dT/dt = heat - h integral
    of T, by least squares over the test. Nothing of it knows how the truth divides its heat.
    """
    mean = mean_cells(cells)
    cases = mean.capacity_ah.shape[0]
    steps = int(3000.0 / HEAT_STEP_S)
    current = np.zeros((cases, steps))
    current[:, 10:610] = 2.0 * mean.capacity_ah
    pack = world.FAMILIES[family](mean, np.full((cases, 1), 0.9), chemistry.REFERENCE_K)
    air_k = np.full(cases, chemistry.REFERENCE_K)
    history = chemistry.run(pack, HEAT_STEP_S, air_k, np.zeros((cases, steps), bool), current)
    power = current * (chemistry.open_circuit(history.charge[:, :, 0]) - history.voltage_v[:, :, 0])
    rise = history.surface_k[:, :, 0] - air_k[:, None]
    out = []
    for watts, warm in zip(power, rise):
        heat, away = ((np.cumsum(each) - each) * HEAT_STEP_S for each in (watts, warm))  # till the row
        columns = np.stack([warm, away, np.gradient(warm, HEAT_STEP_S)], 1)
        (both, conductance, lagging), *_ = np.linalg.lstsq(columns, heat, rcond=None)
        lag = max(0.0, 2.0 * lagging / (both + np.sqrt(both**2 - 4.0 * conductance * lagging)))
        out.append((both - conductance * lag, conductance, lag))
    return np.array(out)


def write_pulse_test(path, rng, test):
    noise = rng.standard_normal((2, test[0].size))
    rows = zip(test[0], test[1], test[2] + 2e-4 * noise[0], test[3] + 0.05 * noise[1])
    text = "\n".join("%.0f,%.3f,%.5f,%.2f" % row for row in rows)
    path.write_text("time_s,current_a,voltage_v,temperature_c\n" + text + "\n")


def identify(tool, folder, rng, tests, heat):
    """A cell file in the folder, from the pulse tests of one world."""
    files = []
    for number, test in enumerate(tests):
        files.append(folder / f"pulses_{number}.csv")
        write_pulse_test(files[-1], rng, test)
    out = folder / "cell.toml"
    result = subprocess.run(
        # A row's current flows from that row on: the team knows its cycler.
        [str(tool), "identify", *map(str, files), "--rc", "2", "--hold", "previous", "--out", str(out)],
        capture_output=True,
        text=True,
    )
    if result.returncode != 0:
        raise RuntimeError("voltlap identify failed on the bank's pulse tests: " + result.stderr.strip())
    for file in files:
        file.unlink()
    out.write_text(with_heat(out.read_text(), *heat))
    return out


def with_heat(text, capacity_j_per_k, conductance_w_per_k, surface_lag_s):
    """The cell file with the heat of the test: a mass of 1 kg, a surface of 0.1 m2."""
    values = {
        "mass_kg": 1.0,
        "heat_capacity_j_per_kg_k": capacity_j_per_k,
        "surface_area_m2": 0.1,
        "convection_w_per_m2_k": conductance_w_per_k / 0.1,
        "surface_lag_s": surface_lag_s,
    }
    for key, value in values.items():
        text, count = re.subn(rf"^{key} = .*$", f"{key} = {value:.6g}  # from a heat test", text, flags=re.MULTILINE)
        if count != 1:
            raise RuntimeError(f"the cell file has no single line {key}")
    return text


def pack_file(cells, initial_c, cell_name="cell.toml"):
    return (
        f'[battery]\ncell = "{cell_name}"\ncells_in_series = {cells}\ncells_in_parallel = 1\ninitial_soc = 1.0\n'
        f"initial_temperature_c = {initial_c:.1f}\nlookup_current_floor_a = 5.0\n"
    )


def car_file(car, cells, ambient_c, losses, cell_name="cell.toml"):
    """A vehicle file for one case of a truth's cars; `losses` from losses_of()."""

    def one(value):
        return float(np.ravel(np.broadcast_to(value, (1, 1)))[0])

    torque, base = one(car.torque_max_nm), one(car.base_rad_per_s)
    speeds = np.arange(0.0, 10001.0, 500.0)
    curve = np.minimum(torque, torque * base / np.maximum(speeds * 2 * np.pi / 60, 1e-9))
    radius = one(car.tyre_radius_m)
    friction, stiffness = one(car.friction), one(car.slip_stiffness)
    return "\n".join(
        [
            'base = "vtm16e"',
            'name = "car"',
            "[vehicle]",
            f"mass_kg = {one(car.mass_kg):.2f}",
            "driver_mass_kg = 1.0",
            "front_axle_inertia_kg_m2 = 0.01",
            "[tyres]",
            f"radius_m = {radius:.4f}",
            f"lap_radius_m = {radius:.4f}",
            f"rolling_resistance = {one(car.rolling):.5f}",
            # The slope at no slip is B C D times the load, as the truth's tyre has it.
            f"pacejka_b = {stiffness / (1.5 * friction):.4f}",
            "pacejka_c = 1.5",
            f"pacejka_d = {friction:.4f}",
            "pacejka_e = 0.0",
            "[aero]",
            "drag_coefficient = 1.0",
            f"frontal_area_m2 = {one(car.drag_area_m2):.4f}",
            "downforce_coefficient = 0.0",
            "[powertrain]",
            f"final_drive = {one(car.gear):.4f}",
            f"driveline_inertia_kg_m2 = {one(car.rotating_kg) * radius ** 2:.4f}",
            "[brakes]",
            *brake_lines(one(car.brake_max_n), radius),
            "[inverter]",
            f"efficiency = {losses['efficiency']:.5f}",
            f"current_max_a = {torque / 0.25:.1f}",
            "[motor]",
            "constant_nm_per_a = 0.25",
            "efficiency = 1.0",
            "winding_loss = true",
            f"winding_resistance_ohm = {losses['copper_w_per_nm2'] * 0.25 ** 2:.6f}",
            "curve_speed_rpm = [" + ", ".join(f"{s:.0f}" for s in speeds) + "]",
            "curve_torque_nm = [" + ", ".join(f"{t:.2f}" for t in curve) + "]",
            "[low_voltage]",
            f"power_w = {losses['auxiliary_w']:.1f}",
            "[environment]",
            f"ambient_c = {ambient_c:.1f}",
            "air_density_kg_per_m3 = 1.2041",
            "gravity_mps2 = 9.80665",
            pack_file(cells, ambient_c, cell_name),
        ]
    )


def brake_lines(force_n, radius_m):
    """Calipers for that force at the tyres: torque = pedal x caliper force x friction x rotor radius x two wheels.

    Discs that warm as the truth's do: each of an axle's two takes half of the axle's share of the power.
    """
    front, rear = 0.6, 0.4
    heat_j_per_kg_k, convection_w_per_m2_k = 500.0, 80.0
    cooling = {name: 0.5 * share / cars.DISC_K_PER_W for name, share in (("front", front), ("rear", rear))}  # W/K
    caliper = {
        "front": front * force_n * radius_m / (2 * 0.5 * 0.08),
        "rear": rear * force_n * radius_m / (2 * 0.5 * 0.06),
    }
    return [
        "front_friction = 0.5",
        "rear_friction = 0.5",
        "front_radius_m = 0.08",
        "rear_radius_m = 0.06",
        f"front_caliper_force_n = {caliper['front']:.1f}",
        f"rear_caliper_force_n = {caliper['rear']:.1f}",
        "force_scale = 1.0",
        *(f"{name}_rotor_mass_kg = {w * cars.DISC_LAG_S / heat_j_per_kg_k:.3f}" for name, w in cooling.items()),
        f"rotor_heat_capacity_j_per_kg_k = {heat_j_per_kg_k}",
        *(f"{name}_rotor_area_m2 = {w / convection_w_per_m2_k:.4f}" for name, w in cooling.items()),
        f"convection_w_per_m2_k = {convection_w_per_m2_k}",
    ]


def losses_of(log):
    """Efficiency, copper loss, auxiliary load of a sound drive: V I = mechanical/eta + copper torque^2 + auxiliary."""
    power = log["pack_voltage"] * log["current"]
    mechanical = log["motor_torque"] * log["motor_speed"]
    standing = log["speed"] < 0.05
    auxiliary = float(np.median(power[standing]))
    moving = ~standing
    columns = np.stack([mechanical[moving], log["motor_torque"][moving] ** 2], 1)
    (inverse, copper), *_ = np.linalg.lstsq(columns, power[moving] - auxiliary, rcond=None)
    return {
        "efficiency": float(min(1.0, 1.0 / inverse)),
        "copper_w_per_nm2": float(max(copper, 1e-4)),
        "auxiliary_w": auxiliary,
    }
