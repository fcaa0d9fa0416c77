// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/number_text.hpp"
#include "io/page/html_page.hpp"
#include "io/page/html_parts.hpp"
#include "learn/identify/result/identification_report.hpp"
#include "learn/identify/result/excitation.hpp"
#include "learn/identify/result/law_facts.hpp"
#include "learn/identify/result/recording_error.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

/// "25.0 °C, 200 A", "25.0 °C (assumed)".
std::string place_text(double temperature_c, double current_a, bool temperature_told) {
  return fmt::format("{:.1f} °C{}{}", shown(temperature_c, 1), temperature_told ? "" : " (assumed)",
                     current_a > 0.0 ? fmt::format(", {:.0f} A", current_a) : "");
}

std::string place_text(const CellIdentification& identified, const OperatingPoint& point) {
  return place_text(point.temperature_c, point.current_a, identified.temperature_told);
}

std::size_t recordings(const CellIdentification& identified) {
  std::size_t count = 0;
  for (const OperatingPoint& point : identified.points) count += point.result.files.size();
  return count;
}

/// Tables of R and tau that the data settle at a node, out of all.
Index excited_tables(const IdentifyResult& result, Index node) {
  Index count = 0;
  for (Index table = 0; table <= 2 * result.model.branches(); ++table) count += is_excited(result, table, node) ? 1 : 0;
  return count;
}

std::string tiles(const ReportedCell& reported) {
  const CellIdentification& identified = reported.identified;
  const IdentifyResult& reference = identified.reference_point().result;
  Index excited = 0, all = 0;
  for (const OperatingPoint& point : identified.points) {
    const Index tables = 2 * point.result.model.branches() + 1;
    for (Index node = 0; node < point.result.model.grid.size(); ++node, all += tables)
      excited += excited_tables(point.result, node);
  }
  std::string out;
  out += html_tile("Capacity", fmt::format("{:.2f}", reported.cell.capacity_ah), "Ah",
                   reported.mean != nullptr
                       ? fmt::format("±{:.2f} Ah between {} cells", reported.mean->capacity_spread_ah,
                                     reported.mean->capacity_ah.size())
                       : fmt::format("{}{}",
                                     reported.body.capacity.origin == FactOrigin::kAssumed ? "assumed: " : "",
                                     name_of(reference.capacity.from)));
  const RecordingError error = error_of(identified);
  out += html_tile("Error", fmt::format("{:.2f}", 1e3 * error.rms_v), "mV RMS",
                   fmt::format("over {} recording{}, largest {:.0f} mV", recordings(identified),
                               recordings(identified) == 1 ? "" : "s", 1e3 * error.largest_v));
  out += html_tile("Noise of the voltage", fmt::format("{:.2f}", 1e3 * std::sqrt(reference.noise_floor_v2)), "mV RMS",
                   "from neighbouring rows at rest");
  out += html_tile("RC branches", fmt::format("{}", reference.model.branches()), "",
                   reference.orders.empty() ? "as asked" : "chosen by held-out pulses");
  out += html_tile("Values settled by data", fmt::format("{}", excited), fmt::format("of {}", all),
                   "R and tau within ±20 % at 95 %");
  out += html_tile("Computed in", fmt::format("{:.2f}", reference.seconds), "s",
                   fmt::format("{}, {} iterations", place_text(identified, identified.reference_point()),
                               reference.iterations));
  return out;
}

/// Seconds of load near each breakpoint, of all recordings of a place.
std::vector<double> load_seconds(const IdentifyResult& result) {
  const SocGrid& grid = result.model.grid;
  std::vector<double> out(static_cast<std::size_t>(grid.size()), 0.0);
  for (const RecordingResult& file : result.files) {
    const double quiet = 0.01 * file.trace.current_a.cwiseAbs().maxCoeff();
    for (Index row = 0; row < file.trace.soc.size(); ++row) {
      if (std::abs(file.trace.current_a(row)) <= quiet) continue;
      const SocGrid::Place at = grid.find(file.trace.soc(row));
      out[static_cast<std::size_t>(at.node + (at.fraction > 0.5 ? 1 : 0))] += file.trace.weight_s(row);
    }
  }
  return out;
}

std::string soc_head(const SocGrid& grid) {
  std::string out;
  for (const double soc : grid.nodes()) out += fmt::format("<th scope=\"col\">{:.3g}</th>", soc);
  return out;
}

std::string coverage_rows(const CellIdentification& identified) {
  std::string out;
  for (std::size_t t = 0; t < identified.temperatures_c.size(); ++t) {
    for (std::size_t c = 0; c < identified.currents_a.size(); ++c) {
      const OperatingPoint& point = identified.at(t, c);
      std::string cells;
      if (!identified.was_tested(t, c)) {
        cells = fmt::format("<td class=\"filled\" colspan=\"{}\">not tested, filled from {}</td>",
                            point.result.model.grid.size(), html_text(place_text(identified, point)));
      } else {
        const auto seconds = load_seconds(point.result);
        const Index tables = 2 * point.result.model.branches() + 1;
        for (Index node = 0; node < point.result.model.grid.size(); ++node) {
          const Index excited = excited_tables(point.result, node);
          const double load = seconds[static_cast<std::size_t>(node)];
          cells += load < 0.5 ? "<td class=\"never\">–</td>"
                              : fmt::format("<td style=\"--heat:{:.0f}%\" title=\"{:.0f} s under load\">{}/{}</td>",
                                            50.0 * static_cast<double>(excited) / static_cast<double>(tables), load,
                                            excited, tables);
        }
      }
      out += fmt::format("<tr><th scope=\"row\">{}</th>{}</tr>\n",
                         place_text(identified.temperatures_c[t], identified.currents_a[c],
                                    identified.temperature_told),
                         cells);
    }
  }
  return out;
}

/// Classes of cells that are set otherwise than numbers: text that wraps, an assumption.
constexpr const char *kWords = "words", *kAssumedMark = "assumed";

struct TableCell {
  std::string text, kind{};
};

std::string row_of(const std::vector<TableCell>& cells) {
  std::string out = fmt::format("<tr><th scope=\"row\">{}</th>", html_text(cells.front().text));
  for (std::size_t k = 1; k < cells.size(); ++k) {
    out += fmt::format("<td{}>{}</td>", cells[k].kind.empty() ? "" : fmt::format(" class=\"{}\"", cells[k].kind),
                       html_text(cells[k].text));
  }
  return out + "</tr>\n";
}

struct Surface {
  std::string name, unit;
  double scale;
  bool is_em, is_tau;
  Index column;
};
std::vector<Surface> surfaces(Index branches) {
  std::vector<Surface> out{{"Em", "V", 1.0, true, false, 0}};
  for (Index k = 0; k <= branches; ++k) out.push_back({fmt::format("R{}", k), "mΩ", 1e3, false, false, k});
  for (Index k = 0; k < branches; ++k) out.push_back({fmt::format("tau{}", k + 1), "s", 1.0, false, true, k});
  return out;
}

double value_of(const CircuitModel& model, const Surface& s, Index node) {
  if (s.is_em) return model.ocv.value(model.em, model.grid.at(node));
  if (!s.is_tau && s.column == 0) return s.scale * model.r0_ohm(node, model.capacity_ah);
  return s.scale * (s.is_tau ? model.tau(node, s.column) : model.r(node, s.column));
}

/// Half of the 95 % interval in words: mV of Em, % of others.
std::string interval_of(const IdentifyResult& result, const Surface& s, Index node) {
  const CircuitModel& model = result.model;
  if (s.is_em) {
    const double sigma = model.ocv.value(result.uncertainty.sigma.head(model.em.size()), model.grid.at(node));
    return std::isfinite(sigma) ? fmt::format("±{:.1f} mV", 1960.0 * sigma) : kNotSettled;
  }
  const Index table = s.is_tau ? model.branches() + 1 + s.column : s.column;
  const double sigma = result.uncertainty.sigma(model.em.size() + table * model.grid.size() + node);
  constexpr double kMost_pct = 999.0;  // beyond it the data say nothing
  return 196.0 * sigma < kMost_pct ? fmt::format("±{:.0f} %", 196.0 * sigma) : kNotSettled;
}

std::string surface_table(const CellIdentification& identified, const Surface& s) {
  double low = 1e300, high = -1e300;
  for (const OperatingPoint& point : identified.points) {
    for (Index node = 0; node < point.result.model.grid.size(); ++node) {
      low = std::min(low, value_of(point.result.model, s, node));
      high = std::max(high, value_of(point.result.model, s, node));
    }
  }
  const SocGrid& grid = identified.points.front().result.model.grid;
  std::string out = fmt::format("<table class=\"heat\"><caption>{}, {}; SOC across</caption>\n<thead><tr>"
                                "<th scope=\"col\"></th>{}</tr></thead>\n<tbody>\n",
                                s.name, s.unit, soc_head(grid));
  for (const OperatingPoint& point : identified.points) {
    out += fmt::format("<tr><th scope=\"row\">{}</th>", html_text(place_text(identified, point)));
    for (Index node = 0; node < grid.size(); ++node) {
      const double value = value_of(point.result.model, s, node);
      out += fmt::format("<td style=\"--heat:{:.0f}%\">{}<small>{}</small></td>",
                         6.0 + 44.0 * (value - low) / std::max(1e-12, high - low), short_number(value),
                         interval_of(point.result, s, node));
    }
    out += "</tr>\n";
  }
  return out + "</tbody></table>\n";
}

std::string choice_rows(const CellIdentification& identified) {
  std::string out;
  for (const OperatingPoint& point : identified.points) {
    const IdentifyResult& r = point.result;
    std::string orders, smoothness;
    for (const OrderScore& order : r.orders)
      orders += fmt::format("{}{}: {:.2f} mV, {:.0f}", orders.empty() ? "" : "; ", order.branches,
                            1e3 * order.heldout_rms_v, order.information_criterion);
    for (const auto& [value, rms] : r.smoothness_scores)
      smoothness += fmt::format("{}{}: {:.2f} mV", smoothness.empty() ? "" : "; ", short_number(value), 1e3 * rms);
    out += row_of({{place_text(identified, point)},
                   {fmt::format("{}", r.model.branches())},
                   {orders.empty() ? "as asked" : orders, kWords},
                   {r.smoothness > 0.0 ? short_number(r.smoothness) : "-"},
                   {smoothness.empty() ? "-" : smoothness, kWords},
                   {fmt::format("{:.2f}", 1e3 * r.rms_v)},
                   {fmt::format("{:.2f}", r.seconds)}});
  }
  return out;
}

std::string file_rows(const CellIdentification& identified) {
  std::string out;
  for (const OperatingPoint& point : identified.points) {
    for (const RecordingResult& file : point.result.files) {
      std::string repairs;
      for (const std::string& repair : file.repairs) repairs += (repairs.empty() ? "" : "; ") + repair;
      const RecordingError error = error_of(file);
      out += row_of({{std::filesystem::path(file.path).filename().string()},
                     {place_text(identified, point)},
                     {fmt::format("{}", file.rows)},
                     {fmt::format("{:.2f}", file.duration_s / 3600.0)},
                     {fmt::format("{:.3f} to {:.3f}", shown(file.soc_low, 3), shown(file.soc_high, 3))},
                     {fmt::format("{:.3f} by {}", shown(file.anchor.soc, 3), file.anchor.from), kWords},
                     {fmt::format("{}, by {}", name_of(file.hold), file.hold_from), kWords},
                     {fmt::format("{:.2f}", 1e3 * error.rms_v)},
                     {fmt::format("{:.0f}", 1e3 * error.largest_v)},
                     {fmt::format("{:.2f}", 1e3 * error.all_rms_v)},
                     {repairs.empty() ? "none" : page_words(repairs), kWords}});
    }
  }
  return out;
}

/// Its origin marked where it is assumed.
std::string fact_row(const std::string& name, const std::string& value, const std::string& unit, FactOrigin origin,
                     const std::string& from) {
  return row_of({{name},
                 {value},
                 {page_words(unit)},
                 {std::string(name_of(origin)), origin == FactOrigin::kAssumed ? kAssumedMark : ""},
                 {page_words(from), kWords}});
}

std::string fact_rows(const ReportedCell& reported) {
  const CellBody& body = reported.body;
  std::string out = fact_row("form", body.form_text(), "", body.form_origin, body.form_source);
  for (const CellFact& fact : cell_facts(reported.cell, body, reported.identified.temperature_told)) {
    out += fact_row(std::string(fact.label), short_number(fact.value), std::string(fact.unit), fact.origin,
                    fact.source);
  }
  for (const LawFact& law : law_facts(reported.identified.reference_point().result)) {
    const LawUnit in = shown_unit(law.unit);
    out += fact_row(std::string(law.label), short_number(in.scale * law.value), in.unit, law.origin,
                    fmt::format("{}95 % interval: {}{}",
                                law.origin == FactOrigin::kAssumed ? "as of cells of its kind; " : "",
                                law_interval(law), law.at_bound ? ", at its bound" : ""));
  }
  return out;
}

std::string notes(const CellIdentification& identified) {
  std::string out;
  for (const std::string& note : identified.reference_point().result.notes)
    out += "<li>" + html_text(page_words(note)) + "</li>\n";
  return out;
}

std::string method_section(const std::vector<MethodScore>& scores) {
  if (scores.empty()) return "";
  std::string rows;
  for (const MethodScore& s : scores) {
    const StudyScore* study = study_score(s.name);
    const auto number = [&](double value) { return study == nullptr ? "-" : square_millivolts(value); };
    rows += html_row({s.name, fmt::format("{}", s.sections), square_millivolts(s.mean_v2),
                      square_millivolts(s.median_v2), fmt::format("{:.0f}", s.snr),
                      square_millivolts(s.whole_mean_v2), fmt::format("{:.2f}", s.seconds),
                      number(study == nullptr ? 0.0 : study->mean_v2),
                      number(study == nullptr ? 0.0 : study->median_v2)});
  }
  return fill_template(html_asset("cell_methods.html", cell_page_files), {{"rows", rows}});
}

std::string run_facts(const ReportedCell& reported, const std::string& version) {
  std::string out;
  for (const auto& [name, value] : reported.run) out += html_fact(name, value);
  return out + html_fact("version", version);
}

}  // namespace

std::string identification_report_body(const ReportedCell& reported, const std::string& version) {
  const CellIdentification& identified = reported.identified;
  std::string tables;
  for (const Surface& s : surfaces(identified.reference_point().result.model.branches()))
    tables += surface_table(identified, s);
  const RecordingError error = error_of(identified);
  const bool left_out = error.all_rms_v > error.rms_v + 5e-6;
  const std::string headline = fmt::format(
      "{}: {:.2f} Ah, {:.3f} to {:.3f} V; the model follows {} recording{} within {:.2f} mV RMS{}",
      reported.cell.name, reported.cell.capacity_ah, reported.cell.voltage_min_v, reported.cell.voltage_max_v,
      recordings(identified), recordings(identified) == 1 ? "" : "s", 1e3 * error.rms_v,
      left_out ? fmt::format(" ({:.2f} mV with the rows that were left out)", 1e3 * error.all_rms_v) : "");
  const std::string spread =
      reported.mean == nullptr
          ? ""
          : "<div class=\"card scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Spread\"><pre>" +
                html_text(spread_text(*reported.mean)) + "</pre></div>";
  return fill_template(html_asset("cell.html", cell_page_files),
                       {{"headline", html_text(headline)},
                        {"facts", html_text("voltlap identify, version " + version)},
                        {"tiles", tiles(reported)},
                        {"notes", notes(identified)},
                        {"fact_rows", fact_rows(reported)},
                        {"coverage_head", soc_head(identified.points.front().result.model.grid)},
                        {"coverage_rows", coverage_rows(identified)},
                        {"surfaces", tables},
                        {"spread", spread},
                        {"methods", method_section(reported.scores)},
                        {"choice_rows", choice_rows(identified)},
                        {"file_rows", file_rows(identified)},
                        {"run_facts", run_facts(reported, version)}});
}

}  // namespace voltlap::plant
