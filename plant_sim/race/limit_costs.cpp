// SPDX-License-Identifier: Apache-2.0
#include "race/limit_costs.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/demand.hpp"
#include "core/parameter_table.hpp"

namespace voltlap::plant {
namespace {

constexpr const char* kTogether = "all";

/// What sets how far a key may go, where it is a rule.
std::string_view rule_of(std::string_view key) {
  if (key == "master.power_max_kw") return " (EV.3.3 allows no more)";
  if (key == "bms.temperature_max_c") return " (EV.7.5 allows no more)";
  return "";
}

/// All that could lift a limit. What the firmware or the rules hold stays: 60 degC (EV.7.5), 80 kW (EV.3.3).
std::vector<LiftedKey> lifts(std::string_view reason, const VehicleParameters& car) {
  constexpr double kAboveBrokenWire_v = 0.1;
  const double lowest_v = car.bms.cell_voltage_plausible_min_v + kAboveBrokenWire_v;
  if (reason == "config_maximum")
    return {{"bms.discharge_current_max_a", 1000.0}, {"bms.discharge_current_trip_a", 1000.0}};
  if (reason == "cell_voltage")
    return {{"bms.cell_voltage_min_v", lowest_v}, {"bms.cell_voltage_trip_low_v", lowest_v}};
  if (reason == "temperature")
    return {{"bms.temperature_max_c", 60.0}, {"bms.temperature_derating_start_c", 59.9}};
  if (reason == "soc_low") return {{"bms.soc_derating_start", 0.0}};
  if (reason == "energy_to_go") return {{"bms.energy_to_go_km", 0.0}};
  if (reason == "charge_limit") {
    return {{"bms.charge_current_max_a", 1000.0},     {"bms.charge_current_trip_a", 1000.0},
            {"bms.cell_voltage_max_v", 4.9},          {"bms.cell_voltage_trip_high_v", 4.9},
            {"bms.cell_voltage_plausible_max_v", 5.0}, {"bms.charge_temperature_min_c", -40.0}};
  }
  if (reason == "power") return {{"master.power_max_kw", 80.0}};
  if (reason == "motor_speed") return {{"master.motor_speed_max_rpm", 12000.0}};
  if (reason == "motor_temperature") {
    return {{"master.motor_derating_start_c", 499.0},    {"master.motor_derating_end_c", 500.0},
            {"master.inverter_derating_start_c", 499.0}, {"master.inverter_derating_end_c", 500.0}};
  }
  return {};
}

LimitCost cost_of(const std::string& reason, std::vector<LiftedKey> lifted, const EnduranceResult& with,
                  const EnduranceResult& without) {
  VOLTLAP_DEMAND(!lifted.empty() && with.finished);
  LimitCost cost{.reason = reason, .lifted = std::move(lifted)};
  if (without.finished) {
    cost.time_s = with.total_time_s - without.total_time_s;
    cost.soc_points = with.end_soc_pct - without.end_soc_pct;
  } else {
    cost.failure = fmt::format("{}, after {:.1f} s", without.failure_cause, without.failure_time_s);
  }
  VOLTLAP_DEMAND(std::isfinite(cost.time_s) && std::isfinite(cost.soc_points));
  return cost;
}

}  // namespace

std::vector<LiftedKey> lifted_keys(std::size_t reason, const VehicleParameters& car) {
  std::vector<LiftedKey> out = lifts(limit_reason_name(reason), car);
  for (LiftedKey& lifted : out) {
    const ParameterRow* row = find_parameter(lifted.key);
    VOLTLAP_DEMAND(row != nullptr && within(lifted.value, row->low, row->high));
    lifted.from = number_value(*row, car);
    lifted.unit = row->unit;
  }
  std::erase_if(out, [](const LiftedKey& lifted) { return lifted.from == lifted.value; });
  return out;
}

std::vector<std::string> settings_of(const std::vector<LiftedKey>& lifted) {
  std::vector<std::string> out;
  for (const LiftedKey& l : lifted) out.push_back(fmt::format("{}={}", l.key, l.value));
  return out;
}

std::vector<LimitCost> limit_costs(const EnduranceResult& result, const VehicleParameters& car, const Rerun& rerun) {
  VOLTLAP_DEMAND(rerun != nullptr);
  std::vector<LimitCost> out;
  std::vector<LiftedKey> all;
  if (!result.finished) return out;
  for (std::size_t reason = 1; reason < kLimitReasons; ++reason) {
    if (result.limit_active_s[reason] < kLimitTrifle_s) continue;
    const std::vector<LiftedKey> lifted = lifted_keys(reason, car);
    if (lifted.empty()) continue;
    const EnduranceResult without = rerun(limit_reason_name(reason), settings_of(lifted));
    if (without.stopped) return out;
    out.push_back(cost_of(limit_reason_name(reason), lifted, result, without));
    out.back().active_s = result.limit_active_s[reason];
    all.insert(all.end(), lifted.begin(), lifted.end());
  }
  if (out.size() < 2) return out;
  const EnduranceResult without = rerun(kTogether, settings_of(all));
  if (without.stopped) return out;
  LimitCost together = cost_of(kTogether, all, result, without);
  for (const LimitCost& one : out) together.active_s += one.active_s;
  out.push_back(std::move(together));
  return out;
}

std::string cost_text(const LimitCost& cost) {
  if (!cost.failure.empty()) return fmt::format("without it the run fails: {}", cost.failure);
  return fmt::format("lifted, the race is {:.2f} s {} and ends with {:.2f} points of SOC {}", std::abs(cost.time_s),
                     cost.time_s < 0.0 ? "slower" : "faster", std::abs(cost.soc_points),
                     cost.soc_points < 0.0 ? "more" : "less");
}

std::string lifted_text(const LimitCost& cost) {
  std::vector<std::string> parts;
  for (const LiftedKey& l : cost.lifted) {
    parts.push_back(fmt::format("{} {:.4g} -> {:.4g}{}{}", l.key, l.from, l.value, l.unit == "1" ? "" : " " + l.unit,
                                rule_of(l.key)));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string limit_costs_text(const std::vector<LimitCost>& costs) {
  if (costs.empty()) return {};
  std::string out =
      "  what the limits cost: the race again with one limit lifted as far as firmware and rules allow\n";
  for (const LimitCost& cost : costs) {
    out += fmt::format("    {:<18}held back for {:.1f} s; {}\n    {:<18}{}\n", cost.reason, cost.active_s,
                       cost_text(cost), "", cost.reason == kTogether ? "all of the above at once" : lifted_text(cost));
  }
  return out;
}

}  // namespace voltlap::plant
