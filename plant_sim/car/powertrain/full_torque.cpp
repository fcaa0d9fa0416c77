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

/// What a full pedal asks of motor and pack. Each bound that a torque keeps, a smaller one keeps too: the bus voltage
/// falls with the torque, and the curve with the voltage.
class Bounds {
 public:
  explicit Bounds(const VehicleParameters& car) : car_(car), curve_(car.motor), source_(pack_at_start(car)) {
    VOLTLAP_DEMAND(source_.open_v > 0.0);
    power_w_ = std::min(1e3 * car.master.power_max_kw, source_.power_max_w());
    const double lowest_v = car.battery.cells_in_series * car.bms.cell_voltage_min_v.value_or(car.cell.voltage_min_v);
    current_a_ = car.bms.discharge_current_max_a;
    if (source_.ohm > 0.0) current_a_ = std::min(current_a_, std::max(0.0, source_.open_v - lowest_v) / source_.ohm);
  }

  [[nodiscard]] bool keeps(double torque_nm, double omega_rad_s) const {
    const double power = bus_power(car_, torque_nm, omega_rad_s);
    if (power > power_w_) return false;
    const double voltage = source_.voltage(power);
    return power <= current_a_ * voltage && torque_nm <= curve_.torque_nm(omega_rad_s, voltage);
  }

  /// The greatest torque up to `wanted_nm` that keeps them.
  [[nodiscard]] double greatest(double wanted_nm, double omega_rad_s) const {
    if (keeps(wanted_nm, omega_rad_s)) return wanted_nm;
    constexpr int kHalvings = 60;
    double low = 0.0, high = wanted_nm;
    for (int k = 0; k < kHalvings; ++k) {
      const double middle = 0.5 * (low + high);
      (keeps(middle, omega_rad_s) ? low : high) = middle;
    }
    return low;
  }

 private:
  const VehicleParameters& car_;
  TorqueCurve curve_;
  Source source_;
  double power_w_, current_a_;
};

}  // namespace

FullTorque::FullTorque(const VehicleParameters& car) {
  const MotorSection& motor = car.motor;
  const Bounds bounds(car);
  const double by_current = motor.constant_nm_per_a * car.inverter.current_max_a * motor.efficiency;
  // The master controller turns its power limit into a current by its own guess of the drive's efficiency.
  const double by_master_w = 1e3 * car.master.power_max_kw * car.master.drive_efficiency * motor.efficiency;
  const double top = motor.curve_speed_rpm.back() * M_PI / 30.0;
  VOLTLAP_DEMAND(top > 0.0);

  points_per_speed_ = kPoints / top;
  for (std::size_t i = 0; i <= kPoints; ++i) {
    const double omega = static_cast<double>(i) / points_per_speed_;
    const double wanted = by_current * omega > by_master_w ? by_master_w / omega : by_current;
    torque_nm_.push_back(bounds.greatest(wanted, omega));
  }
  VOLTLAP_DEMAND(all_finite(torque_nm_));
}

}  // namespace voltlap::plant
