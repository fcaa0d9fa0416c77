// SPDX-License-Identifier: Apache-2.0
#include "car/car.hpp"

#include <cmath>

#include "car/powertrain/driveline.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {

Car::Car(const VehicleParameters& parameters, bool representative_cell, double step_s)
    : contactors(parameters.contactors),
      inverter(parameters.inverter),
      pm100(parameters.inverter, parameters.motor.constant_nm_per_a),
      charger(parameters.charger),
      parameters_(parameters),
      step_s_(step_s),
      pack_(parameters_, representative_cell, step_s),
      vehicle_(parameters_),
      torque_curve_(parameters_.motor),
      motor_thermal_(parameters.motor, parameters.environment.ambient_c),
      rotors_(parameters.brakes, parameters.environment.ambient_c),
      dc_link_(parameters.contactors),
      has_pm100_(parameters.inverter.protocol == "pm100") {
  VOLTLAP_DEMAND(step_s > 0.0);
}

double Car::low_voltage_w() const {
  // The DC/DC converter starts behind the main contactors: the precharge resistor could not feed it.
  // A charger feeds the low-voltage system itself.
  const bool starts = contactors.main_closed() && dc_link_.voltage() >= parameters_.inverter.dc_voltage_min_v;
  return starts && !charger.plugged ? parameters_.low_voltage.power_w : 0.0;
}

double Car::current_of(double asked_a, double omega_rad_s) const {
  if (asked_a * omega_rad_s <= 0.0) return torque_curve_.current(asked_a, omega_rad_s, dc_link_.voltage());
  // What flows takes from the voltage, and the voltage from what may flow. The voltage before would have the motor on
  // and off, step by step, where its curve is steep.
  const PackThevenin source = pack_.thevenin();
  const double copper_c = motor_thermal_.copper_c(), low_voltage = low_voltage_w();
  const auto allowed = [&](double current) {
    const double motor_w = motor_power(parameters_.motor, current, omega_rad_s, copper_c);
    const double load = inverter.dc_power(motor_w) + inverter.stage_loss(current, dc_link_.voltage()) + low_voltage;
    const double voltage =
        dc_link_.voltage_under(source.voltage_v, source.resistance_ohm, contactors.conductance(), load, step_s_);
    return torque_curve_.current(asked_a, omega_rad_s, voltage);
  };
  double low = allowed(asked_a);
  if (low == asked_a) return asked_a;
  double high = allowed(low);
  if (high == low) return low;  // where the curve is flat
  constexpr int kHalvings = 24;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (std::abs(allowed(middle)) >= std::abs(middle) ? low : high) = middle;
  }
  return low;
}

void Car::step(double brake_pedal) {
  const double dc_voltage = dc_link_.voltage();
  const bool electric = parameters_.powertrain.kind == "electric";
  const double asked = electric ? inverter.current(dc_voltage) : 0.0;

  // Mechanics first: the torque follows the current, and the power is then known at the mean speed of the step.
  const double omega = motor_omega_rad_s();
  const double current = current_of(asked, omega);
  const bool driving = current * omega >= 0.0;
  const double drag = electric ? motor_drag(parameters_.motor, omega) : 0.0;
  const double shaft_torque = motor_torque(parameters_.motor, current, omega) - drag;
  const bool pushing = shaft_torque * omega >= 0.0;
  const double torque = wheel_torque(parameters_.powertrain, shaft_torque, pushing);
  const VehicleEnergy v = vehicle_.advance(torque, brake_pedal, step_s_);

  const double omega_mean = vehicle_.rear_omega_mean() * parameters_.powertrain.final_drive;
  const double copper_c = motor_thermal_.copper_c();
  const double motor_w = motor_power(parameters_.motor, current, omega_mean, copper_c);
  const double stage_w = electric ? inverter.stage_loss(current, dc_voltage) : 0.0;
  const double inverter_w = inverter.dc_power(motor_w) + stage_w;
  const double low_voltage = low_voltage_w();
  const double charger_w = charger.current_a() * dc_voltage;
  const PackThevenin source = pack_.thevenin();
  const DcLinkStep link = dc_link_.advance(source.voltage_v, source.resistance_ohm, contactors.conductance(),
                                           inverter_w + low_voltage - charger_w, step_s_);
  const PackEnergy pack = pack_.advance(link.pack_current_a);

  const double copper_heat = motor_loss(parameters_.motor, current, omega_mean, driving, copper_c) * step_s_;
  const double steel_heat = drag * omega_mean * step_s_;
  ledger_.add(EnergyTerm::kBatteryChemical, pack.chemical_j);
  ledger_.add(EnergyTerm::kBatteryR0Heat, pack.r0_heat_j);
  ledger_.add(EnergyTerm::kBatteryRcHeat, pack.rc_heat_j);
  ledger_.add(EnergyTerm::kBatteryRcStored, pack.rc_stored_j);
  ledger_.add(EnergyTerm::kContactorHeat, link.path_j);
  ledger_.add(EnergyTerm::kBleedHeat, link.bleed_j);
  ledger_.add(EnergyTerm::kDcLinkStored, link.stored_j);
  ledger_.add(EnergyTerm::kLowVoltage, low_voltage * step_s_);
  ledger_.add(EnergyTerm::kInverterHeat, (inverter.loss(motor_w) + stage_w) * step_s_);
  ledger_.add(EnergyTerm::kMotorHeat, copper_heat + steel_heat);
  ledger_.add(EnergyTerm::kDrivelineHeat,
              driveline_loss(parameters_.powertrain, shaft_torque * omega_mean, pushing) * step_s_);
  ledger_.add(EnergyTerm::kKinetic, v.kinetic_j);
  ledger_.add(EnergyTerm::kClimb, v.climb_j);
  ledger_.add(EnergyTerm::kAero, v.aero_j);
  ledger_.add(EnergyTerm::kRolling, v.rolling_j);
  ledger_.add(EnergyTerm::kCornering, v.cornering_j);
  ledger_.add(EnergyTerm::kTyreSlip, v.slip_j);
  ledger_.add(EnergyTerm::kBrakeFront, v.front_brake_j);
  ledger_.add(EnergyTerm::kBrakeRear, v.rear_brake_j);

  charger_energy_j_ += charger_w * step_s_;
  pack_current_ = link.pack_current_a;
  phase_current_ = current;
  inverter_current_ = dc_voltage > 1.0 ? inverter_w / dc_voltage : 0.0;
  charge_out_c_ += link.pack_current_a * step_s_;
  energy_out_j_ += pack_.voltage() * link.pack_current_a * step_s_;
  copper_heat_j_ += copper_heat;
  steel_heat_j_ += steel_heat;
  front_brake_j_ += v.front_brake_j;
  rear_brake_j_ += v.rear_brake_j;
  collapsed_ = collapsed_ || link.collapsed;
}

void Car::renew(double elapsed_s) {
  VOLTLAP_DEMAND(elapsed_s > 0.0);
  const double ambient = parameters_.environment.ambient_c;
  contactors.advance(elapsed_s);
  inverter.advance(elapsed_s);
  pm100.advance(elapsed_s);
  if (charger.plugged) charger.advance(elapsed_s, dc_link_.voltage(), contactors.main_closed());
  pack_.renew(elapsed_s, ambient);
  motor_thermal_.advance(copper_heat_j_, elapsed_s, ambient, steel_heat_j_);
  rotors_.advance(front_brake_j_, rear_brake_j_, elapsed_s, ambient);
  copper_heat_j_ = steel_heat_j_ = front_brake_j_ = rear_brake_j_ = 0.0;
  // Once a control period for all the steps in it: what is no number stays none.
  VOLTLAP_DEMAND(std::isfinite(pack_.voltage()) && std::isfinite(dc_link_.voltage()) && std::isfinite(pack_current_));
  VOLTLAP_DEMAND(std::isfinite(vehicle_.speed_mps()) && std::isfinite(motor_thermal_.copper_c()));
}

}  // namespace voltlap::plant
