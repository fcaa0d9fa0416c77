// SPDX-License-Identifier: Apache-2.0
#include "apps/firmware_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "battery/cell_tables.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

template <class Quantity>
Quantity scaled(double value, double raw_per_unit) {
  return Quantity::saturated(std::llround(value * raw_per_unit));
}
Soc soc_of(double fraction) { return scaled<Soc>(fraction, 1e6); }
CellVoltage cell_voltage_of(double volts) { return scaled<CellVoltage>(volts, 1e4); }
Current current_of(double amperes) { return scaled<Current>(amperes, 1e3); }
Temperature temperature_of(double celsius) { return scaled<Temperature>(celsius, 10.0); }
Resistance resistance_of(double ohms) { return scaled<Resistance>(ohms, 1e6); }

constexpr double kTripBelowMinimum_v = 0.1, kTripAboveMaximum_v = 0.05;  // 2.4 and 4.25 V of a 2.5 to 4.2 V cell
constexpr double kDeratingSpan_k = 5.0;
constexpr double kCurrentTripOverLimit = 1.1;
constexpr double kChargeTripLeast_a = 10.0;    // a car without regeneration still sees sensor noise
constexpr double kEfficiencyMargin = 0.9;      // for what the car's efficiencies leave out
constexpr double kCommandMax_a = 550.0;        // range of InverterCommand.PhaseCurrent in car.dbc
constexpr double kTemperatureSlopeSpan_k = 5.0;

/// The OCV curve at evenly spaced SOC; a point that does not rise is left out, the BMS inverts the table.
bms::OcvTable ocv_table(const CellTables& cell) {
  bms::OcvTable table;
  for (std::size_t i = 0; i < bms::kMaxTablePoints; ++i) {
    const double soc = static_cast<double>(i) / (bms::kMaxTablePoints - 1);
    const CellVoltage voltage = cell_voltage_of(cell.ocv(soc).voltage_v);
    if (table.count > 0 && voltage <= table.voltage[table.count - 1]) continue;
    table.soc[table.count] = soc_of(soc);
    table.voltage[table.count++] = voltage;
  }
  return table;
}

/// Resistance of one parallel group that the limit of Eq. 4.12 divides by: R0 + R1 + R2, what a long pull meets.
bms::ResistanceTable resistance_table(const VehicleParameters& car, const CellTables& cell) {
  bms::ResistanceTable table;
  const double reference_c = car.cell.reference_temperature_c;
  const auto total = [&](double soc, double temperature_c) {
    const CircuitParameters c = cell.circuit(soc, temperature_c, car.cell.reference_current_a);
    return (c.r0_ohm + c.r1_ohm + c.r2_ohm) / car.battery.cells_in_parallel;
  };
  table.reference = temperature_of(reference_c);
  table.count = bms::kMaxTablePoints;
  for (std::size_t i = 0; i < bms::kMaxTablePoints; ++i) {
    const double soc = static_cast<double>(i) / (bms::kMaxTablePoints - 1);
    table.soc[i] = soc_of(soc);
    table.resistance[i] = resistance_of(car.bms.resistance_ohm > 0.0 ? car.bms.resistance_ohm : total(soc, reference_c));
  }
  if (car.bms.resistance_ohm <= 0.0) {
    const double warm = total(0.5, reference_c + kTemperatureSlopeSpan_k);
    const double cold = total(0.5, reference_c - kTemperatureSlopeSpan_k);
    const double per_kelvin = (warm - cold) / (2.0 * kTemperatureSlopeSpan_k * total(0.5, reference_c));
    table.ppm_per_kelvin = static_cast<std::int32_t>(std::lround(per_kelvin * 1e6));
  }
  return table;
}

void check_rules(const VehicleParameters& car) {
  const int least = (car.battery.cells_in_series + 4) / 5;
  if (car.sensors.temperature_count < least) {
    throw InputError("sensors.temperature_count", fmt::format("{}", car.sensors.temperature_count),
                     fmt::format("at least {}, one for every five of the {} cells (rule EV.7.5), or the BMS keeps the "
                                 "contactors open", least, car.battery.cells_in_series),
                     fmt::format("Add --set sensors.temperature_count={}", least));
  }
  if (car.bms.temperature_max_c > 60.0) {
    throw InputError("bms.temperature_max_c", fmt::format("{} degC", car.bms.temperature_max_c),
                     "at most 60 degC (rule EV.7.5)", "Lower the trip temperature");
  }
}

}  // namespace

bms::Config bms_config(const VehicleParameters& car) {
  check_rules(car);
  const CellTables cell(car.cell);
  const double capacity_ah =
      car.bms.capacity_ah > 0.0 ? car.bms.capacity_ah : car.cell.capacity_ah * car.battery.cells_in_parallel;

  bms::Config config;
  config.cells_in_series = static_cast<std::uint16_t>(car.battery.cells_in_series);
  config.temperature_sensors = static_cast<std::uint16_t>(car.sensors.temperature_count);
  config.capacity_mah = static_cast<std::int32_t>(std::lround(capacity_ah * 1e3));
  config.ocv = ocv_table(cell);
  config.resistance = resistance_table(car, cell);
  config.cell_voltage_min = cell_voltage_of(car.cell.voltage_min_v);
  config.cell_voltage_max = cell_voltage_of(car.cell.voltage_max_v);
  config.cell_voltage_trip_low = cell_voltage_of(car.cell.voltage_min_v - kTripBelowMinimum_v);
  config.cell_voltage_trip_high = cell_voltage_of(car.cell.voltage_max_v + kTripAboveMaximum_v);
  config.discharge_current_max = current_of(car.bms.discharge_current_max_a);
  config.charge_current_max = current_of(car.bms.charge_current_max_a);
  config.discharge_current_trip = current_of(car.bms.discharge_current_max_a * kCurrentTripOverLimit);
  config.charge_current_trip =
      current_of(std::max(kChargeTripLeast_a, car.bms.charge_current_max_a * kCurrentTripOverLimit));
  config.temperature_trip = temperature_of(car.bms.temperature_max_c);
  config.derating_start = temperature_of(car.bms.temperature_max_c - kDeratingSpan_k);
  if (!bms::config_check(config)) {
    throw InputError("bms", "a configuration that the BMS's own check refuses",
                     "limits in their order (cell voltage 0.6 V or more below its maximum, currents above 0, "
                     "temperature above 5 degC) and an OCV that rises with SOC",
                     "Check the keys bms.*, cell.voltage_*, cell.ocv.* and battery.capacity_ah; the rules are in "
                     "firmware/bms/config.cpp");
  }
  return config;
}

master::Config master_config(const VehicleParameters& car) {
  master::Config config;
  config.phase_current_max = current_of(std::min(car.inverter.current_max_a, kCommandMax_a));
  config.motor_constant_unm_per_a = static_cast<std::int32_t>(std::lround(car.motor.constant_nm_per_a * 1e6));
  config.drive_efficiency =
      scaled<Ratio>(car.inverter.efficiency * car.motor.efficiency * kEfficiencyMargin, 1e6);
  if (const master::ConfigError error = config_check(config); error != master::ConfigError::kNone) {
    throw InputError("the master controller",
                     fmt::format("a configuration that its own check refuses (reason {})", static_cast<int>(error)),
                     "an inverter current above 0, a motor constant from 0.001 to 10 Nm/A and efficiencies whose "
                     "product is above 0.34",
                     "Check the keys inverter.* and motor.*; the rules are in firmware/master/config.hpp");
  }
  return config;
}

}  // namespace voltlap::plant
