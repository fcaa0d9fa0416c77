// SPDX-License-Identifier: Apache-2.0
#include "bms/config.hpp"

#include "base/interpolate.hpp"

namespace voltlap::bms {
namespace {

constexpr Soc kFull = Soc::from_raw(1'000'000);
constexpr std::int32_t kCapacityMaxMah = 2'000'000;  // keeps charge * 1e6 inside 64 bits

bool table_spans_soc(const Soc* soc, std::uint8_t count) {
  if (count < 2 || count > kMaxTablePoints) return false;
  return strictly_increasing(soc, count) && soc[0] >= Soc{} && soc[count - 1] <= kFull;
}

bool pack_ok(const Config& c) {
  if (c.cells_in_series == 0 || c.cells_in_series > kMaxCells) return false;
  if (c.temperature_sensors == 0 || c.temperature_sensors > kMaxTemperatures) return false;
  if (c.temperature_sensors * 5 < c.cells_in_series) return false;  // EV.7.5: 20 % of the cells
  return c.capacity_mah > 0 && c.capacity_mah <= kCapacityMaxMah;
}

bool tables_ok(const Config& c) {
  if (!table_spans_soc(c.ocv.soc, c.ocv.count) || !strictly_increasing(c.ocv.voltage, c.ocv.count)) return false;
  if (!table_spans_soc(c.resistance.soc, c.resistance.count)) return false;
  for (std::uint8_t i = 0; i < c.resistance.count; ++i) {
    if (c.resistance.resistance[i] <= Resistance{}) return false;
  }
  return c.ocv.voltage[0] > CellVoltage{};
}

/// plausible < trip low <= minimum < maximum <= trip high < plausible
bool voltages_in_order(const Config& c) {
  return CellVoltage{} < c.cell_voltage_plausible_min && c.cell_voltage_plausible_min < c.cell_voltage_trip_low &&
         c.cell_voltage_trip_low <= c.cell_voltage_min && c.cell_voltage_min < c.cell_voltage_max &&
         c.cell_voltage_max <= c.cell_voltage_trip_high && c.cell_voltage_trip_high < c.cell_voltage_plausible_max;
}

bool currents_in_order(const Config& c) {
  return Current{} < c.discharge_current_max && c.discharge_current_max <= c.discharge_current_trip &&
         Current{} <= c.charge_current_max && c.charge_current_max <= c.charge_current_trip &&
         Current{} < c.charge_current_trip && Current{} < c.limit_rise_per_s && Current{} <= c.soc_start_current;
}

bool temperatures_in_order(const Config& c) {
  constexpr Temperature kRuleMaximum = Temperature::from_raw(600);  // EV.7.5
  return c.charge_temperature_min < c.derating_start && c.derating_start < c.temperature_trip &&
         c.temperature_trip <= kRuleMaximum;
}

bool times_ok(const Config& c) {
  constexpr Duration kZero{};
  return kZero < c.voltage_trip_time && kZero < c.temperature_trip_time && kZero < c.measurement_lost_time &&
         kZero < c.current_trip_time && kZero < c.mismatch_time && kZero < c.contactor_time &&
         kZero <= c.contactor_drop_time && c.contactor_drop_time <= c.contactor_time && kZero < c.discharge_time && kZero <= c.precharge_time_min && c.precharge_time_min < c.precharge_timeout;
}

bool ratios_ok(const Config& c) {
  constexpr Ratio kRuleMinimum = Ratio::from_raw(900'000);  // EV.5.6
  constexpr Ratio kWhole = Ratio::from_raw(1'000'000);
  return kRuleMinimum <= c.precharge_ratio && c.precharge_ratio < kWhole && Ratio{} < c.voltage_mismatch &&
         c.voltage_mismatch < kWhole && Ratio{} < c.dc_link_welded && c.dc_link_welded < c.precharge_ratio &&
         Soc{} <= c.soc_derating_start && c.soc_derating_start < kFull;
}

}  // namespace

// BMS-002: a configuration that contradicts itself never closes a contactor.
bool config_check(const Config& config) {
  return pack_ok(config) && tables_ok(config) && voltages_in_order(config) && currents_in_order(config) &&
         temperatures_in_order(config) && times_ok(config) && ratios_ok(config);
}

}  // namespace voltlap::bms
