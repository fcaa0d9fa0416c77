// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "learn/bench/forecast.hpp"

namespace voltlap::plant {
namespace {

/// Seconds in at most four characters; "." for never.
std::string seconds_text(double s) {
  if (s < 0.5) return ".";
  return s < 9999.5 ? fmt::format("{:.0f}", s) : fmt::format("{:.0f}h", s / 3600.0);
}

std::string tests_table(const Forecast& forecast) {
  std::string out = fmt::format("  {:<12} {:>9} {:>7} {:>6} {:>10} {:>10} {:>8} {:>12}  {}\n", "test", "duration",
                                "pulses", "rests", "charge", "current", "lowest", "cell", "load");
  for (const TestForecast& test : forecast.tests) {
    out += fmt::format("  {:<12} {:>9} {:>7} {:>6} {:>7.1f} Ah {:>8} {:>6.3f} V {:>7} degC  {}\n", test.test.name,
                       hours_text(test.duration_s), test.pulses, test.rests, test.charge_ah,
                       fmt::format("{:.0f}-{:.0f} A", test.current_min_a, test.current_max_a), test.lowest_v,
                       fmt::format("{:.0f}-{:.0f}", test.coldest_c, test.hottest_c), test.test.load);
  }
  return out;
}

bool any_load(const Coverage& map, std::size_t temperature, std::size_t current) {
  for (std::size_t s = 0; s < map.soc().size(); ++s) {
    if (map.load_s(s, temperature, current) >= 0.5) return true;
  }
  return false;
}

std::string coverage_map(const Coverage& map) {
  std::string out = fmt::format(
      "Seconds under load near each breakpoint of the cell's tables (. never); {} of {} nodes visited\n",
      map.visited(), map.nodes());
  out += fmt::format("  {:>7} {:>7} |", "degC", "A \\ SOC");
  for (const double soc : map.soc()) out += fmt::format(" {:>5}", fmt::format("{:.3g}", soc));
  out += "\n";
  for (std::size_t t = 0; t < map.temperature_c().size(); ++t) {
    for (std::size_t c = 0; c < map.current_a().size(); ++c) {
      if (!any_load(map, t, c)) continue;
      out += fmt::format("  {:>7} {:>7} |", map.temperature_c()[t], map.current_a()[c]);
      for (std::size_t s = 0; s < map.soc().size(); ++s)
        out += fmt::format(" {:>5}", seconds_text(map.load_s(s, t, c)));
      out += "\n";
    }
  }
  return out;
}

std::string rests_text(const BenchPlan& plan, const Forecast& forecast) {
  const RestSummary& rests = forecast.rests;
  if (rests.count == 0) return "No rest follows a load: no time constant can be seen.\n";
  std::string out = fmt::format(
      "{} rests after loads, {:.1f} to {:.1f} min (median {:.1f}): they show time constants from about {:.2g} s "
      "(two rows) to {:.0f} s (the longest rest).\n",
      rests.count, rests.shortest_s / 60.0, rests.longest_s / 60.0, rests.median_s / 60.0, 2.0 * forecast.row_s,
      rests.longest_s);
  out += fmt::format("There the cell file's {}; ", taus_text(rests));
  out +=
      rests.shorter_than_last_tau == 0
          ? fmt::format("every rest outlasts tau{}.\n", rests.taus.size())
          : fmt::format(
                "{} rests are shorter than tau{} and show only a part of the slow branch; {} makes them longer.\n",
                rests.shorter_than_last_tau, rests.taus.size(),
                plan.rest.rule == "fixed" ? "a larger rest.seconds" : "a smaller rest.rise_v_per_min");
  return out;
}

}  // namespace

std::string hours_text(double seconds) {
  const long minutes = std::lround(seconds / 60.0);
  return fmt::format("{}:{:02} h", minutes / 60, minutes % 60);
}

const char* end_name(TestEnd end) {
  switch (end) {
    case TestEnd::kVoltage:
      return "cell voltage";
    case TestEnd::kTemperature:
      return "cell temperature";
    case TestEnd::kInterrupted:
      return "interrupted";
    default:
      return "program";
  }
}

std::string forecast_text(const Campaign& campaign, const Forecast& forecast) {
  const BenchPlan& plan = campaign.plan();
  std::string out =
      fmt::format("Plan {}: {} test{} of {} cells {} in series, box {}\n", plan.name, forecast.tests.size(),
                  forecast.tests.size() == 1 ? "" : "s", plan.cells.count, campaign.cell().name, plan.box.mode);
  out += tests_table(forecast);
  out += fmt::format("  {} on the bench", hours_text(forecast.bench_s));
  if (forecast.tests.size() > 1) {
    out += fmt::format(", {:.1f} days with {:.0f} h of charge and rest between the tests",
                       forecast.calendar_s / 86400.0, plan.test.pause_h);
  }
  out += fmt::format("; a run may differ by {:.0f} %\n\n", 100.0 * kForecastMargin);
  out += coverage_map(forecast.coverage) + "\n" + rests_text(plan, forecast);
  const auto hot = std::find_if(forecast.tests.begin(), forecast.tests.end(),
                                [](const TestForecast& t) { return t.end == TestEnd::kTemperature; });
  if (hot != forecast.tests.end())
    out += fmt::format("Test {} ends at {} degC, before the cell is empty.\n", hot->test.name,
                       plan.stop.cell_temperature_max_c);
  return out;
}

}  // namespace voltlap::plant
