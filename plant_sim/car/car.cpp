// SPDX-License-Identifier: Apache-2.0
#include "car/car.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "car/powertrain/driveline.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {

Car::Car(const VehicleParameters& parameters, bool representative_cell, double step_s)
    : contactors(parameters.contactors),
      drives(motor_drives(parameters)),
      inverter(drives.front().inverter),
      pm100(parameters.inverter, parameters.motor.constant_nm_per_a),
      charger(parameters.charger),
      parameters_(parameters),
      step_s_(step_s),
      pack_(parameters_, representative_cell, step_s),
      vehicle_(parameters_),
      torque_curve_(parameters_.motor),
      rotors_(parameters.brakes, parameters.environment.ambient_c),
      dc_link_(parameters.contactors),
      has_pm100_(parameters.inverter.protocol == "pm100"),
      has_amk_(parameters.inverter.protocol == "amk") {
  VOLTLAP_DEMAND(step_s > 0.0);
}

const MotorThermal& Car::motor_thermal() const {
  const auto hotter = [](const MotorDrive& a, const MotorDrive& b) {
    return a.thermal.copper_c() < b.thermal.copper_c();
  };
  return std::max_element(drives.begin(), drives.end(), hotter)->thermal;
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
  const double copper_c = drives.front().thermal.copper_c(), low_voltage = low_voltage_w();
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

void Car::settle_currents(bool electric) {
  std::array<double, kMostDrives> asked{};
  for (std::size_t i = 0; electric && i < drives.size(); ++i) {
    asked[i] = drives[i].inverter.current(dc_link_.voltage());
  }
  if (drives.size() > 1) return settle_together(asked);
  drives.front().current_a = current_of(asked.front(), motor_omega_rad_s());
}

double Car::voltage_under_currents() const {
  double load = low_voltage_w();
  for (const MotorDrive& drive : drives) {
    const double motor_w =
        motor_power(parameters_.motor, drive.current_a, motor_omega_rad_s(drive), drive.thermal.copper_c());
    load += drive.inverter.dc_power(motor_w) + drive.inverter.stage_loss(drive.current_a, dc_link_.voltage());
  }
  const PackThevenin source = pack_.thevenin();
  return dc_link_.voltage_under(source.voltage_v, source.resistance_ohm, contactors.conductance(), load, step_s_);
}

// As current_of: several motors share one voltage, and it is the one that their currents leave.
void Car::settle_together(const std::array<double, kMostDrives>& asked) {
  const auto take = [&](double voltage) {
    bool all = true;
    for (std::size_t i = 0; i < drives.size(); ++i) {
      drives[i].current_a = torque_curve_.current(asked[i], motor_omega_rad_s(drives[i]), voltage);
      all = all && drives[i].current_a == asked[i];
    }
    return all;
  };
  take(dc_link_.voltage());
  if (take(voltage_under_currents())) return;
  double low = 0.0, high = std::max(pack_.thevenin().voltage_v, dc_link_.voltage());
  constexpr int kHalvings = 24;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    take(middle);
    (voltage_under_currents() >= middle ? low : high) = middle;
  }
  take(low);
}

Car::Shaft Car::shaft_of(const MotorDrive& drive, bool electric) const {
  const double omega = motor_omega_rad_s(drive);
  Shaft out;
  out.driving = drive.current_a * omega >= 0.0;
  out.drag_nm = electric ? motor_drag(parameters_.motor, omega) : 0.0;
  out.torque_nm = motor_torque(parameters_.motor, drive.current_a, omega) - out.drag_nm;
  out.pushing = out.torque_nm * omega >= 0.0;
  return out;
}

double Car::draw(MotorDrive& drive, const Shaft& shaft, bool electric) {
  const double wheel_omega = drive.front ? vehicle_.front_omega_mean() : vehicle_.rear_omega_mean();
  const double omega = wheel_omega * parameters_.powertrain.final_drive, copper_c = drive.thermal.copper_c();
  const double motor_w = motor_power(parameters_.motor, drive.current_a, omega, copper_c);
  const double stage_w = electric ? drive.inverter.stage_loss(drive.current_a, dc_link_.voltage()) : 0.0;
  const double copper = motor_loss(parameters_.motor, drive.current_a, omega, shaft.driving, copper_c) * step_s_;
  const double steel = shaft.drag_nm * omega * step_s_;
  ledger_.add(EnergyTerm::kInverterHeat, (drive.inverter.loss(motor_w) + stage_w) * step_s_);
  ledger_.add(EnergyTerm::kMotorHeat, copper + steel);
  ledger_.add(EnergyTerm::kDrivelineHeat,
              driveline_loss(parameters_.powertrain, shaft.torque_nm * omega, shaft.pushing) * step_s_);
  drive.copper_heat_j += copper;
  drive.steel_heat_j += steel;
  return drive.inverter.dc_power(motor_w) + stage_w;
}

void Car::count_vehicle(const VehicleEnergy& v) {
  ledger_.add(EnergyTerm::kKinetic, v.kinetic_j);
  ledger_.add(EnergyTerm::kClimb, v.climb_j);
  ledger_.add(EnergyTerm::kAero, v.aero_j);
  ledger_.add(EnergyTerm::kRolling, v.rolling_j);
  ledger_.add(EnergyTerm::kCornering, v.cornering_j);
  ledger_.add(EnergyTerm::kTyreSlip, v.slip_j);
  ledger_.add(EnergyTerm::kBrakeFront, v.front_brake_j);
  ledger_.add(EnergyTerm::kBrakeRear, v.rear_brake_j);
  front_brake_j_ += v.front_brake_j;
  rear_brake_j_ += v.rear_brake_j;
}

void Car::step(double brake_pedal) {
  const double dc_voltage = dc_link_.voltage();
  const bool electric = parameters_.powertrain.kind == "electric";

  // Mechanics first: the torque follows the current, and the power is then known at the mean speed of the step.
  settle_currents(electric);
  std::array<Shaft, kMostDrives> shafts;
  AxleTorques torque;
  phase_current_ = 0.0;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    shafts[i] = shaft_of(drives[i], electric);
    (drives[i].front ? torque.front_nm : torque.rear_nm) +=
        wheel_torque(parameters_.powertrain, shafts[i].torque_nm, shafts[i].pushing);
    phase_current_ += drives[i].current_a;
  }
  count_vehicle(vehicle_.advance(torque, brake_pedal, step_s_));

  double inverter_w = 0.0;
  for (std::size_t i = 0; i < drives.size(); ++i) inverter_w += draw(drives[i], shafts[i], electric);
  const double low_voltage = low_voltage_w();
  const double charger_w = charger.current_a() * dc_voltage;
  const PackThevenin source = pack_.thevenin();
  const DcLinkStep link = dc_link_.advance(source.voltage_v, source.resistance_ohm, contactors.conductance(),
                                           inverter_w + low_voltage - charger_w, step_s_);
  const PackEnergy pack = pack_.advance(link.pack_current_a);

  ledger_.add(EnergyTerm::kBatteryChemical, pack.chemical_j);
  ledger_.add(EnergyTerm::kBatteryR0Heat, pack.r0_heat_j);
  ledger_.add(EnergyTerm::kBatteryRcHeat, pack.rc_heat_j);
  ledger_.add(EnergyTerm::kBatteryRcStored, pack.rc_stored_j);
  ledger_.add(EnergyTerm::kContactorHeat, link.path_j);
  ledger_.add(EnergyTerm::kBleedHeat, link.bleed_j);
  ledger_.add(EnergyTerm::kDcLinkStored, link.stored_j);
  ledger_.add(EnergyTerm::kLowVoltage, low_voltage * step_s_);

  charger_energy_j_ += charger_w * step_s_;
  pack_current_ = link.pack_current_a;
  inverter_current_ = dc_voltage > 1.0 ? inverter_w / dc_voltage : 0.0;
  charge_out_c_ += link.pack_current_a * step_s_;
  energy_out_j_ += pack_.voltage() * link.pack_current_a * step_s_;
  collapsed_ = collapsed_ || link.collapsed;
}

void Car::renew(double elapsed_s) {
  VOLTLAP_DEMAND(elapsed_s > 0.0);
  const double ambient = parameters_.environment.ambient_c;
  contactors.advance(elapsed_s);
  for (MotorDrive& drive : drives) drive.inverter.advance(elapsed_s);
  if (has_amk_) {
    for (MotorDrive& drive : drives) drive.amk.advance(elapsed_s, dc_link_.voltage());
  }
  pm100.advance(elapsed_s);
  if (charger.plugged) charger.advance(elapsed_s, dc_link_.voltage(), contactors.main_closed());
  pack_.renew(elapsed_s, ambient);
  for (MotorDrive& drive : drives) {
    drive.thermal.advance(drive.copper_heat_j, elapsed_s, ambient, drive.steel_heat_j);
    drive.copper_heat_j = drive.steel_heat_j = 0.0;
    VOLTLAP_DEMAND(std::isfinite(drive.thermal.copper_c()));
  }
  rotors_.advance(front_brake_j_, rear_brake_j_, elapsed_s, ambient);
  front_brake_j_ = rear_brake_j_ = 0.0;
  // Once a control period for all the steps in it: what is no number stays none.
  VOLTLAP_DEMAND(std::isfinite(pack_.voltage()) && std::isfinite(dc_link_.voltage()) && std::isfinite(pack_current_));
  VOLTLAP_DEMAND(std::isfinite(vehicle_.speed_mps()));
}

}  // namespace voltlap::plant
