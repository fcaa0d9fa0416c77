// SPDX-License-Identifier: Apache-2.0
#include "explain/say/page/race_rows.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "explain/say/page/explanation_body.hpp"
#include "io/page/html_page.hpp"
#include "io/page/html_parts.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

std::string limits_of(const EnduranceResult& r) {
  std::vector<std::string> out;
  for (std::size_t k = 1; k < kLimitReasons; ++k) {
    if (r.limit_active_s[k] > 0.0)
      out.push_back(fmt::format("{} {:.0f} s", limit_reason_name(k), r.limit_active_s[k]));
  }
  return out.empty() ? "never" : fmt::format("{}", fmt::join(out, ", "));
}

std::string outcome_of(const EnduranceResult& r) {
  if (r.finished) return "finished";
  return fmt::format("fails after {:.0f} s, lap {}: {}", r.failure_time_s, r.laps + 1, r.failure_cause);
}

std::string rows_of(const RaceChange& race) {
  using Text = std::function<std::string(const RacePrediction&)>;
  const auto number = [](auto get, int digits) -> Text {
    return [=](const RacePrediction& p) { return fmt::format("{:.{}f}", get(p), digits); };
  };
  const std::pair<const char*, Text> rows[] = {
      {"charge left, % SOC", number([](const RacePrediction& p) { return p.result.end_soc_pct; }, 2)},
      {"hottest cell, °C", number([](const RacePrediction& p) { return p.result.max_battery_temp_c; }, 2)},
      {"lowest cell voltage, V", number([](const RacePrediction& p) { return p.result.min_cell_voltage_v; }, 3)},
      {"of cell", [](const RacePrediction& p) { return fmt::format("{}", p.result.min_cell); }},
      {"lowest pack voltage, V", number([](const RacePrediction& p) { return p.result.min_pack_voltage_v; }, 2)},
      {"energy out, kWh", number([](const RacePrediction& p) { return p.result.energy_out_kwh; }, 3)},
      {"time, s", number([](const RacePrediction& p) { return p.result.total_time_s; }, 1)},
      {"BMS's SOC at the end, error in %",
       number([](const RacePrediction& p) { return p.bms_soc_error_end_pct; }, 2)},
      {"BMS's SOC, largest error in %",
       number([](const RacePrediction& p) { return p.result.bms_soc_error_pct; }, 2)},
      {"held back by limits", [](const RacePrediction& p) { return limits_of(p.result); }},
      {"outcome", [](const RacePrediction& p) { return outcome_of(p.result); }}};
  std::string out;
  for (const auto& [name, text] : rows) {
    out += html_row({name, text(race.before), text(race.after), text(race.after_old_bms)});
  }
  return out;
}

Json prediction_json(const RacePrediction& p) {
  const EnduranceResult& r = p.result;
  Json limited = Json::object();
  for (std::size_t k = 1; k < kLimitReasons; ++k) {
    if (r.limit_active_s[k] > 0.0) limited[limit_reason_name(k)] = r.limit_active_s[k];
  }
  return {{"finished", r.finished},
          {"failure", r.finished ? Json() : Json(r.failure_cause)},
          {"end_soc", 1e-2 * r.end_soc_pct},
          {"temperature_max_c", r.max_battery_temp_c},
          {"cell_voltage_min_v", r.min_cell_voltage_v},
          {"cell_weakest", r.min_cell},
          {"pack_voltage_min_v", r.min_pack_voltage_v},
          {"energy_out_kwh", r.energy_out_kwh},
          {"time_s", r.total_time_s},
          {"bms_soc_error_end", 1e-2 * p.bms_soc_error_end_pct},
          {"bms_soc_error_max", 1e-2 * r.bms_soc_error_pct},
          {"limited_s", limited}};
}

}  // namespace

std::string race_tiles(const RaceChange* race) {
  if (race == nullptr || !race->impossible.empty()) return "";
  const EnduranceResult &a = race->before.result, &b = race->after.result;
  return html_tile("Charge left in the race", fmt::format("{:.1f} → {:.1f}", a.end_soc_pct, b.end_soc_pct), "%",
                   b.finished ? fmt::format("{} laps of {}", race->laps, race->course) : "it fails, see below") +
         html_tile("Hottest cell in the race",
                   fmt::format("{:.1f} → {:.1f}", a.max_battery_temp_c, b.max_battery_temp_c), "°C",
                   fmt::format("lowest cell {:.3f} → {:.3f} V", a.min_cell_voltage_v, b.min_cell_voltage_v));
}

std::string race_section(const RaceChange* race) {
  if (race == nullptr) return "";
  const std::string left_out =
      race->left_out.empty()
          ? ""
          : fmt::format("Not in the race, because the simulated car has no parameter for it: {}.",
                        fmt::join(race->left_out, ", "));
  std::string what, rows;
  if (race->impossible.empty()) {
    what = fmt::format("{} laps of {} with {}. ", race->laps, race->course, race->car);
    rows = rows_of(*race);
  } else {
    rows = html_row({"no prediction", "", "", "this pack cannot drive the car: " + race->impossible});
  }
  return fill_template(html_asset("explain_race.html", explanation_page_files),
                       {{"rows", rows}, {"what", html_text(what)}, {"left_out", html_text(left_out)}});
}

std::string race_json(const RaceChange* race) {
  if (race == nullptr) return "null";
  Json out = {{"course", race->course},
              {"laps", race->laps},
              {"car", race->car},
              {"left_out", race->left_out},
              {"impossible", race->impossible.empty() ? Json() : Json(race->impossible)}};
  if (race->impossible.empty()) {
    out["before"] = prediction_json(race->before);
    out["after"] = prediction_json(race->after);
    out["after_with_given_bms"] = prediction_json(race->after_old_bms);
  }
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace voltlap::plant
