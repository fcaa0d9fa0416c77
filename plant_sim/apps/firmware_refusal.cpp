// SPDX-License-Identifier: Apache-2.0
#include "apps/firmware_refusal.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "apps/firmware_keys.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/parameter_table.hpp"

namespace voltlap::plant {
namespace {

using enum Order;

/// One condition of a firmware check in words of the car. `other` is a key, or empty; then `counts` is the number.
template <class Error>
struct Row {
  Error error;
  std::string_view key;
  Order order;
  std::string_view other = {};
  std::int32_t counts = 0;
  std::string_view reason = {};
};

using B = bms::ConfigError;
namespace bc = bms::check;
constexpr Row<B> kBmsRows[] = {
    {B::kCellsInSeries, "battery.cells_in_series", kAtMost, "", bms::kMaxCells, "the cells that its frames have"},
    {B::kTemperatureSensors, "sensors.temperature_count", kAtMost, "", bms::kMaxTemperatures,
     "the thermistors that its frames have"},
    {B::kCapacity, "bms.capacity_ah", kAbove},
    {B::kEnergyToGo, "bms.energy_to_go_km", kAtLeast, "", bc::kDistanceMinM, "0: off"},
    {B::kEnergyToGoMax, "bms.energy_to_go_km", kAtMost, "", bc::kDistanceMaxM},
    {B::kEnergyReserve, "bms.energy_to_go_reserve", kAtLeast},
    {B::kEnergyReserveFull, "bms.energy_to_go_reserve", kBelow, "", bms::check::kFull.raw()},
    {B::kVoltagePlausibleMin, "bms.cell_voltage_plausible_min_v", kAbove},
    {B::kVoltageTripLowPlausible, "bms.cell_voltage_trip_low_v", kAbove, "bms.cell_voltage_plausible_min_v"},
    {B::kVoltageMinTripLow, "bms.cell_voltage_min_v", kAtLeast, "bms.cell_voltage_trip_low_v"},
    {B::kVoltageMaxMin, "bms.cell_voltage_max_v", kAbove, "bms.cell_voltage_min_v"},
    {B::kVoltageTripHighMax, "bms.cell_voltage_trip_high_v", kAtLeast, "bms.cell_voltage_max_v"},
    {B::kVoltagePlausibleMaxTripHigh, "bms.cell_voltage_plausible_max_v", kAbove, "bms.cell_voltage_trip_high_v"},
    {B::kVoltagePlausibleMaxRange, "bms.cell_voltage_plausible_max_v", kAtMost, "", bc::kCellVoltageRange.raw(),
     "the range of CellVoltages in car.dbc"},
    {B::kDischargeCurrentMax, "bms.discharge_current_max_a", kAbove},
    {B::kDischargeCurrentTrip, "bms.discharge_current_trip_a", kAtLeast, "bms.discharge_current_max_a"},
    {B::kDischargeCurrentTripRange, "bms.discharge_current_trip_a", kAtMost, "", bc::kCurrentRange.raw(),
     "the range of PackSensor in car.dbc"},
    {B::kChargeCurrentMax, "bms.charge_current_max_a", kAtLeast},
    {B::kChargeCurrentTrip, "bms.charge_current_trip_a", kAtLeast, "bms.charge_current_max_a"},
    {B::kChargeCurrentTripPositive, "bms.charge_current_trip_a", kAbove},
    {B::kChargeCurrentTripRange, "bms.charge_current_trip_a", kAtMost, "", bc::kCurrentRange.raw(),
     "the range of PackSensor in car.dbc"},
    {B::kLimitRise, "bms.limit_rise_a_per_s", kAbove},
    {B::kLimitRiseMax, "bms.limit_rise_a_per_s", kAtMost, "", bc::kLimitRiseMax.raw()},
    {B::kSocStartCurrent, "bms.soc_start_current_a", kAtLeast},
    {B::kSocStartCurrentMax, "bms.soc_start_current_a", kAtMost, "", bc::kSocStartCurrentMax.raw()},
    {B::kChargeTemperatureMin, "bms.charge_temperature_min_c", kBelow, "bms.temperature_derating_start_c"},
    {B::kChargeTemperatureMinRange, "bms.charge_temperature_min_c", kAtLeast, "", bc::kTemperatureRangeMin.raw(),
     "the range of Temperatures in car.dbc"},
    {B::kDeratingStart, "bms.temperature_derating_start_c", kBelow, "bms.temperature_max_c"},
    {B::kTemperatureTripRule, "bms.temperature_max_c", kAtMost, "", bms::check::kTemperatureTripMax.raw(), "EV.7.5"},
    {B::kVoltageTripTime, "bms.voltage_trip_time_s", kAbove},
    {B::kVoltageTripTimeMax, "bms.voltage_trip_time_s", kAtMost, "", bc::kVoltageTripTimeMax.ms()},
    {B::kTemperatureTripTime, "bms.temperature_trip_time_s", kAbove},
    {B::kTemperatureTripTimeMax, "bms.temperature_trip_time_s", kAtMost, "", bc::kTemperatureTripTimeMax.ms()},
    {B::kMeasurementLostTime, "bms.measurement_lost_time_s", kAbove},
    {B::kMeasurementLostTimeMax, "bms.measurement_lost_time_s", kAtMost, "", bc::kMeasurementLostTimeMax.ms()},
    {B::kCurrentTripTime, "bms.current_trip_time_s", kAbove},
    {B::kCurrentTripTimeMax, "bms.current_trip_time_s", kAtMost, "", bc::kCurrentTripTimeMax.ms()},
    {B::kMismatchTime, "bms.voltage_mismatch_time_s", kAbove},
    {B::kMismatchTimeMax, "bms.voltage_mismatch_time_s", kAtMost, "", bc::kMismatchTimeMax.ms()},
    {B::kContactorTime, "bms.contactor_time_s", kAbove},
    {B::kContactorTimeMax, "bms.contactor_time_s", kAtMost, "", bc::kContactorTimeMax.ms()},
    {B::kContactorDropTime, "bms.contactor_drop_time_s", kAtLeast},
    {B::kContactorDropTimeMax, "bms.contactor_drop_time_s", kAtMost, "bms.contactor_time_s"},
    {B::kIsolationTime, "bms.isolation_time_s", kAbove},
    {B::kIsolationTimeMax, "bms.isolation_time_s", kAtMost, "", bc::kIsolationTimeMax.ms()},
    {B::kDischargeTime, "bms.dc_link_discharge_time_s", kAbove},
    {B::kDischargeTimeRule, "bms.dc_link_discharge_time_s", kAtMost, "", bc::kDischargeTimeMax.ms(), "EV.5.4.5"},
    {B::kPrechargeTimeMin, "bms.precharge_time_min_s", kAtLeast},
    {B::kPrechargeTimeout, "bms.precharge_timeout_s", kAbove, "bms.precharge_time_min_s"},
    {B::kPrechargeTimeoutMax, "bms.precharge_timeout_s", kAtMost, "", bc::kPrechargeTimeMax.ms()},
    {B::kPrechargeRatioRule, "bms.precharge_ratio", kAtLeast, "", bms::check::kPrechargeRatioMin.raw(), "EV.5.6"},
    {B::kPrechargeRatioWhole, "bms.precharge_ratio", kBelow, "", bms::check::kWhole.raw()},
    {B::kVoltageMismatch, "bms.voltage_mismatch", kAbove},
    {B::kVoltageMismatchWhole, "bms.voltage_mismatch", kBelow, "", bms::check::kWhole.raw()},
    {B::kDcLinkWelded, "bms.dc_link_welded", kAbove},
    {B::kDcLinkWeldedPrecharge, "bms.dc_link_welded", kBelow, "bms.precharge_ratio"},
    {B::kSocDeratingStart, "bms.soc_derating_start", kAtLeast},
    {B::kSocDeratingStartFull, "bms.soc_derating_start", kBelow, "", bms::check::kFull.raw()},
    {B::kChargerCurrent, "bms.charger_current_max_a", kAtLeast, "", bc::kChargerCurrentMin.raw(),
     "the step of a charger's command; 0: no charger"},
    {B::kChargerCurrentTrip, "bms.charger_current_max_a", kAtMost, "bms.charge_current_trip_a"},
    {B::kChargeMargin, "bms.charge_margin_v", kAtLeast},
    {B::kChargeMarginMax, "bms.charge_margin_v", kAtMost, "", bc::kChargeMarginMax.raw()},
    {B::kChargeCurrentEnd, "bms.charge_current_end_a", kAtLeast, "", bc::kChargerCurrentMin.raw(),
     "the step of a charger's command"},
    {B::kChargeCurrentEndMax, "bms.charge_current_end_a", kAtMost, "bms.charger_current_max_a"},
    {B::kBalancingTime, "bms.balancing_time_max_s", kAtLeast},
    {B::kBalancingTimeMax, "bms.balancing_time_max_s", kAtMost, "", bc::kBalancingTimeMax.ms()},
    {B::kBalancingVoltageMax, "bms.balancing_voltage_min_v", kAtMost, "bms.cell_voltage_plausible_max_v"},
};

constexpr std::string_view kRisingSensor = "sensors whose voltage falls with the pedal are not read";

using M = master::ConfigError;
namespace mc = master::check;
constexpr Row<M> kMasterRows[] = {
    {M::kApps1RangeMin, "master.apps1_range_min_v", kAbove},
    {M::kApps1Released, "master.apps1_released_v", kAbove, "master.apps1_range_min_v"},
    {M::kApps1Full, "master.apps1_full_v", kAbove, "master.apps1_released_v", 0, kRisingSensor},
    {M::kApps1RangeMax, "master.apps1_range_max_v", kAbove, "master.apps1_full_v"},
    {M::kApps1Supply, "master.apps1_range_max_v", kBelow, "", mc::kSupply.raw(), "the sensor's supply"},
    {M::kApps2RangeMin, "master.apps2_range_min_v", kAbove},
    {M::kApps2Released, "master.apps2_released_v", kAbove, "master.apps2_range_min_v"},
    {M::kApps2Full, "master.apps2_full_v", kAbove, "master.apps2_released_v", 0, kRisingSensor},
    {M::kApps2RangeMax, "master.apps2_range_max_v", kAbove, "master.apps2_full_v"},
    {M::kApps2Supply, "master.apps2_range_max_v", kBelow, "", mc::kSupply.raw(), "the sensor's supply"},
    {M::kAppsDisagreement, "master.apps_disagreement_max", kAbove},
    {M::kAppsDisagreementRule, "master.apps_disagreement_max", kAtMost, "", mc::kAppsDisagreementMax.raw(), "T.4.2.4"},
    {M::kPedalRelease, "master.pedal_release_level", kAbove},
    {M::kPedalReleaseRule, "master.pedal_release_level", kAtMost, "", mc::kPedalReleaseMax.raw(), "EV.4.7"},
    {M::kBrakeThrottle, "master.brake_throttle_limit", kAbove, "master.pedal_release_level"},
    {M::kBrakeThrottleRule, "master.brake_throttle_limit", kAtMost, "", mc::kBrakeThrottleMax.raw(), "EV.4.7"},
    {M::kDeadZone, "master.pedal_dead_zone", kAtLeast},
    {M::kDeadZoneMax, "master.pedal_dead_zone", kAtMost, "", mc::kDeadZoneMax.raw()},
    {M::kPedalAtHalf, "master.pedal_at_half", kAtLeast, "", mc::kPedalAtHalfMin.raw()},
    {M::kPedalAtHalfMax, "master.pedal_at_half", kAtMost, "", mc::kPedalAtHalfMax.raw()},
    {M::kBrakePressed, "master.brake_pressed_bar", kAbove},
    {M::kBrakeCompare, "master.brake_compare_bar", kAbove, "master.brake_pressed_bar"},
    {M::kRegenFull, "master.regen_full_brake_bar", kAbove, "master.brake_pressed_bar"},
    {M::kPhaseCurrent, "master.phase_current_max_a", kAbove},
    {M::kPhaseCurrentRange, "master.phase_current_max_a", kAtMost, "", mc::kPhaseCurrentMax.raw(),
     "what the master controller can ask of all motors"},
    {M::kRequestRise, "master.request_rise_a_per_s", kAbove},
    {M::kRegenCurrent, "master.regen_current_max_a", kAtLeast},
    {M::kRegenCurrentPhase, "master.regen_current_max_a", kAtMost, "master.phase_current_max_a"},
    {M::kMotorConstantMin, "master.motor_constant_nm_per_a", kAtLeast, "", mc::kMotorConstantMinUnm},
    {M::kMotorConstantMax, "master.motor_constant_nm_per_a", kAtMost, "", mc::kMotorConstantMaxUnm},
    {M::kMotorSpeed, "master.motor_speed_max_rpm", kAbove},
    {M::kMotorSpeedRange, "master.motor_speed_max_rpm", kAtMost, "", mc::kMotorSpeedMax.raw()},
    {M::kMotorSpeedRangeAmk, "master.motor_speed_max_rpm", kAtMost, "", mc::kMotorSpeedMaxAmk.raw()},
    {M::kMotorCurrent, "inverter.current_max_a", kAbove},
    {M::kFrontDriveShare, "powertrain.front_torque_share", kAtLeast},
    {M::kFrontDriveShareMax, "powertrain.front_torque_share", kAtMost, "", mc::kWhole.raw()},
    {M::kFrontBrakeShare, "powertrain.front_braking_share", kAtLeast},
    {M::kFrontBrakeShareMax, "powertrain.front_braking_share", kAtMost, "", mc::kWhole.raw()},
    {M::kNominalTorque, "inverter.amk_nominal_torque_nm", kAbove},
    {M::kDriveEfficiencyMin, "master.drive_efficiency", kAtLeast, "", mc::kDriveEfficiencyMin.raw()},
    {M::kDriveEfficiencyMax, "master.drive_efficiency", kAtMost, "", mc::kWhole.raw()},
    {M::kPower, "master.power_max_kw", kAbove},
    {M::kPowerRule, "master.power_max_kw", kAtMost, "", mc::kPowerMaxMw, "EV.3.3"},
    {M::kCeilingRise, "master.ceiling_rise_a_per_s", kAbove},
    {M::kTrimGain, "master.trim_gain", kAtLeast},
    {M::kTrimGainWhole, "master.trim_gain", kAtMost, "", mc::kWhole.raw()},
    {M::kTrimMax, "master.trim_max", kAtLeast},
    {M::kTrimMaxWhole, "master.trim_max", kAtMost, "", mc::kWhole.raw()},
    {M::kTrimDecay, "master.trim_decay_per_s", kAbove},
    {M::kBatteryLimitOff, "master.battery_limit_off_a", kAtLeast},
    {M::kBatteryLimitOn, "master.battery_limit_on_a", kAtLeast, "master.battery_limit_off_a"},
    {M::kRegenSpeedRule, "master.regen_speed_min_mps", kAtLeast, "", mc::kRegenSpeedMin.raw(), "EV.3.3.3"},
    {M::kPackResistance, "battery.contact_resistance_ohm", kAtLeast},
    {M::kPackResistanceMax, "battery.contact_resistance_ohm", kAtMost, "", mc::kPackResistanceMax.raw()},
    {M::kLimpShare, "master.limp_share", kAtLeast},
    {M::kLimpShareMax, "master.limp_share", kAtMost, "", mc::kLimpShareMax.raw()},
    {M::kInverterExcess, "master.inverter_excess_max_a", kAbove},
    {M::kInverterExcessMax, "master.inverter_excess_max_a", kAtMost, "", mc::kInverterExcessMax.raw()},
    {M::kMotorDerating, "master.motor_derating_start_c", kBelow, "master.motor_derating_end_c"},
    {M::kInverterDerating, "master.inverter_derating_start_c", kBelow, "master.inverter_derating_end_c"},
    {M::kAppsImplausibleTime, "master.apps_implausible_time_s", kAbove},
    {M::kAppsImplausibleTimeRule, "master.apps_implausible_time_s", kAtMost, "", mc::kImplausibleTimeMax.ms(),
     "T.4.2.5"},
    {M::kBrakeSensorFailTime, "master.brake_sensor_fail_time_s", kAbove},
    {M::kBrakeSensorFailTimeRule, "master.brake_sensor_fail_time_s", kAtMost, "", mc::kImplausibleTimeMax.ms(),
     "T.4.3"},
    {M::kRxTimeout, "master.rx_timeout_s", kAbove},
    {M::kRxTimeoutMax, "master.rx_timeout_s", kAtMost, "", mc::kRxTimeoutMax.ms()},
    {M::kTsRequestTimeout, "master.ts_request_timeout_s", kAbove},
    {M::kTsRequestTimeoutMax, "master.ts_request_timeout_s", kAtMost, "", mc::kTsRequestTimeoutMax.ms()},
    {M::kRtdSoundTimeMin, "master.rtd_sound_time_s", kAtLeast, "", mc::kRtdSoundMin.ms(), "EV.9"},
    {M::kRtdSoundTimeMax, "master.rtd_sound_time_s", kAtMost, "", mc::kRtdSoundMax.ms(), "EV.9"},
};

const char* words(Order order) {
  switch (order) {
    case kBelow: return "below";
    case kAtMost: return "at most";
    case kAbove: return "above";
    case kAtLeast: return "at least";
  }
  return "";
}

std::string with_unit(double value, std::string_view unit) {
  return unit == "1" ? fmt::format("{:g}", value) : fmt::format("{:g} {}", value, unit);
}

/// "bms.x = 60 degC", with what it is rounded to and what it follows when it is not as it stands in a file.
template <class Config>
std::string statement(const VehicleParameters& car, const Config& config, const FirmwareKey<Config>& key) {
  const ParameterRow& row = *find_parameter(key.key);
  const double held = static_cast<double>(key.get(config)) / key.counts_per_unit, given = number_value(row, car);
  std::string out = fmt::format("{} = {}", key.key, with_unit(held, row.unit));
  if (!is_given(row, car)) {
    out += fmt::format(" (from {})", row.followed.words);
  } else if (std::abs(given - held) > 1e-9 * std::max(1.0, std::abs(held))) {
    out += fmt::format(" ({:.10g} to the firmware's nearest {})", given, firmware_step_text(key.key));
  }
  return out;
}

template <class Config>
const FirmwareKey<Config>* find_key(std::span<const FirmwareKey<Config>> keys, std::string_view name) {
  const auto found = std::find_if(keys.begin(), keys.end(), [&](const auto& key) { return key.key == name; });
  return found == keys.end() ? nullptr : &*found;
}

/// A row whose keys are both in the table of keys.
template <class Config, class Error>
Refusal in_words(const VehicleParameters& car, const Config& config, const Row<Error>& row,
                 std::span<const FirmwareKey<Config>> keys) {
  const FirmwareKey<Config>* key = find_key(keys, row.key);
  VOLTLAP_DEMAND(key != nullptr);
  const double step = 1.0 / key->counts_per_unit;
  Refusal out{.key = row.key, .order = row.order, .other = row.other, .step = step, .reason = row.reason};
  std::string bound;
  if (row.other.empty()) {
    out.bound = row.counts * step;
    bound = with_unit(out.bound, find_parameter(row.key)->unit);
  } else {
    const FirmwareKey<Config>* other = find_key(keys, row.other);
    VOLTLAP_DEMAND(other != nullptr && other->counts_per_unit == key->counts_per_unit);
    out.bound = other->get(config) * step;
    bound = statement(car, config, *other);
  }
  out.sentence = fmt::format("{}, which is not {} {}", statement(car, config, *key), words(row.order), bound);
  return out;
}

template <class Error, std::size_t N>
const Row<Error>* find_row(const Row<Error> (&rows)[N], Error error) {
  const auto of_error = [error](const Row<Error>& row) { return row.error == error; };
  const auto found = std::find_if(std::begin(rows), std::end(rows), of_error);
  return found == std::end(rows) ? nullptr : &*found;
}

/// What is no comparison of two keys: tables, a share, the BMS's idea of the capacity.
Refusal table_refusal(const VehicleParameters& car, const bms::Config& config, B error) {
  const bool own_ocv = !car.bms.ocv_v.empty();
  switch (error) {
    case B::kTemperatureSensorsShare: {
      const double least = std::ceil(config.cells_in_series / 5.0);
      return {.key = "sensors.temperature_count", .order = kAtLeast, .other = "battery.cells_in_series",
              .bound = least, .step = 1.0,
              .sentence = fmt::format("sensors.temperature_count = {}, which is not at least {:g}, a fifth of "
                                      "battery.cells_in_series = {}",
                                      config.temperature_sensors, least, config.cells_in_series),
              .reason = "EV.7.5"};
    }
    case B::kCapacity: {
      const double most = 1e-3 * bms::check::kCapacityMaxMah;
      const std::string_view key = car.bms.capacity_ah > 0.0 ? "bms.capacity_ah" : "battery.capacity_ah";
      return {.key = key, .order = config.capacity_mah > 0 ? kAtMost : kAbove,
              .bound = config.capacity_mah > 0 ? most : 0.0, .step = 1e-3,
              .sentence = fmt::format("{} Ah in a parallel group, which is not above 0 and at most {:g} Ah",
                                      1e-3 * config.capacity_mah, most)};
    }
    case B::kOcvPoints:
      return {.key = own_ocv ? "bms.ocv_soc" : "cell.ocv",
              .sentence = fmt::format("{} points, which is not 2 to {}", config.ocv.count, bms::kMaxTablePoints)};
    case B::kOcvSoc:
      return {.key = own_ocv ? "bms.ocv_soc" : "cell.ocv", .sentence = "points that do not rise from 0 to 1"};
    case B::kOcvVoltage:
      return {.key = own_ocv ? "bms.ocv_v" : "cell.ocv", .sentence = "voltages that do not rise from above 0 V"};
    case B::kBranchResistance:
      return {.key = "cell.r0", .sentence = "a resistance that is negative or above half an ohm"};
    case B::kBranchTime:
      return {.key = "cell.tau1", .sentence = "a time constant beyond 0.5 s to 28 h"};
    case B::kBranchSlopesCurrent:
      return {.key = "cell.breakpoints.current_a",
              .sentence = "parts of the circuit that change too much with current"};
    case B::kBranchWarmth:
      return {.key = "cell.breakpoints.temperature_c",
              .sentence = "parts of the circuit that change too much with temperature"};
    default:
      return {.key = car.bms.resistance_ohm > 0.0 ? "bms.resistance_ohm" : "cell.r0",
              .sentence = "a resistance below the firmware's microohm"};
  }
}

/// Where the values stand that cannot both be: what was set by hand before what a file says.
std::string place_of(const Refusal& refusal, const VehicleParameters& car, const Origins& origins) {
  std::string out;
  for (const std::string_view key : {refusal.key, refusal.other}) {
    const ParameterRow* row = find_parameter(key);
    for (const std::string_view candidate : {key, row == nullptr ? key : row->followed.words}) {
      const auto given = origins.find(std::string(candidate));
      if (given == origins.end()) continue;
      if (given->second.starts_with("--set")) return given->second;
      if (out.empty()) out = fmt::format("{}, {}", given->second, candidate);
    }
  }
  return out.empty() ? fmt::format("vehicle {}, {}", car.name, refusal.key) : out;
}

}  // namespace

std::optional<Refusal> refusal(const VehicleParameters& car, const bms::Config& config) {
  const B error = bms::config_check(config);
  if (error == B::kNone) return std::nullopt;
  const Row<B>* row = error == B::kCapacity ? nullptr : find_row(kBmsRows, error);
  return row == nullptr ? table_refusal(car, config, error) : in_words(car, config, *row, bms_keys());
}

std::optional<Refusal> refusal(const VehicleParameters& car, const master::Config& config) {
  const M error = master::config_check(config);
  if (error == M::kNone) return std::nullopt;
  const Row<M>* row = find_row(kMasterRows, error);
  VOLTLAP_DEMAND(row != nullptr);
  return in_words(car, config, *row, master_keys());
}

void refuse(const std::optional<Refusal>& refusal, const VehicleParameters& car, const Origins& origins) {
  if (!refusal) return;
  const std::string where = place_of(*refusal, car, origins);
  const auto of = [&](std::string_view section) { return refusal->key.starts_with(section); };
  const bool master = of("master.") || of("inverter.") || of("powertrain.");
  const char* node = master ? "the master controller" : "the BMS";
  const std::string reason = refusal->reason.empty() ? "" : fmt::format(" ({})", refusal->reason);
  throw InputError(where, refusal->sentence, fmt::format("what {} accepts{}", node, reason),
                   refusal->other.empty() ? "Correct the value" : "Change one of the two");
}

}  // namespace voltlap::plant
