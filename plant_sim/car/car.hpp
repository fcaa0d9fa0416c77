// SPDX-License-Identifier: Apache-2.0
// The whole physical car, from cells to tyres, without driver, bus or firmware: what acts on it are contactor and
// inverter commands and a brake pedal.
#pragma once
#include <array>

#include "car/battery/pack.hpp"
#include "car/energy_ledger.hpp"
#include "car/powertrain/charger.hpp"
#include "car/powertrain/contactors.hpp"
#include "car/powertrain/dc_link.hpp"
#include "car/powertrain/motor_drive.hpp"
#include "car/powertrain/pm100.hpp"
#include "car/powertrain/torque_curve.hpp"
#include "car/vehicle/brakes.hpp"
#include "car/vehicle/longitudinal.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

class Car {
 public:
  Car(const VehicleParameters& parameters, bool representative_cell, double step_s);
  Car(const Car&) = delete;  // parts hold references to its parameters
  Car& operator=(const Car&) = delete;

  /// One integration step of everything electrical and mechanical.
  void step(double brake_pedal);
  /// One control period of everything slow: contactor travel, command silence, temperatures, lookup tables.
  void renew(double elapsed_s);

  ContactorBox contactors;
  std::vector<MotorDrive> drives;  ///< the one, or four: front left, front right, rear left, rear right
  Inverter& inverter;              ///< of the one
  Pm100 pm100;  ///< what stands before it in a car with inverter.protocol pm100
  Charger charger;

  [[nodiscard]] const VehicleParameters& parameters() const { return parameters_; }
  [[nodiscard]] const Pack& pack() const { return pack_; }
  [[nodiscard]] Pack& pack() { return pack_; }
  [[nodiscard]] const LongitudinalVehicle& vehicle() const { return vehicle_; }
  [[nodiscard]] LongitudinalVehicle& vehicle() { return vehicle_; }
  /// Of the hottest motor.
  [[nodiscard]] const MotorThermal& motor_thermal() const;
  [[nodiscard]] const BrakeRotors& rotors() const { return rotors_; }
  [[nodiscard]] const EnergyLedger& ledger() const { return ledger_; }
  [[nodiscard]] double dc_link_voltage() const { return dc_link_.voltage(); }
  [[nodiscard]] double pack_current_a() const { return pack_current_; }
  [[nodiscard]] bool has_pm100() const { return has_pm100_; }
  [[nodiscard]] bool has_amk() const { return has_amk_; }
  /// What the inverters take from the DC link [A].
  [[nodiscard]] double inverter_current_a() const { return inverter_current_; }
  /// Of all motors.
  [[nodiscard]] double phase_current_a() const { return phase_current_; }
  /// Of a motor of the rear axle.
  [[nodiscard]] double motor_omega_rad_s() const { return vehicle_.rear_omega() * parameters_.powertrain.final_drive; }
  [[nodiscard]] double motor_omega_rad_s(const MotorDrive& drive) const {
    return (drive.front ? vehicle_.front_omega() : vehicle_.rear_omega()) * parameters_.powertrain.final_drive;
  }
  /// Energy that left the pack's terminals since the start [J].
  [[nodiscard]] double energy_out_j() const { return energy_out_j_; }
  /// Energy that a charger gave [J]; the ledger does not know it: its residual is this much.
  [[nodiscard]] double charger_energy_j() const { return charger_energy_j_; }
  /// Net charge that the pack gave [C].
  [[nodiscard]] double charge_out_c() const { return charge_out_c_; }
  /// True once the pack could not deliver the power that the load asked.
  [[nodiscard]] bool voltage_collapsed() const { return collapsed_; }

 private:
  [[nodiscard]] double low_voltage_w() const;
  /// The phase current [A] that flows when `asked_a` is commanded: the most that the motor can at the voltage that the
  /// pack has under it.
  [[nodiscard]] double current_of(double asked_a, double omega_rad_s) const;
  /// That of each drive.
  void settle_currents(bool electric);
  void settle_together(const std::array<double, kMostDrives>& asked_a);
  /// The voltage that the DC link would have with the currents as they are.
  [[nodiscard]] double voltage_under_currents() const;
  /// The mechanics of a step, and what they ask of the DC link.
  struct Shaft {
    double torque_nm = 0.0, drag_nm = 0.0;
    bool pushing = false;  ///< or pushed
    bool driving = false;  ///< by its current
  };
  [[nodiscard]] Shaft shaft_of(const MotorDrive& drive, bool electric) const;
  /// The power [W] that a drive takes from the DC link; its heats and losses are counted.
  double draw(MotorDrive& drive, const Shaft& shaft, bool electric);
  void count_vehicle(const VehicleEnergy& v);

  VehicleParameters parameters_;
  double step_s_;
  Pack pack_;
  LongitudinalVehicle vehicle_;
  TorqueCurve torque_curve_;
  BrakeRotors rotors_;
  DcLink dc_link_;
  EnergyLedger ledger_;
  const bool has_pm100_, has_amk_;
  double pack_current_ = 0.0, phase_current_ = 0.0, inverter_current_ = 0.0;
  double energy_out_j_ = 0.0, charge_out_c_ = 0.0;
  double charger_energy_j_ = 0.0;
  double front_brake_j_ = 0.0, rear_brake_j_ = 0.0;
  bool collapsed_ = false;
};

}  // namespace voltlap::plant
