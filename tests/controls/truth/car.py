# SPDX-License-Identifier: Apache-2.0
"""The car under the driver: which torque, pedals and power a given speed takes. Arrays are (cases, steps).

The speed is prescribed and the rest follows from it, so that two runs with and without an effect are the same drive
and their difference is the effect alone. Tyres slip by a law of their own (H. B. Pacejka's similarity form with an
exponential), losses are copper, iron, switching and drag losses of a permanent-magnet machine.
"""
import dataclasses

import numpy as np

GRAVITY = 9.80665
AIR = 1.2041  # kg/m3, dry, 20 degC, 101 325 Pa
DISC_LAG_S, DISC_K_PER_W = 120.0, 0.03  # brake discs, of all friction's power


@dataclasses.dataclass
class Car:
    """Arrays (cases, 1)."""

    mass_kg: np.ndarray
    drag_area_m2: np.ndarray
    rolling: np.ndarray
    tyre_radius_m: np.ndarray
    gear: np.ndarray
    friction: np.ndarray
    slip_stiffness: np.ndarray  # force over load and slip
    rotating_kg: np.ndarray  # wheels and rotor, as mass at the tyre
    torque_max_nm: np.ndarray
    copper_w_per_nm2: np.ndarray
    iron_w_per_rad_s: np.ndarray
    switching_share: np.ndarray  # of the power through the inverter
    base_rad_per_s: np.ndarray
    weakening_w: np.ndarray  # extra copper loss at twice the base speed
    auxiliary_w: np.ndarray
    regeneration: np.ndarray  # share of braking that the motor takes
    winding_k_per_w: np.ndarray
    winding_lag_s: np.ndarray
    brake_max_n: np.ndarray
    # What may be wrong: nothing in a sound car.
    wind_mps: np.ndarray = 0.0
    slope: np.ndarray = 0.0
    constant_change: np.ndarray = 0.0  # true over reported torque, minus 1
    torque_per_k: np.ndarray = 0.0
    fade_per_k: np.ndarray = 0.0
    loss_change: np.ndarray = 0.0
    slip_change: np.ndarray = 0.0


def design(rng, cases):
    def make(low, high):
        return rng.uniform(low, high, (cases, 1))

    return Car(
        mass_kg=make(270.0, 340.0), drag_area_m2=make(0.8, 1.4), rolling=make(0.011, 0.018),
        tyre_radius_m=make(0.20, 0.235), gear=make(2.6, 3.8), friction=make(1.3, 1.6),
        slip_stiffness=make(14.0, 22.0), rotating_kg=make(8.0, 16.0),
        torque_max_nm=make(110.0, 160.0), copper_w_per_nm2=make(0.10, 0.2), iron_w_per_rad_s=make(0.4, 0.9),
        switching_share=make(0.02, 0.04), base_rad_per_s=make(220.0, 300.0), weakening_w=make(200.0, 500.0),
        auxiliary_w=make(120.0, 260.0), regeneration=np.zeros((cases, 1)), winding_k_per_w=make(0.03, 0.06),
        winding_lag_s=make(200.0, 400.0), brake_max_n=make(6000.0, 8000.0))


@dataclasses.dataclass
class Demand:
    speed_mps: np.ndarray
    wheel_speed_mps: np.ndarray  # of the driven wheel: radius times its rate
    motor_rad_per_s: np.ndarray
    torque_nm: np.ndarray  # what the inverter reports
    accelerator: np.ndarray
    brake: np.ndarray
    power_w: np.ndarray  # at the terminals of the pack


def lagged(signal, lag_s, step_s):
    """First-order lag along the steps; lag (cases, 1)."""
    out = np.empty_like(signal)
    state = np.zeros(signal.shape[0])
    share = (1.0 - np.exp(-step_s / np.asarray(lag_s)))[:, 0]
    for k in range(signal.shape[1]):
        state = state + share * (signal[:, k] - state)
        out[:, k] = state
    return out


def force_n(car: Car, speed, slope, pull):
    """What moves the car or, below zero, slows it down at this speed [m/s], slope and pull [m/s2]."""
    air = speed + car.wind_mps
    resist = 0.5 * AIR * car.drag_area_m2 * air * np.abs(air) + car.mass_kg * GRAVITY * (car.rolling + slope + car.slope)
    return np.where(speed > 0.05, (car.mass_kg + car.rotating_kg) * pull + resist, 0.0)


def drive(car: Car, speed, slope, step_s, pull=None) -> Demand:
    """What the prescribed speed [m/s] asks of motor, brakes and pack; pull [m/s2]: of the speed, when not given."""
    pull = np.gradient(speed, step_s, axis=1) if pull is None else pull
    moving = speed > 0.05
    force = force_n(car, speed, slope, pull)
    load = 0.6 * car.mass_kg * GRAVITY
    drawn = np.clip(force, 0.0, None)
    braking = np.clip(-force, 0.0, None)
    by_motor = car.regeneration * braking
    used = np.clip((drawn - by_motor) / (car.friction * load), -0.97, 0.97)
    # Exponential tyre: force/(friction load) = 1 - exp(-stiffness slip/friction).
    slip = -np.sign(used) * np.log1p(-np.abs(used)) * car.friction / car.slip_stiffness * (1.0 + car.slip_change)
    wheel = speed * (1.0 + slip)
    motor = wheel / car.tyre_radius_m * car.gear
    shaft = (drawn - by_motor) * car.tyre_radius_m / car.gear
    first_loss = car.copper_w_per_nm2 * shaft ** 2
    warm = lagged(first_loss, car.winding_lag_s, step_s) * car.winding_k_per_w
    true_over_reported = (1.0 + car.constant_change) * (1.0 + car.torque_per_k * warm)
    reported = shaft / true_over_reported
    beyond = np.clip(motor / car.base_rad_per_s - 1.0, 0.0, None)
    loss = (car.copper_w_per_nm2 * reported ** 2 * (1.0 + 0.0039 * warm) + car.iron_w_per_rad_s * motor
            + car.weakening_w * beyond ** 2 * (reported != 0.0) + car.switching_share * np.abs(shaft * motor))
    power = shaft * motor + loss * (1.0 + car.loss_change) * moving + car.auxiliary_w
    friction_force = braking - by_motor
    disc = lagged(friction_force * speed, np.full_like(car.mass_kg, DISC_LAG_S), step_s) * DISC_K_PER_W
    brake = friction_force / (car.brake_max_n * np.clip(1.0 + car.fade_per_k * disc, 0.2, None))
    accelerator = np.clip(reported / car.torque_max_nm, 0.0, 1.0)
    return Demand(speed, wheel, motor, reported, accelerator, np.clip(brake, 0.0, 1.0), power)
