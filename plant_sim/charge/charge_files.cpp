// SPDX-License-Identifier: Apache-2.0
#include "charge/charge_files.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "charge/charge_text.hpp"
#include "core/parameter_table.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

Json result_json(const ChargeResult& r) {
  return {{"full", r.full},
          {"ending", ending_words(r)},
          {"phase", phase_name(r.phase)},
          {"reason", reason_name(r.reason)},
          {"time_s", r.time_s},
          {"waiting_s", r.waiting_s},
          {"charging_s", r.charging_s},
          {"bleeding_s", r.bleeding_s},
          {"resting_s", r.resting_s},
          {"first_full_s", std::isfinite(r.first_held_s) ? Json(r.first_held_s) : Json()},
          {"begin_soc", r.begin_soc},
          {"end_soc", r.end_soc},
          {"end_soc_emptiest", r.end_soc_min},
          {"bms_soc", r.bms_soc},
          {"highest_cell_v", r.highest_cell_v},
          {"highest_cell", r.highest_cell + 1},
          {"begin_spread_v", r.begin_spread_v},
          {"end_spread_v", r.end_spread_v()},
          {"charge_in_ah", r.charge_in_ah},
          {"energy_in_wh", r.energy_in_wh},
          {"charger_wh", r.charger_wh},
          {"bled_ah", r.bled_ah},
          {"bled_wh", r.bled_wh},
          {"bled_with_shutdown_open_s", r.bled_open_s},
          {"temperature_max_c", r.temperature_max_c},
          {"frames", r.frames},
          {"ticks", r.ticks}};
}

}  // namespace

std::string charge_json(const ChargeDescription& run, const VehicleParameters& car, const ChargeResult& result) {
  Json parameters = Json::object();
  for (const auto& [key, value] : parameter_values(car)) parameters[key] = value;
  const Json out = {{"command", "charge"},
                    {"version", VOLTLAP_VERSION},
                    {"vehicle", run.vehicle},
                    {"settings", run.settings},
                    {"seed", run.seed},
                    {"drawn_cells", run.drawn_cells},
                    {"from_soc", run.from_soc},
                    {"to_soc", run.to_soc},
                    {"result", result_json(result)},
                    {"parameters", parameters},
                    {"computed_s", run.wall_s}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string charge_csv(const std::vector<ChargeSample>& samples) {
  std::string out =
      "time_s,phase,reason,soc,soc_min,soc_max,cell_min_v,cell_max_v,open_spread_v,current_a,asked_a,pack_v,"
      "temperature_c,cells_bled\n";
  for (const ChargeSample& s : samples) {
    out += fmt::format("{:.0f},{},{},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.3f},{:.1f},{:.3f},{:.2f},{}\n",
                       s.time_s, phase_name(s.phase), reason_name(s.reason), s.soc, s.soc_min, s.soc_max, s.cell_min_v,
                       s.cell_max_v, s.open_spread_v, s.current_a, s.asked_a, s.pack_v, s.temperature_c, s.cells_bled);
  }
  return out;
}

}  // namespace voltlap::plant
