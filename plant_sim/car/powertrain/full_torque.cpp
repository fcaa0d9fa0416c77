// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/full_torque.hpp"

#include <algorithm>
#include <cmath>

#include "car/battery/cell_tables.hpp"
#include "car/powertrain/inverter.hpp"
#include "car/powertrain/motor.hpp"
#include "car/powertrain/torque_curve.hpp"
#include "core/axle_motors.hpp"
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

/// What a full pedal asks of motor and pack. Each bound that a torque keeps, a smaller one keeps too: the bus voltage
/// falls with the torque, and the curve with the voltage.
class Bounds {
 public:
  explicit Bounds(const VehicleParameters& car) :
      car_(car), axles_(driving_axles(car.powertrain)), curve_(car.motor), source_(pack_at_start(car)) {
    VOLTLAP_DEMAND(source_.open_v > 0.0);
    power_w_ = std::min(1e3 * car.master.power_max_kw, source_.power_max_w());
    const double lowest_v = car.battery.cells_in_series * car.bms.cell_voltage_min_v.value_or(car.cell.voltage_min_v);
    current_a_ = car.bms.discharge_current_max_a;
    if (source_.ohm > 0.0) current_a_ = std::min(current_a_, std::max(0.0, source_.open_v - lowest_v) / source_.ohm);
  }

  [[nodiscard]] double power_max_w() const {
    return std::min(power_w_, current_a_ * std::max(0.0, source_.open_v - current_a_ * source_.ohm));
  }

  /// The greatest torque of the shafts that keeps them, where the current makes `wanted_nm` of which the drag takes its
  /// part; the drag alone where the motors may have no current.
  [[nodiscard]] double greatest(double wanted_nm, double omega_rad_s) const {
    const double drag = car_.powertrain.motors * motor_drag(car_.motor, omega_rad_s);
    if (keeps(wanted_nm - drag, drag, omega_rad_s)) return wanted_nm - drag;
    constexpr int kHalvings = 60;
    double low = 0.0 - drag, high = wanted_nm - drag;
    for (int k = 0; k < kHalvings; ++k) {
      const double middle = 0.5 * (low + high);
      (keeps(middle, drag, omega_rad_s) ? low : high) = middle;
    }
    return low;
  }

 private:
  [[nodiscard]] bool keeps(double shaft_nm, double drag_nm, double omega_rad_s) const {
    const Load load = load_of(shaft_nm + drag_nm, omega_rad_s);
    if (load.power_w > power_w_ || load.power_w > current_a_ * load.voltage_v) return false;
    const double most = curve_.torque_nm(omega_rad_s, load.voltage_v), own_drag = motor_drag(car_.motor, omega_rad_s);
    const auto within_curve = [&](const AxleMotors& motors) {
      return motors.each(shaft_nm) + (motors.each(drag_nm) - own_drag) <= most;
    };
    return most > 0.0 && within_curve(axles_.rear) && (axles_.front.count == 0 || within_curve(axles_.front));
  }

  struct Load {
    double power_w, voltage_v;  ///< at the DC bus
  };

  /// For a torque before the drag; the winding is as warm as the air, as it is at the start. Switching loses by the
  /// voltage that the power leaves: a few rounds settle both.
  [[nodiscard]] Load load_of(double torque_nm, double omega_rad_s) const {
    const double rear = motor_current(car_.motor, axles_.rear.each(torque_nm), omega_rad_s);
    const double front = motor_current(car_.motor, axles_.front.each(torque_nm), omega_rad_s);
    const auto dc_w = [&](double current) {
      return inverter_dc_power(car_.inverter,
                               motor_power(car_.motor, current, omega_rad_s, car_.environment.ambient_c));
    };
    const double without_stage = axles_.front.count * dc_w(front) + axles_.rear.count * dc_w(rear) +
                                 car_.low_voltage.power_w;
    const int rounds = car_.inverter.loss_w_per_v_a > 0.0 ? 4 : 1;
    Load load{0.0, source_.open_v};
    for (int round = 0; round < rounds; ++round) {
      const double stages = axles_.front.count * inverter_stage_loss(car_.inverter, front, load.voltage_v) +
                            axles_.rear.count * inverter_stage_loss(car_.inverter, rear, load.voltage_v);
      load.power_w = without_stage + stages;
      load.voltage_v = source_.voltage(load.power_w);
    }
    return load;
  }

  const VehicleParameters& car_;
  DrivenAxles axles_;
  TorqueCurve curve_;
  Source source_;
  double power_w_, current_a_;
};

}  // namespace

FullTorque::FullTorque(const VehicleParameters& car) {
  const MotorSection& motor = car.motor;
  const Bounds bounds(car);
  bus_power_max_w_ = bounds.power_max_w();
  const double by_current = motor.constant_nm_per_a * full_phase_current_a(car) * motor.efficiency;
  const double top = motor.curve_speed_rpm.back() * M_PI / 30.0;
  VOLTLAP_DEMAND(top > 0.0);

  points_per_speed_ = kPoints / top;
  for (std::size_t i = 0; i <= kPoints; ++i) {
    const double omega = static_cast<double>(i) / points_per_speed_;
    torque_nm_.push_back(bounds.greatest(by_current, omega));
  }
  beyond_nm_ = 0.0 - car.powertrain.motors * motor_drag(motor, top);
  VOLTLAP_DEMAND(all_finite(torque_nm_) && std::isfinite(beyond_nm_));
}

}  // namespace voltlap::plant
