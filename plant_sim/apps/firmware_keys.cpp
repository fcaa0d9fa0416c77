// SPDX-License-Identifier: Apache-2.0
#include "apps/firmware_keys.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/demand.hpp"
#include "core/parameter_table.hpp"

namespace voltlap::plant {
namespace {

std::int32_t counts_of(Duration time) { return time.ms(); }
template <class Tag>
std::int32_t counts_of(Quantity<Tag> quantity) { return quantity.raw(); }
std::int32_t counts_of(std::int32_t number) { return number; }

void put(Duration& time, std::int32_t counts) { time = Duration::from_ms(counts); }
template <class Tag>
void put(Quantity<Tag>& quantity, std::int32_t counts) { quantity = Quantity<Tag>::from_raw(counts); }
void put(std::int32_t& number, std::int32_t counts) { number = counts; }
void put(std::uint16_t& number, std::int32_t counts) {
  VOLTLAP_DEMAND(counts >= 0 && counts <= std::numeric_limits<std::uint16_t>::max());
  number = static_cast<std::uint16_t>(counts);
}

/// The field that a chain of member pointers leads to.
template <class Holder>
auto& field_of(Holder& holder) { return holder; }
template <class Holder, class Member, class... Rest>
auto& field_of(Holder& holder, Member member, Rest... rest) { return field_of(holder.*member, rest...); }

template <class Config, auto... Path>
constexpr FirmwareKey<Config> row(std::string_view key, std::int32_t counts_per_unit) {
  return {key, counts_per_unit, +[](const Config& config) { return counts_of(field_of(config, Path...)); },
          +[](Config& config, std::int32_t counts) { put(field_of(config, Path...), counts); }};
}
template <auto Field>
constexpr auto bms_row = row<bms::Config, Field>;
template <auto... Path>
constexpr auto master_row = row<master::Config, Path...>;

using B = bms::Config;
using M = master::Config;
using A = master::AppsChannel;
constexpr std::int32_t kWhole = 1, kDecikelvin = 10, kMilli = 1'000, k100Micro = 10'000, kMicro = 1'000'000;

constexpr FirmwareKey<bms::Config> kBmsKeys[] = {
    bms_row<&B::cells_in_series>("battery.cells_in_series", kWhole),
    bms_row<&B::temperature_sensors>("sensors.temperature_count", kWhole),
    bms_row<&B::soc_start_current>("bms.soc_start_current_a", kMilli),
    bms_row<&B::cell_voltage_min>("bms.cell_voltage_min_v", k100Micro),
    bms_row<&B::cell_voltage_max>("bms.cell_voltage_max_v", k100Micro),
    bms_row<&B::discharge_current_max>("bms.discharge_current_max_a", kMilli),
    bms_row<&B::charge_current_max>("bms.charge_current_max_a", kMilli),
    bms_row<&B::limit_rise_per_s>("bms.limit_rise_a_per_s", kMilli),
    bms_row<&B::derating_start>("bms.temperature_derating_start_c", kDecikelvin),
    bms_row<&B::charge_temperature_min>("bms.charge_temperature_min_c", kDecikelvin),
    bms_row<&B::soc_derating_start>("bms.soc_derating_start", kMicro),
    bms_row<&B::energy_to_go_m>("bms.energy_to_go_km", kMilli),
    bms_row<&B::energy_to_go_reserve>("bms.energy_to_go_reserve", kMicro),
    bms_row<&B::cell_voltage_trip_low>("bms.cell_voltage_trip_low_v", k100Micro),
    bms_row<&B::cell_voltage_trip_high>("bms.cell_voltage_trip_high_v", k100Micro),
    bms_row<&B::temperature_trip>("bms.temperature_max_c", kDecikelvin),
    bms_row<&B::discharge_current_trip>("bms.discharge_current_trip_a", kMilli),
    bms_row<&B::charge_current_trip>("bms.charge_current_trip_a", kMilli),
    bms_row<&B::voltage_mismatch>("bms.voltage_mismatch", kMicro),
    bms_row<&B::voltage_trip_time>("bms.voltage_trip_time_s", kMilli),
    bms_row<&B::temperature_trip_time>("bms.temperature_trip_time_s", kMilli),
    bms_row<&B::measurement_lost_time>("bms.measurement_lost_time_s", kMilli),
    bms_row<&B::current_trip_time>("bms.current_trip_time_s", kMilli),
    bms_row<&B::mismatch_time>("bms.voltage_mismatch_time_s", kMilli),
    bms_row<&B::cell_voltage_plausible_min>("bms.cell_voltage_plausible_min_v", k100Micro),
    bms_row<&B::cell_voltage_plausible_max>("bms.cell_voltage_plausible_max_v", k100Micro),
    bms_row<&B::precharge_ratio>("bms.precharge_ratio", kMicro),
    bms_row<&B::precharge_timeout>("bms.precharge_timeout_s", kMilli),
    bms_row<&B::precharge_time_min>("bms.precharge_time_min_s", kMilli),
    bms_row<&B::contactor_time>("bms.contactor_time_s", kMilli),
    bms_row<&B::contactor_drop_time>("bms.contactor_drop_time_s", kMilli),
    bms_row<&B::isolation_time>("bms.isolation_time_s", kMilli),
    bms_row<&B::discharge_time>("bms.dc_link_discharge_time_s", kMilli),
    bms_row<&B::dc_link_welded>("bms.dc_link_welded", kMicro),
    bms_row<&B::charger_current_max>("bms.charger_current_max_a", kMilli),
    bms_row<&B::charge_margin>("bms.charge_margin_v", k100Micro),
    bms_row<&B::charge_current_end>("bms.charge_current_end_a", kMilli),
    bms_row<&B::balancing_voltage_min>("bms.balancing_voltage_min_v", k100Micro),
    bms_row<&B::balancing_difference>("bms.balancing_difference_v", k100Micro),
    bms_row<&B::balancing_current_max>("bms.balancing_current_max_a", kMilli),
    bms_row<&B::balancing_time_max>("bms.balancing_time_max_s", kMilli),
};

constexpr FirmwareKey<master::Config> kMasterKeys[] = {
    master_row<&M::apps1, &A::released>("master.apps1_released_v", k100Micro),
    master_row<&M::apps1, &A::full>("master.apps1_full_v", k100Micro),
    master_row<&M::apps1, &A::range_min>("master.apps1_range_min_v", k100Micro),
    master_row<&M::apps1, &A::range_max>("master.apps1_range_max_v", k100Micro),
    master_row<&M::apps2, &A::released>("master.apps2_released_v", k100Micro),
    master_row<&M::apps2, &A::full>("master.apps2_full_v", k100Micro),
    master_row<&M::apps2, &A::range_min>("master.apps2_range_min_v", k100Micro),
    master_row<&M::apps2, &A::range_max>("master.apps2_range_max_v", k100Micro),
    master_row<&M::apps_disagreement_max>("master.apps_disagreement_max", kMicro),
    master_row<&M::apps_implausible_time>("master.apps_implausible_time_s", kMilli),
    master_row<&M::brake_sensor_fail_time>("master.brake_sensor_fail_time_s", kMilli),
    master_row<&M::brake_throttle_limit>("master.brake_throttle_limit", kMicro),
    master_row<&M::pedal_release_level>("master.pedal_release_level", kMicro),
    master_row<&M::pedal_dead_zone>("master.pedal_dead_zone", kMicro),
    master_row<&M::pedal_at_half>("master.pedal_at_half", kMicro),
    master_row<&M::brake_pressed_level>("master.brake_pressed_bar", kMilli),
    master_row<&M::brake_compare_level>("master.brake_compare_bar", kMilli),
    master_row<&M::phase_current_max>("master.phase_current_max_a", kMilli),
    master_row<&M::request_rise_ma_per_ms>("master.request_rise_a_per_s", kWhole),
    master_row<&M::regen_current_max>("master.regen_current_max_a", kMilli),
    master_row<&M::regen_full_level>("master.regen_full_brake_bar", kMilli),
    master_row<&M::motor_constant_unm_per_a>("master.motor_constant_nm_per_a", kMicro),
    master_row<&M::drive_efficiency>("master.drive_efficiency", kMicro),
    master_row<&M::power_max_mw>("master.power_max_kw", kMicro),
    master_row<&M::motor_speed_max>("master.motor_speed_max_rpm", kWhole),
    master_row<&M::ceiling_rise_ma_per_s>("master.ceiling_rise_a_per_s", kMilli),
    master_row<&M::trim_gain>("master.trim_gain", kMicro),
    master_row<&M::trim_max>("master.trim_max", kMicro),
    master_row<&M::trim_decay_ppm_per_s>("master.trim_decay_per_s", kMicro),
    master_row<&M::battery_limit_off>("master.battery_limit_off_a", kMilli),
    master_row<&M::battery_limit_on>("master.battery_limit_on_a", kMilli),
    master_row<&M::regen_speed_min>("master.regen_speed_min_mps", kMilli),
    master_row<&M::inverter_excess_max>("master.inverter_excess_max_a", kMilli),
    master_row<&M::limp_share>("master.limp_share", kMicro),
    master_row<&M::motor_current_max>("inverter.current_max_a", kMilli),
    master_row<&M::front_drive_share>("powertrain.front_torque_share", kMicro),
    master_row<&M::front_brake_share>("powertrain.front_braking_share", kMicro),
    master_row<&M::nominal_torque_mnm>("inverter.amk_nominal_torque_nm", kMilli),
    master_row<&M::motor_derate_start>("master.motor_derating_start_c", kDecikelvin),
    master_row<&M::motor_derate_end>("master.motor_derating_end_c", kDecikelvin),
    master_row<&M::inverter_derate_start>("master.inverter_derating_start_c", kDecikelvin),
    master_row<&M::inverter_derate_end>("master.inverter_derating_end_c", kDecikelvin),
    master_row<&M::ts_request_timeout>("master.ts_request_timeout_s", kMilli),
    master_row<&M::rtd_sound_time>("master.rtd_sound_time_s", kMilli),
    master_row<&M::rx_timeout>("master.rx_timeout_s", kMilli),
};

/// The ranges of the keys lie within what 32 bits count.
std::int32_t nearest_count(double value, std::int32_t counts_per_unit) {
  const double counts = std::round(value * counts_per_unit);
  VOLTLAP_DEMAND(within(counts, std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()));
  return static_cast<std::int32_t>(counts);
}

template <class Config>
void fill(const VehicleParameters& car, std::span<const FirmwareKey<Config>> keys, Config& config) {
  for (const FirmwareKey<Config>& key : keys) {
    const ParameterRow* row = find_parameter(key.key);
    VOLTLAP_DEMAND(row != nullptr);
    key.set(config, nearest_count(number_value(*row, car), key.counts_per_unit));
  }
}

template <class Config>
std::int32_t counts_per_unit(std::span<const FirmwareKey<Config>> keys, std::string_view key) {
  const auto found = std::find_if(keys.begin(), keys.end(), [&](const auto& row) { return row.key == key; });
  return found == keys.end() ? 0 : found->counts_per_unit;
}

}  // namespace

std::span<const FirmwareKey<bms::Config>> bms_keys() { return kBmsKeys; }
std::span<const FirmwareKey<master::Config>> master_keys() { return kMasterKeys; }

void fill_from_keys(const VehicleParameters& car, bms::Config& config) { fill(car, bms_keys(), config); }
void fill_from_keys(const VehicleParameters& car, master::Config& config) { fill(car, master_keys(), config); }

std::string firmware_step_text(std::string_view key) {
  const std::int32_t counts = std::max(counts_per_unit(bms_keys(), key), counts_per_unit(master_keys(), key));
  if (counts <= kWhole) return {};
  const ParameterRow* row = find_parameter(key);
  return row->unit == "1" ? fmt::format("{:g}", 1.0 / counts) : fmt::format("{:g} {}", 1.0 / counts, row->unit);
}

}  // namespace voltlap::plant
