// SPDX-License-Identifier: Apache-2.0
#include "apps/car_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "car/battery/cell_tables.hpp"
#include "car/powertrain/full_torque.hpp"
#include "car/vehicle/aero.hpp"
#include "car/vehicle/chassis.hpp"
#include "car/vehicle/grip.hpp"
#include "car/vehicle/rolling_resistance.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kHalf = 0.5;  // SOC
constexpr double kKilowatt = 1e3;

/// Mean open-circuit voltage over the charge: the energy of a capacity.
double mean_ocv(const CellTables& tables, double temperature_c) {
  constexpr int kSteps = 1000;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) sum += tables.ocv_v((i + kHalf) / kSteps, temperature_c);
  return sum / kSteps;
}

/// What the pack falls by at half charge, at once [ohm].
double ohm_at_half(const VehicleParameters& car, const CellTables& tables) {
  const BatterySection& battery = car.battery;
  const CircuitParameters cell = tables.circuit(kHalf, battery.initial_temperature_c, car.cell.reference_current_a);
  return battery.cells_in_series * cell.r0_ohm / battery.cells_in_parallel + battery.contact_resistance_ohm +
         car.contactors.resistance_ohm;
}

/// Greatest power at half charge [W]: the BMS's current, the cells' lowest voltage, the master's limit.
double power_at_half(const VehicleParameters& car, double ohm, double open_v) {
  const double lowest = car.battery.cells_in_series * car.cell.voltage_min_v;
  const double current = std::min({car.bms.discharge_current_max_a, open_v / (2.0 * ohm),
                                   std::max(0.0, open_v - lowest) / ohm});
  return std::min(kKilowatt * car.master.power_max_kw, current * (open_v - current * ohm));
}

/// The smaller root of I (V - R I) = P: a power flows at the voltage that its own current leaves.
double current_of_power(double power_w, double open_v, double ohm) {
  const double root = std::sqrt(std::max(0.0, open_v * open_v - 4.0 * ohm * power_w));
  return 2.0 * power_w / (open_v + root);
}

struct Drive {
  const VehicleParameters& car;
  FullTorque torque{car};
  double wheel_per_motor = car.powertrain.final_drive / car.tyres.radius_m;

  [[nodiscard]] double force_n(double speed_mps) const {
    return torque.torque_nm(speed_mps * wheel_per_motor) * wheel_per_motor * car.powertrain.driveline_efficiency;
  }
  [[nodiscard]] double surplus_n(double speed_mps) const {
    return force_n(speed_mps) - drag_force(car, speed_mps) - rolling_force(car, speed_mps);
  }
  [[nodiscard]] double motor_last_mps() const {
    return car.motor.curve_speed_rpm.back() * M_PI / 30.0 / wheel_per_motor;
  }
};

/// The last of the speeds from 0 up to the motor's at which something still holds.
template <class Holds>
double last_speed(double motor_last_mps, Holds holds) {
  constexpr int kSpeeds = 2000;
  int i = 0;
  while (i < kSpeeds && holds(motor_last_mps * (i + 1) / kSpeeds)) ++i;
  return motor_last_mps * i / kSpeeds;
}

std::string what_ends(const Drive& drive, double top_mps) {
  // The curve may fall to nothing over the motor's last speeds.
  constexpr double kNearTheEnd = 0.97, kBeyond = 1.03;
  if (drive.torque.bus_power_max_w() <= drive.car.low_voltage.power_w) {
    return fmt::format("the pack may give {:.0f} W, low_voltage.power_w takes {:.0f} W",
                       drive.torque.bus_power_max_w(), drive.car.low_voltage.power_w);
  }
  if (top_mps >= kNearTheEnd * drive.motor_last_mps()) return "where the motor ends";
  return drive.force_n(kBeyond * top_mps) > 0.5 * drive.force_n(top_mps)
             ? "where the resistance is as large"
             : "where the pack's voltage ends the motor's torque";
}

const char* driven_tyres(const VehicleParameters& car) {
  return car.powertrain.motors == 1 ? "rear tyres" : "tyres, with these shares,";
}

void fill_speeds(const Drive& drive, CarSummary& out) {
  constexpr double kFull = 0.95;
  const double last = drive.motor_last_mps(), most = drive.force_n(0.0);
  out.full_torque_mps = last_speed(last, [&](double v) { return drive.force_n(v) >= kFull * most; });
  out.top_speed_mps = last_speed(last, [&](double v) { return drive.surplus_n(v) >= 0.0; });
  out.top_speed_by = what_ends(drive, out.top_speed_mps);
}

}  // namespace

CarSummary summarise_car(const VehicleParameters& car) {
  VOLTLAP_DEMAND(car.powertrain.kind == "electric" && car.tyres.radius_m > 0.0);
  const CellTables tables(car.cell);
  const double warm = car.battery.initial_temperature_c, series = car.battery.cells_in_series;
  CarSummary out{};
  out.pack_full_v = series * tables.ocv_v(1.0, warm);
  out.pack_half_v = series * tables.ocv_v(kHalf, warm);
  out.pack_empty_v = series * car.cell.voltage_min_v;
  out.capacity_ah = car.cell.capacity_ah * car.battery.cells_in_parallel;
  out.energy_kwh = series * mean_ocv(tables, warm) * out.capacity_ah / kKilowatt;
  out.pack_mass_kg = pack_mass(car);
  out.total_mass_kg = total_mass(car);
  out.car_mass_kg = out.total_mass_kg - car.vehicle.driver_mass_kg;
  out.discharge_max_a = car.bms.discharge_current_max_a;
  const double ohm = ohm_at_half(car, tables);
  out.power_max_kw = power_at_half(car, ohm, out.pack_half_v) / kKilowatt;
  out.power_current_a = current_of_power(kKilowatt * out.power_max_kw, out.pack_half_v, ohm);
  const Drive drive{car};
  out.wheel_force_n = drive.force_n(0.0);
  out.wheel_grip_n = drive_grip(car, 0.0, 1.0, rolling_force(car, 1.0));
  fill_speeds(drive, out);
  VOLTLAP_DEMAND(all_finite(std::array{out.pack_full_v, out.energy_kwh, out.power_max_kw, out.wheel_force_n}));
  VOLTLAP_DEMAND(out.pack_mass_kg > 0.0 && out.total_mass_kg > 0.0);
  return out;
}

std::vector<std::string> car_notes(const VehicleParameters& car, const CarSummary& s) {
  constexpr double kRuleVoltage = 600.0, kTouchable_v = 60.0, kSlow_mps = 50.0 / 3.6;
  std::vector<std::string> notes;
  if (s.pack_full_v > kRuleVoltage) {
    notes.push_back(fmt::format("the full pack has {:.0f} V, Formula SAE allows {:.0f} V: fewer "
                                "battery.cells_in_series", s.pack_full_v, kRuleVoltage));
  }
  const double cells_a = car.cell.current_breakpoints_a.back() * car.battery.cells_in_parallel;
  if (cells_a > 0.0 && s.discharge_max_a > 1.001 * cells_a) {  // 0: one table for every current
    notes.push_back(fmt::format("the BMS allows {:.0f} A, the cells are known to {:.0f} A ({:g} A each): "
                                "bms.discharge_current_max_a, or more battery.cells_in_parallel", s.discharge_max_a,
                                cells_a, car.cell.current_breakpoints_a.back()));
  }
  if (s.power_max_kw < 0.98 * car.master.power_max_kw) {
    notes.push_back(fmt::format("at half charge the pack gives {:.0f} of the {:.0f} kW of master.power_max_kw: "
                                "more cells, or a higher bms.discharge_current_max_a ({:.0f} A)", s.power_max_kw,
                                car.master.power_max_kw, s.discharge_max_a));
  }
  if (s.wheel_force_n < 0.5 * s.wheel_grip_n) {
    notes.push_back(fmt::format("full torque is {:.1f} kN at the wheels, the {} hold {:.1f} kN: a larger "
                                "powertrain.final_drive or inverter.current_max_a", 1e-3 * s.wheel_force_n,
                                driven_tyres(car), 1e-3 * s.wheel_grip_n));
  }
  if (s.wheel_force_n > 2.0 * s.wheel_grip_n) {
    notes.push_back(fmt::format("full torque is {:.1f} kN at the wheels, more than twice what the {} hold "
                                "({:.1f} kN): a smaller powertrain.final_drive wins speed", 1e-3 * s.wheel_force_n,
                                driven_tyres(car), 1e-3 * s.wheel_grip_n));
  }
  if (s.top_speed_mps < kSlow_mps) {
    notes.push_back(fmt::format("the car ends at {:.0f} km/h: check powertrain.final_drive, motor.model and the pack's "
                                "voltage ({:.0f} V at half charge)", 3.6 * s.top_speed_mps, s.pack_half_v));
  }
  if (car.motor.curve_voltage_v > 0.0 && s.pack_half_v < 0.6 * car.motor.curve_voltage_v) {
    notes.push_back(fmt::format("the motor's curve is that of {:.0f} V, the pack has {:.0f} V at half charge: its full "
                                "torque ends at {:.0f} km/h; another winding, or more battery.cells_in_series",
                                car.motor.curve_voltage_v, s.pack_half_v, 3.6 * s.full_torque_mps));
  }
  const ContactorSection& link = car.contactors;
  const double precharged = link.bleed_resistance_ohm / (link.bleed_resistance_ohm + link.precharge_resistance_ohm);
  if (precharged < car.bms.precharge_ratio) {
    notes.push_back(fmt::format("beside {:g} ohm of bleed resistor, {:g} ohm precharge the DC link to {:.1f} % of the "
                                "pack, the BMS waits for {:g} %: a smaller contactors.precharge_resistance_ohm",
                                link.bleed_resistance_ohm, link.precharge_resistance_ohm, 100.0 * precharged,
                                100.0 * car.bms.precharge_ratio));
  }
  const double discharge_s =
      link.bleed_resistance_ohm * link.dc_link_capacitance_f * std::log(std::max(1.0, s.pack_full_v / kTouchable_v));
  if (discharge_s > car.bms.dc_link_discharge_time_s) {
    notes.push_back(fmt::format("the DC link takes {:.1f} s from {:.0f} V to {:g} V, the BMS takes the contactors for "
                                "welded after {:g} s (EV.7.2.2): a smaller contactors.bleed_resistance_ohm ({:g} ohm) "
                                "or contactors.dc_link_capacitance_f", discharge_s, s.pack_full_v, kTouchable_v,
                                car.bms.dc_link_discharge_time_s, link.bleed_resistance_ohm));
  }
  if (s.pack_empty_v < car.inverter.dc_voltage_min_v) {
    notes.push_back(fmt::format("the inverter is off below {:g} V, the pack has {:.0f} V full, {:.0f} V at half and "
                                "{:.0f} V empty: a smaller inverter.dc_voltage_min_v, or more battery.cells_in_series",
                                car.inverter.dc_voltage_min_v, s.pack_full_v, s.pack_half_v, s.pack_empty_v));
  }
  return notes;
}

std::string car_text(const VehicleParameters& car, const CarSummary& s) {
  const BatterySection& battery = car.battery;
  std::string out = fmt::format("  pack       {} x {} {}, {:.0f} V full, {:.0f} V at half, {:.0f} V empty\n",
                                battery.cells_in_series, battery.cells_in_parallel, car.cell.name, s.pack_full_v,
                                s.pack_half_v, s.pack_empty_v);
  out += fmt::format("             {:.1f} Ah, {:.2f} kWh, {:.1f} kg\n", s.capacity_ah, s.energy_kwh, s.pack_mass_kg);
  out += fmt::format("  mass       {:.1f} kg, with driver {:.1f} kg\n", s.car_mass_kg, s.total_mass_kg);
  out += fmt::format("  current    {:.0f} A allowed; {:.0f} kW take {:.0f} A at half charge\n", s.discharge_max_a,
                     s.power_max_kw, s.power_current_a);
  const std::string model = car.motor.model.empty() ? "of the car file" : car.motor.model;
  const bool one = car.powertrain.motors == 1;
  out += fmt::format("  {} {}, {:.1f} kN at the wheels up to {:.0f} km/h; the {} hold {:.1f} kN\n",
                     one ? "motor     " : "4 motors  ", model, 1e-3 * s.wheel_force_n, 3.6 * s.full_torque_mps,
                     driven_tyres(car), 1e-3 * s.wheel_grip_n);
  out += fmt::format("  top speed  {:.0f} km/h, {}\n", 3.6 * s.top_speed_mps, s.top_speed_by);
  for (const std::string& note : car_notes(car, s)) out += fmt::format("  note: {}\n", note);
  return out;
}

}  // namespace voltlap::plant
