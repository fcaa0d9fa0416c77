// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/campaign_index.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/parameter_table.hpp"
#include "learn/bench/plan_rows.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

Json plan_json(const BenchPlan& plan) {
  Json out = {{"name", plan.name}, {"kind", plan.kind}};
  BenchPlan copy = plan;
  for (const PlanRow& row : plan_rows()) {
    if (row.kinds.find(plan.kind) == std::string_view::npos) continue;
    std::visit([&](auto access) { out[std::string(row.key)] = access(copy); }, row.access);
  }
  return out;
}

Json coverage_json(const Coverage& map) {
  Json load = Json::array(), rest = Json::array();
  for (std::size_t s = 0; s < map.soc().size(); ++s) {
    Json load_rows = Json::array(), rest_rows = Json::array();
    for (std::size_t t = 0; t < map.temperature_c().size(); ++t) {
      Json load_row = Json::array(), rest_row = Json::array();
      for (std::size_t c = 0; c < map.current_a().size(); ++c) {
        load_row.push_back(map.load_s(s, t, c));
        rest_row.push_back(map.rest_s(s, t, c));
      }
      load_rows.push_back(load_row);
      rest_rows.push_back(rest_row);
    }
    load.push_back(load_rows);
    rest.push_back(rest_rows);
  }
  return {{"soc", map.soc()},
          {"temperature_c", map.temperature_c()},
          {"current_a", map.current_a()},
          {"visited", map.visited()},
          {"nodes", map.nodes()},
          {"load_s", load},
          {"rest_s", rest}};
}

Json summary_json(const TestForecast& test) {
  return {{"name", test.test.name},
          {"temperature_c", test.test.temperature_c},
          {"current_a", test.test.current_a},
          {"load", test.test.load},
          {"duration_s", test.duration_s},
          {"pulses", test.pulses},
          {"rests", test.rests},
          {"charge_ah", test.charge_ah},
          {"current_min_a", test.current_min_a},
          {"current_max_a", test.current_max_a},
          {"lowest_v", test.lowest_v},
          {"coldest_c", test.coldest_c},
          {"hottest_c", test.hottest_c},
          {"end", end_name(test.end)}};
}

Json forecast_json(const Forecast& forecast) {
  Json tests = Json::array();
  for (const TestForecast& test : forecast.tests) tests.push_back(summary_json(test));
  const RestSummary& rests = forecast.rests;
  Json rests_json = {{"count", rests.count},
                     {"shortest_s", rests.shortest_s},
                     {"median_s", rests.median_s},
                     {"longest_s", rests.longest_s}};
  for (std::size_t k = 0; k < rests.taus.size(); ++k) {
    rests_json[fmt::format("tau{}_min_s", k + 1)] = rests.taus[k].min_s;
    rests_json[fmt::format("tau{}_max_s", k + 1)] = rests.taus[k].max_s;
  }
  rests_json[fmt::format("shorter_than_tau{}", rests.taus.size())] = rests.shorter_than_last_tau;
  return {{"bench_s", forecast.bench_s},
          {"calendar_s", forecast.calendar_s},
          {"margin", kForecastMargin},
          {"tests", tests},
          {"coverage", coverage_json(forecast.coverage)},
          {"rests", rests_json}};
}

Json results_json(const std::vector<TestResult>& results, bool with_truth) {
  Json out = Json::array();
  for (const TestResult& result : results) {
    Json test = summary_json(result.summary);
    test["end_cell"] = result.end_cell;
    test["files"] = result.files;
    if (with_truth) {
      test["truth"] = {{"capacity_ah", result.capacity_ah},
                       {"resistance_scale", result.resistance_scale},
                       {"initial_soc", result.initial_soc}};
    }
    out.push_back(test);
  }
  return out;
}

Json errors_json(const InstrumentErrors& errors) {
  return {{"cell_offset_v", errors.cell_offset_v},
          {"cell_gain", errors.cell_gain},
          {"temperature_offset_k", errors.temperature_offset_k},
          {"current_low_offset_a", errors.current_low_offset_a},
          {"current_low_gain", errors.current_low_gain},
          {"current_high_offset_a", errors.current_high_offset_a},
          {"current_high_gain", errors.current_high_gain}};
}

/// The cell's own keys as they would stand in its file.
Json cell_json(const CellParameters& cell) {
  VehicleParameters car;
  car.cell = cell;
  Json out = Json::object();
  constexpr std::string_view kPrefix = "cell.";
  for (const auto& [key, value] : parameter_values(car)) {
    if (!key.starts_with(kPrefix)) continue;
    Json parsed = Json::parse(value, nullptr, false);
    out[key.substr(kPrefix.size())] = parsed.is_discarded() ? Json(value) : parsed;
  }
  return out;
}

}  // namespace

std::string campaign_index(const Campaign& campaign, const Forecast& forecast,
                           const std::vector<TestResult>& results, const std::vector<std::string>& settings,
                           bool with_truth) {
  Json out = {{"plan", plan_json(campaign.plan())},
              {"cell", campaign.cell().name},
              {"settings", settings},
              {"seed", campaign.seed()},
              {"version", VOLTLAP_VERSION},
              {"forecast", forecast_json(forecast)},
              {"tests", results_json(results, with_truth)}};
  if (with_truth)
    out["truth"] = {{"cell", cell_json(campaign.cell())}, {"instruments", errors_json(campaign.errors())}};
  return out.dump(2) + "\n";
}

}  // namespace voltlap::plant
