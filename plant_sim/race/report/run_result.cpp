// SPDX-License-Identifier: Apache-2.0
#include "race/report/run_result.hpp"

#include <nlohmann/json.hpp>

#include <cmath>

#include "core/demand.hpp"
#include "core/parameter_table.hpp"
#include "io/bus/bus_load_table.hpp"
#include "race/report/run_notes.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

Json failure(const EnduranceResult& result) {
  if (result.failure_cause.empty()) return nullptr;
  return {{"time_s", result.failure_time_s}, {"cause", result.failure_cause}};
}

Json limits(const EnduranceResult& result) {
  Json out = Json::object();
  for (std::size_t i = 1; i < kLimitReasons; ++i) out[limit_reason_name(i)] = result.limit_active_s[i];
  return out;
}

Json limit_costs(const std::vector<LimitCost>* costs) {
  if (costs == nullptr) return nullptr;
  Json out = Json::array();
  for (const LimitCost& cost : *costs) {
    Json lifted = Json::array();
    for (const LiftedKey& l : cost.lifted)
      lifted.push_back({{"key", l.key}, {"value", l.value}, {"from", l.from}, {"unit", l.unit}});
    const bool holds = cost.failure.empty();
    out.push_back({{"reason", cost.reason}, {"active_s", cost.active_s},
                   {"time_s", holds ? Json(cost.time_s) : Json(nullptr)},
                   {"soc_points", holds ? Json(cost.soc_points) : Json(nullptr)},
                   {"failure", holds ? Json(nullptr) : Json(cost.failure)}, {"lifted", lifted}});
  }
  return out;
}

Json extreme_times(const ExtremeTimes& at) {
  return {{"max_battery_current_a", at.battery_current_s}, {"max_speed_mps", at.speed_s},
          {"min_pack_voltage_v", at.pack_voltage_s}, {"min_cell_voltage_v", at.cell_voltage_s},
          {"max_battery_temp_c", at.battery_temp_s}, {"max_motor_temp_c", at.motor_temp_s},
          {"max_power_kw", at.power_s}, {"max_power_mean_500ms_kw", at.power_mean_s}};
}

Json lap_rows(const EnduranceResult& result) {
  Json out = Json::array();
  for (const LapRow& row : result.lap_rows) {
    out.push_back({{"lap", row.lap}, {"time_s", row.time_s}, {"energy_kwh", row.energy_kwh},
                   {"end_soc_pct", row.end_soc_pct}, {"energy_ledger_error_pct", row.ledger_error_pct},
                   {"distance_m", row.distance_m}});
  }
  return out;
}

Json ledger(const EnduranceResult& result) {
  Json out = Json::object();
  for (std::size_t i = 0; i < kEnergyTerms; ++i) {
    const auto term = static_cast<EnergyTerm>(i);
    out[energy_term_name(term)] = result.ledger[term] / kJoulesPerKwh;
  }
  return out;
}

Json lost_nodes(const EnduranceResult& result) {
  const auto seconds = [](const std::optional<double>& s) { return s ? Json(*s) : Json(nullptr); };
  Json out = Json::array();
  for (const LostNodeRow& row : result.lost_nodes) {
    out.push_back({{"node", row.node}, {"time_s", row.time_s}, {"torque_zero_s", seconds(row.torque_zero_s)},
                   {"contactors_open_s", seconds(row.contactors_open_s)}});
  }
  return out;
}

Json bus_statistics(const BusStatistics* bus) {
  if (bus == nullptr) return {{"interface", nullptr}, {"pacing", "in_process"}};
  return {{"interface", bus->interface}, {"pacing", bus->pacing}, {"foreign_frames", bus->foreign_frames},
          {"missing_frames", bus->missing_frames}, {"dropped_frames", bus->dropped_frames},
          {"error_frames", bus->error_frames}, {"send_retries", bus->send_retries}, {"late_steps", bus->late_steps},
          {"late_worst_s", bus->late_worst_s}};
}

Json step_costs(const StepCosts& costs) {
  if (costs.steps == 0) return nullptr;
  return {{"steps", costs.steps}, {"mean", static_cast<double>(costs.instructions) / static_cast<double>(costs.steps)},
          {"worst", costs.worst}, {"worst_tick", costs.worst_tick}};
}

Json ecu_result(const EcuResult* ecu) {
  if (ecu == nullptr) return nullptr;
  const BoardAccount& board = ecu->board;
  return {{"where", ecu->where}, {"image", ecu->image},
          {"instructions_per_step", {{"bms", step_costs(board.bms)}, {"master", step_costs(board.master)},
                                     {"both", step_costs(board.both)}}},
          {"stack_used_bytes", board.stack_used}, {"stack_size_bytes", board.stack_size}};
}

Json bus_load(const BusLoadResult* load) {
  if (load == nullptr) return nullptr;
  Json ids = Json::array();
  for (const BusLoadRow& row : load->rows) {
    ids.push_back({{"id", id_text(row.id)},
                   {"message", message_name(row.id)},
                   {"frames", row.frames},
                   {"frames_per_s", load->frames_per_s(row)},
                   {"bits_mean", row.bits_mean()},
                   {"bits_worst", row.bits_worst},
                   {"load_pct", load->load_pct(row)},
                   {"share_pct", load->share_pct(row)}});
  }
  return {{"bitrate", load->bit_rate}, {"total_pct", load->total_pct}, {"peak_100ms_pct", load->peak_100ms_pct},
          {"ids", ids}};
}

/// A TOML number, list, switch or plain word is JSON as it stands.
Json parameters(const VehicleParameters& car) {
  Json out = Json::object();
  for (const auto& [key, value] : parameter_values(car)) {
    Json parsed = Json::parse(value, nullptr, false);
    out[key] = parsed.is_discarded() ? Json(value) : parsed;
  }
  return out;
}

}  // namespace

std::string ecu_result_json(const EcuResult& ecu) { return ecu_result(&ecu).dump(2) + "\n"; }

std::string run_result_json(const RunDescription& run, const VehicleParameters& car, const RunOutcome& outcome) {
  const EnduranceResult& result = outcome.result;
  VOLTLAP_DEMAND(outcome.wall_s >= 0.0 && std::isfinite(result.end_soc_pct));
  const Json json = {
      {"status", result.finished ? "finished" : "failed"},
      {"failure", failure(result)},
      {"vehicle", run.vehicle},
      {"course", run.course},
      {"course_length_m", run.course_length_m ? Json(*run.course_length_m) : Json()},
      {"closing_gap_m", run.closing_gap_m ? Json(*run.closing_gap_m) : Json()},
      {"lap_start", run.lap_start},
      {"cells", run.cells},
      {"settings", run.settings},
      {"notes", run_notes(run, car, result)},
      {"laps_asked", run.laps},
      {"end_soc_pct", result.end_soc_pct},
      {"max_battery_temp_c", result.max_battery_temp_c},
      {"total_time_s", result.total_time_s},
      {"max_battery_current_a", result.max_battery_current_a},
      {"min_pack_voltage_v", result.min_pack_voltage_v},
      {"min_cell_voltage_v", result.min_cell_voltage_v},
      {"min_cell", result.min_cell},
      {"max_speed_mps", result.max_speed_mps},
      {"max_motor_temp_c", result.max_motor_temp_c},
      {"max_off_course_m", result.max_off_course_m},
      {"max_power_kw", 1e-3 * result.max_power_w},
      {"max_power_mean_500ms_kw", 1e-3 * result.max_power_mean_w},
      {"extreme_times_s", extreme_times(result.extreme_times)},
      {"cell_below_least_voltage_s", result.beyond.cell_low_s},
      {"over_discharge_limit_s", result.beyond.over_discharge_s},
      {"over_discharge_limit_pct", 100.0 * result.beyond.over_discharge_share},
      {"over_discharge_limit_a", result.beyond.over_discharge_a},
      {"dc_link_below_inverter", result.beyond.link_falls},
      {"distance_m", result.distance_m},
      {"laps", result.laps},
      {"energy_out_kwh", result.energy_out_kwh},
      {"energy_back_kwh", result.energy_back_kwh},
      {"energy_ledger_error_pct", result.energy_ledger_error_pct},
      {"charge_balance_error_pct", result.charge_balance_error_pct},
      {"bms_soc_error_pct", result.bms_counts ? Json(result.bms_soc_error_pct) : Json()},
      {"frames", result.frames},
      {"frames_in_tick_max", result.frames_in_tick_max},
      {"trace_hash", outcome.hash.trace},
      {"hash_plant", outcome.hash.plant},
      {"hash_bms", outcome.hash.bms},
      {"hash_master", outcome.hash.master},
      {"lost_nodes", lost_nodes(result)},
      {"bus", bus_statistics(outcome.bus)},
      {"ecu", ecu_result(outcome.ecu)},
      {"bus_load", bus_load(outcome.load)},
      {"limit_active_s", limits(result)},
      {"limit_costs", limit_costs(outcome.limit_costs)},
      {"lap_rows", lap_rows(result)},
      {"energy_ledger_kwh", ledger(result)},
      {"wall_s", outcome.wall_s},
      {"seed", run.seed},
      {"version", VOLTLAP_VERSION},
      {"parameters", parameters(car)},
  };
  // A file name need not be UTF-8; a JSON text must.
  std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace);
  if (outcome.trace == nullptr) return text + "\n";
  text.erase(text.size() - std::string_view("\n}").size());
  return text + ",\n  \"trace\": " + trace_json(*outcome.trace) + "\n}\n";
}

}  // namespace voltlap::plant
