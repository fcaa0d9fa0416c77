// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/full_torque.hpp"

#include <algorithm>
#include <cmath>

#include "car/battery/cell_tables.hpp"
#include "car/powertrain/motor.hpp"
#include "car/powertrain/torque_curve.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kPoints = 512;

/// The pack as a source: what is left of its voltage under a load.
struct Source {
  double open_v, ohm;

  /// Bus voltage [V] under a constant power; beyond what the pack can give, that of its greatest power.
  [[nodiscard]] double voltage(double power_w) const {
    return 0.5 * (open_v + std::sqrt(std::max(0.0, open_v * open_v - 4.0 * ohm * power_w)));
  }
  [[nodiscard]] double power_max_w() const { return ohm > 0.0 ? open_v * open_v / (4.0 * ohm) : 1e9; }
};

Source pack_at_start(const VehicleParameters& car) {
  const CellTables tables(car.cell);
  const BatterySection& battery = car.battery;
  const double soc = battery.initial_soc, temperature = battery.initial_temperature_c;
  const CircuitParameters cell = tables.circuit(soc, temperature, car.cell.reference_current_a);
  const double groups = battery.cells_in_series;
  return {groups * tables.ocv_v(soc, temperature),
          groups * cell.r0_ohm / battery.cells_in_parallel + battery.contact_resistance_ohm +
              car.contactors.resistance_ohm};
}

/// Power at the DC bus [W] for a shaft torque.
double bus_power(const VehicleParameters& car, double torque_nm, double omega_rad_s) {
  const double current = torque_nm / (car.motor.constant_nm_per_a * car.motor.efficiency);
  return motor_power(car.motor, current, omega_rad_s) / car.inverter.efficiency + car.low_voltage.power_w;
}

/// The greatest part of a torque whose power the bus may give.
double within_power(const VehicleParameters& car, double torque_nm, double omega_rad_s, double power_w) {
  if (bus_power(car, torque_nm, omega_rad_s) <= power_w) return torque_nm;
  double low = 0.0, high = torque_nm;
  for (int k = 0; k < 40; ++k) {
    const double middle = 0.5 * (low + high);
    (bus_power(car, middle, omega_rad_s) <= power_w ? low : high) = middle;
  }
  return low;
}

}  // namespace

FullTorque::FullTorque(const VehicleParameters& car) {
  const MotorSection& motor = car.motor;
  const TorqueCurve curve(motor);
  const Source source = pack_at_start(car);
  const double by_current = motor.constant_nm_per_a * car.inverter.current_max_a * motor.efficiency;
  const double power = std::min(1e3 * car.master.power_max_kw, source.power_max_w());
  // The master controller turns its power limit into a current by its own guess of the drive's efficiency.
  const double by_master_w = 1e3 * car.master.power_max_kw * car.master.drive_efficiency * motor.efficiency;
  const double top = motor.curve_speed_rpm.back() * M_PI / 30.0;
  VOLTLAP_DEMAND(top > 0.0 && source.open_v > 0.0);

  points_per_speed_ = kPoints / top;
  for (std::size_t i = 0; i <= kPoints; ++i) {
    const double omega = static_cast<double>(i) / points_per_speed_;
    double torque = 0.0, voltage = source.open_v;
    for (int round = 0; round < 20; ++round) {
      double wanted = std::min(by_current, curve.torque_nm(omega, voltage));
      if (wanted * omega > by_master_w) wanted = by_master_w / omega;
      torque = within_power(car, wanted, omega, power);
      // Less voltage, less torque, more voltage: half a step at a time settles.
      voltage = 0.5 * (voltage + source.voltage(bus_power(car, torque, omega)));
      if (motor.curve_voltage_v <= 0.0) break;
    }
    torque_nm_.push_back(torque);
  }
  VOLTLAP_DEMAND(all_finite(torque_nm_));
}

}  // namespace voltlap::plant
