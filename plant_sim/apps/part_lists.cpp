// SPDX-License-Identifier: Apache-2.0
#include "apps/part_lists.hpp"

#include <fmt/format.h>

#include "car/battery/cell_tables.hpp"
#include "car/powertrain/motor_map.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr const char* kAnyCar = "vtm16e";  // a motor file is read within a car

std::string stated(double value) { return value > 0.0 ? fmt::format("{:g}", value) : "-"; }

double mean_ocv_v(const CellTables& tables, double temperature_c) {
  constexpr int kSteps = 200;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) sum += tables.ocv_v((i + 0.5) / kSteps, temperature_c);
  return sum / kSteps;
}

}  // namespace

std::string motor_list(const DataFolder& data) {
  std::string out = fmt::format("{:<22} {:>9} {:>9} {:>7} {:>9} {:>9} {:>9} {:>12} {:>12}\n", "motor", "torque_nm",
                                "power_kw", "at_v", "speed_rpm", "nm_per_a", "max_v", "rotor_kg_m2", "efficiency_%");
  for (const std::string& name : data.names("motors")) {
    const MotorSection motor = load_vehicle(data, kAnyCar, {"motor.model=" + name}).parameters.motor;
    const MotorSummary peak = motor_summary(motor);
    out += fmt::format("{:<22} {:>9.1f} {:>9.1f} {:>7} {:>9.0f} ", name, peak.torque_peak_nm, 1e-3 * peak.power_peak_w,
                       stated(motor.curve_voltage_v), peak.speed_max_rpm);
    out += fmt::format("{:>9} {:>9} {:>12} {:>12.1f}\n", stated(motor.constant_nm_per_a), stated(motor.voltage_max_v),
                       stated(motor.rotor_inertia_kg_m2), 100.0 * peak.efficiency_peak);
  }
  return out;
}

std::string cell_list(const DataFolder& data) {
  constexpr double kHalf = 0.5, kRoom_c = 25.0;
  std::string out = fmt::format("{:<22} {:>11} {:>9} {:>8} {:>8} {:>8}\n", "cell", "capacity_ah", "nominal_v",
                                "r0_mohm", "mass_g", "wh_per_kg");
  for (const std::string& name : data.names("cells")) {
    const CellParameters cell = load_cell(data, name, "cells");
    const CellTables tables(cell);
    const double r0 = tables.circuit(kHalf, kRoom_c, cell.reference_current_a).r0_ohm;
    VOLTLAP_DEMAND(r0 > 0.0 && cell.mass_kg > 0.0);
    out += fmt::format("{:<22} {:>11g} {:>9.2f} {:>8.2f} {:>8.0f} {:>8.0f}\n", name, cell.capacity_ah,
                       tables.ocv_v(kHalf, kRoom_c), 1e3 * r0, 1e3 * cell.mass_kg,
                       cell.capacity_ah * mean_ocv_v(tables, kRoom_c) / cell.mass_kg);
  }
  return out;
}

}  // namespace voltlap::plant
