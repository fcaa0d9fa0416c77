// SPDX-License-Identifier: Apache-2.0
#include "race/report/endurance_report_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/parameter_source.hpp"
#include "io/page/html_page.hpp"
#include "io/page/html_parts.hpp"
#include "race/report/run_notes.hpp"
#include "race/report/run_text.hpp"

namespace voltlap::plant {
namespace {

std::string at_time(double seconds) {
  const int tenths = static_cast<int>(std::floor(seconds * 10.0));
  return fmt::format("at {}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10);
}

std::string best_lap(const EnduranceResult& result) {
  if (result.lap_rows.size() < 2) return {};
  const auto best = std::min_element(result.lap_rows.begin(), result.lap_rows.end(),
                                     [](const LapRow& a, const LapRow& b) { return a.time_s < b.time_s; });
  return html_tile("Fastest lap", fmt::format("{:.2f}", best->time_s), "s", fmt::format("lap {}", best->lap));
}

std::string tiles(const ReportedRun& reported) {
  const EnduranceResult& r = reported.result;
  const ExtremeTimes& at = r.extreme_times;
  const bool drove = was_ready_to_drive(r), drive = reported.run.lap_start == "drive";
  std::string out;
  out += html_tile(r.finished ? "Total time" : "Failed after", fmt::format("{:.1f}", r.total_time_s), "s",
              duration_text(r.total_time_s));
  if (!drive) out += html_tile("Laps", fmt::format("{}", r.laps), fmt::format("of {}", reported.run.laps));
  out += best_lap(r);
  out += html_tile("Distance", fmt::format("{:.2f}", r.distance_m / 1000.0), "km");
  out += html_tile("Charge left", fmt::format("{:.1f}", r.end_soc_pct), "% SOC",
              !drove         ? ""
              : r.bms_counts ? fmt::format("BMS estimate off by {:.2f} points at most", r.bms_soc_error_pct)
                             : "the BMS keeps no count");
  out += html_tile("Energy out", fmt::format("{:.3f}", r.energy_out_kwh), "kWh", "at the pack's terminals");
  if (r.energy_back_kwh >= 5e-4) {
    out += html_tile("Regenerated", fmt::format("{:.3f}", r.energy_back_kwh), "kWh",
                     fmt::format("{:.1f} % more range", 100.0 * r.energy_back_kwh / r.energy_out_kwh));
  }
  if (drove) {
    out += html_tile("Hottest cell", fmt::format("{:.1f}", r.max_battery_temp_c), "°C", at_time(at.battery_temp_s));
    out += html_tile("Peak current", fmt::format("{:.1f}", r.max_battery_current_a), "A",
                     at_time(at.battery_current_s));
    out +=
        html_tile("Lowest pack voltage", fmt::format("{:.1f}", r.min_pack_voltage_v), "V", at_time(at.pack_voltage_s));
    out += html_tile("Lowest cell voltage", fmt::format("{:.3f}", r.min_cell_voltage_v), "V",
                fmt::format("{}, {}",
                            cells_alike(reported.run, reported.car.parameters) ? "all cells alike"
                                                                               : fmt::format("cell {}", r.min_cell),
                            at_time(at.cell_voltage_s)));
    out += html_tile("Top speed", fmt::format("{:.1f}", r.max_speed_mps), "m/s",
                fmt::format("{:.0f} km/h, {}", r.max_speed_mps * 3.6, at_time(at.speed_s)));
    const bool limited = limits_text(r) != "none";
    double held_s = 0.0;
    for (std::size_t i = 1; i < kLimitReasons; ++i) held_s += r.limit_active_s[i];
    out += html_tile("Held back by limits", limited ? fmt::format("{:.1f}", held_s) : "never", limited ? "s" : "",
                limited ? limits_text(r) : "");
  }
  return out;
}

std::string lap_rows(const EnduranceResult& result) {
  std::string out;
  double best_s = 1e300;
  for (const LapRow& row : result.lap_rows) best_s = std::min(best_s, row.time_s);
  for (const LapRow& row : result.lap_rows) {
    fmt::format_to(
        std::back_inserter(out),
        "<tr data-lap=\"{0}\"><th scope=\"row\">{0}</th><td>{1:.2f}</td><td>{2:+.2f}</td><td>{3:.4f}</td>"
        "<td>{4:.2f}</td><td>{5:.1e}</td></tr>\n",
        row.lap, row.time_s, row.time_s - best_s, row.energy_kwh, row.end_soc_pct, row.ledger_error_pct);
  }
  return out.empty() ? "<tr><td colspan=\"6\">No lap was completed.</td></tr>" : out;
}

std::string ledger_rows(const EnergyLedger& ledger) {
  const double source_j = ledger[EnergyTerm::kBatteryChemical];
  const auto share = [&](double joules) {
    return source_j != 0.0 ? fmt::format("{:.2f}", 100.0 * joules / source_j) : "–";
  };
  std::string out;
  double sum_j = 0.0;
  for (std::size_t i = 1; i < kEnergyTerms; ++i) {
    const auto term = static_cast<EnergyTerm>(i);
    sum_j += ledger[term];
    fmt::format_to(std::back_inserter(out), "<tr><th scope=\"row\">{}</th><td>{:.4f}</td><td>{}</td></tr>\n",
                   energy_term_name(term), ledger[term] / kJoulesPerKwh, share(ledger[term]));
  }
  return out + fmt::format(
                   "<tr class=\"sum\"><th scope=\"row\">sum</th><td>{:.4f}</td><td>{}</td></tr>\n"
                   "<tr class=\"sum\"><th scope=\"row\">battery_chemical</th><td>{:.4f}</td><td>{}</td></tr>\n",
                   sum_j / kJoulesPerKwh, share(sum_j), source_j / kJoulesPerKwh, share(source_j));
}

/// What was changed for this run comes first.
std::string parameter_table_rows(const LoadedVehicle& car) {
  const auto is_set = [](const ParameterSource& p) { return p.place == "--set"; };
  std::vector<ParameterSource> sources = parameter_sources(car);
  std::stable_partition(sources.begin(), sources.end(), is_set);
  std::string out;
  for (const ParameterSource& p : sources) {
    const bool set = is_set(p);
    const std::string source = p.source.empty()
                                   ? html_text(p.place)
                                   : fmt::format("{} <small>{}</small>", html_text(p.source), html_text(p.place));
    fmt::format_to(
        std::back_inserter(out),
        "<tr{}><th scope=\"row\"><code>{}</code><small>{}</small></th><td class=\"value\">{}</td><td>{}</td>"
        "<td>{}</td></tr>\n",
        set ? " class=\"changed\"" : "", html_text(p.key), html_text(p.meaning), html_text(p.value),
        p.unit == "-" ? "" : html_text(p.unit), source);
  }
  return out;
}

std::string notes(const ReportedRun& reported) {
  std::string out;
  for (const std::string& note : run_notes(reported.run, reported.car.parameters, reported.result)) {
    out += fmt::format("<p class=\"note\">Note: {}.</p>\n", html_text(note));
  }
  return out;
}

/// A section of its own, and nothing where no limit bound.
std::string limit_costs_section(const std::vector<LimitCost>& costs) {
  if (costs.empty()) return {};
  std::string out =
      "<section aria-labelledby=\"limit-costs-title\">\n<h2 id=\"limit-costs-title\">What the limits cost</h2>\n"
      "<div class=\"card\">\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"What the limits "
      "cost\">\n<table class=\"words\">\n<thead><tr><th scope=\"col\">limit</th><th scope=\"col\">held back, s</th>"
      "<th scope=\"col\">without it</th><th scope=\"col\">what was lifted</th></tr></thead>\n"
      "<tbody>\n";
  for (const LimitCost& cost : costs) {
    fmt::format_to(std::back_inserter(out),
                   "<tr><th scope=\"row\">{}</th><td>{:.1f}</td><td>{}</td><td>{}</td></tr>\n",
                   html_text(cost.reason), cost.active_s, html_text(cost_text(cost)), html_text(lifted_text(cost)));
  }
  return out +
         "</tbody>\n</table>\n</div>\n<p class=\"note\">The same race again with one limit lifted as far as the "
         "firmware and the rules allow; all: every one of them at once.</p>\n</div>\n</section>\n";
}

std::string run_facts(const ReportedRun& reported) {
  const RunDescription& run = reported.run;
  std::string settings;
  for (const std::string& setting : run.settings) settings += (settings.empty() ? "" : " ") + setting;
  return html_fact("vehicle", run.vehicle) + html_fact("course", run.course) +
         html_fact("lap start", run.lap_start) + html_fact("cells", run.cells) +
         html_fact("--set", settings.empty() ? "nothing" : settings) +
         html_fact("seed", fmt::format("{}", run.seed)) + html_fact("version", VOLTLAP_VERSION) +
         html_fact("CAN frames", fmt::format("{}", reported.result.frames)) +
         html_fact("computed in", fmt::format("{:.1f} s", reported.wall_s)) +
         html_fact("trace hash", reported.hash.trace) +
         html_fact("hash of the plant's frames", reported.hash.plant) +
         html_fact("hash of the BMS's frames", reported.hash.bms) +
         html_fact("hash of the master's frames", reported.hash.master);
}

}  // namespace

std::string html_report_body(const ReportedRun& reported) {
  const RunDescription& run = reported.run;
  const bool finished = reported.result.finished, low = reported.result.beyond.cell_low_s > 0.0;
  const std::string facts =
      fmt::format("{} on {}{}, seed {}, voltlap {}", run.vehicle, run.course,
                  run.lap_start == "drive" ? "" : ", " + run.lap_start + " start", run.seed, VOLTLAP_VERSION);
  return fill_template(html_asset("endurance.html", endurance_page_files),
                       {{"status_class", !finished ? "bad" : low ? "open" : "good"},
                        {"status", !finished ? "✕ Failed" : low ? "✓ Finished, a cell below its least voltage"
                                                               : "✓ Finished"},
                        {"headline", html_text(headline(run, reported.car.parameters, reported.result))},
                        {"facts", html_text(facts)},
                        {"notes", notes(reported)},
                        {"tiles", tiles(reported)},
                        {"limit_costs", limit_costs_section(reported.limit_costs)},
                        {"lap_rows", lap_rows(reported.result)},
                        {"ledger_rows", ledger_rows(reported.result.ledger)},
                        {"ledger_error", fmt::format("{:.1e}", reported.result.ledger.error_pct())},
                        {"parameter_rows", parameter_table_rows(reported.car)},
                        {"run_facts", run_facts(reported)}});
}

}  // namespace voltlap::plant
