// SPDX-License-Identifier: Apache-2.0
#include "comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "car/battery/cell_tables.hpp"
#include "core/demand.hpp"
#include "core/parameter_file.hpp"
#include "learn/bench/plan_file.hpp"
#include "learn/identify/result/excitation.hpp"

namespace voltlap::known_truth {
namespace {

using namespace plant;

/// Mean load current while the cell was within `reach` of a SOC, nearer rows counting more. Rows in which a pulse
/// begins or ends are means of current and rest and do not count.
double load_current_at(const BenchRecord& record, std::size_t cell, double soc) {
  constexpr double kReach = 0.03, kLoad = 1.0;  // SOC; A
  double sum = 0.0, weight = 1e-12, last = 0.0;
  const auto& current = record.true_current_a;
  for (std::size_t row = 1; row + 1 < current.size(); ++row) {
    if (std::min({current[row - 1], current[row], current[row + 1]}) < kLoad) continue;
    if (row > 1 && current[row - 2] < kLoad) continue;
    if (row + 2 < current.size() && current[row + 2] < kLoad) continue;
    const double near = std::max(0.0, 1.0 - std::abs(record.cells[cell].true_soc[row] - soc) / kReach);
    sum += near * record.true_current_a[row];
    weight += near;
    last = record.true_current_a[row];
  }
  return weight > 1e-6 ? sum / weight : last;
}

std::array<double, kTables> truth_at(const CellTables& tables, const BenchRecord& record,
                                     std::size_t cell, double soc) {
  const CellRecord& truth = record.cells[cell];
  const double end = *std::min_element(truth.true_soc.begin(), truth.true_soc.end());
  const double own = end + soc * (truth.initial_soc - end);
  const CircuitParameters p =
      tables.circuit(own, record.test.temperature_c, load_current_at(record, cell, own));
  const double scale = truth.variation.resistance_scale;
  return {tables.ocv(own).voltage_v, scale * p.r0_ohm, scale * p.r_ohm[0], scale * p.r_ohm[1], p.tau_s[0], p.tau_s[1]};
}

InstrumentLimits limits_of(const InstrumentSection& section, double current_a) {
  const bool low = current_a < section.sensors.current_low_range_a;
  InstrumentLimits out;
  if (!section.systematic) return out;
  constexpr double kFullScale = 5.0;  // V; the bench splits its error in halves: offset and gain
  out.voltage_v = 0.5 * section.cell_error_v;
  out.voltage_gain = 0.5 * section.cell_error_v / kFullScale;
  out.current_a = low ? section.current_low_offset_a : section.current_high_offset_a;
  out.current_gain = low ? section.current_low_gain : section.current_high_gain;
  out.rest_current_a = section.current_low_offset_a;
  return out;
}

}  // namespace

CellLog log_of(const BenchRecord& record, std::size_t cell) {
  VOLTLAP_DEMAND(cell < record.cells.size() && record.cells[cell].voltage_v.size() == record.time_s.size());
  CellLog log;
  log.path = fmt::format("{}, cell {}", record.test.name, cell + 1);
  log.time_s = record.time_s;
  log.current_a = record.current_a;
  log.voltage_v = record.cells[cell].voltage_v;
  log.temperature_c = record.cells[cell].temperature_c;
  log.gap.assign(log.rows(), false);
  return log;
}

Outcome run_case(const Case& one, std::uint64_t seed, std::size_t test, std::size_t cell) {
  const DataFolder data(VOLTLAP_DATA_FOLDER);
  const Campaign campaign(load_plan(data, one.plan, one.settings), load_cell(data, one.cell, "known truth"),
                          seed);
  const BenchRecord record = campaign.run(test);
  IdentifyOptions options;
  options.branches = 2;
  options.reference_temperature_c = record.test.temperature_c;
  options.hold = CurrentHold::kLinear;  // rows are means of a second
  if (one.limits_stated) options.instruments = limits_of(campaign.plan().instruments, record.test.current_a);
  const IdentifyResult found = identify({log_of(record, cell)}, options);
  const CellTables tables(campaign.cell());
  Outcome out{{}, found.rms_v * found.rms_v, found.seconds, found.smoothness_from};
  constexpr double kTwoSided = 1.96;
  const auto& ocv = found.model.ocv;
  const auto& grid = found.model.grid;
  for (Eigen::Index node = 0; node < grid.size(); ++node) {
    const double soc = grid.at(node);
    const auto truth = truth_at(tables, record, cell, soc);
    // The OCV has nodes of its own: the nearest one stands for the breakpoint.
    Eigen::Index em = 0;
    for (Eigen::Index k = 0; k < ocv.size(); ++k) em = std::abs(ocv.at(k) - soc) < std::abs(ocv.at(em) - soc) ? k : em;
    const double em_truth = truth_at(tables, record, cell, ocv.at(em))[0];
    const double em_half = kTwoSided * found.uncertainty.sigma(em);
    out.nodes.push_back(
        {0, soc, found.model.em(em) - em_truth, em_half, is_ocv_excited(found, em) && em_half < kPromised[0]});
    for (Eigen::Index table = 0; table < kTables - 1; ++table) {
      const double value = table < 3 ? found.model.r(node, table) : found.model.tau(node, table - 3);
      const Eigen::Index at = found.model.em.size() + table * grid.size() + node;
      const auto of_table = static_cast<std::size_t>(table) + 1;
      const double half = kTwoSided * found.uncertainty.sigma(at);
      out.nodes.push_back({static_cast<int>(table) + 1, soc, std::log(value / truth[of_table]), half,
                           is_excited(found, table, node) && half < kPromised[of_table]});
    }
  }
  return out;
}

void Tally::add(const Outcome& outcome) {
  ++outcomes;
  by_evidence += outcome.smoothness_from == "evidence" ? 1 : 0;
  mean_square_v2 += outcome.mean_square_v2;
  seconds += outcome.seconds;
  for (const Node& node : outcome.nodes) {
    Row& row = rows[static_cast<std::size_t>(node.table)];
    const bool covered = std::abs(node.error) <= node.half_width;
    ++row.nodes;
    row.covered_all += covered ? 1 : 0;
    if (!node.excited) continue;
    ++row.excited;
    row.covered += covered ? 1 : 0;
    row.within += std::abs(node.error) <= kPromised[static_cast<std::size_t>(node.table)] ? 1 : 0;
    row.widest = std::max(row.widest, node.half_width);
    row.worst = std::max(row.worst, std::abs(node.error));
    row.square += node.error * node.error;
  }
}

Tally::Row Tally::all() const {
  Row sum;
  for (const Row& row : rows) {
    sum.nodes += row.nodes;
    sum.excited += row.excited;
    sum.within += row.within;
    sum.covered += row.covered;
    sum.covered_all += row.covered_all;
  }
  return sum;
}

std::string text_of(const Tally& tally) {
  const auto percent = [](int part, int whole) { return whole > 0 ? 100.0 * part / whole : 0.0; };
  std::string out = fmt::format("{:<6}{:>8}{:>10}{:>16}{:>12}{:>14}{:>14}{:>12}\n", "", "nodes", "excited",
                                "within mark", "covered", "covered, all", "rms error", "worst");
  const auto line = [&](const char* name, const Tally::Row& row, const std::string& errors) {
    out += fmt::format("{:<6}{:>8}{:>8.1f} %{:>14.2f} %{:>10.1f} %{:>12.1f} %{}\n", name, row.nodes,
                       percent(row.excited, row.nodes), percent(row.within, row.excited),
                       percent(row.covered, row.excited), percent(row.covered_all, row.nodes), errors);
  };
  for (std::size_t t = 0; t < kTables; ++t) {
    const Tally::Row& row = tally.rows[t];
    const double unit = t == 0 ? 1e3 : 100.0;
    const char* name = t == 0 ? "mV" : "%";
    line(kNames[t], row,
         fmt::format("{:>11.3f} {:<2}{:>9.3f} {:<2}", unit * std::sqrt(row.square / std::max(1, row.excited)), name,
                     unit * row.worst, name));
  }
  line("all", tally.all(), "");
  out += fmt::format("{} identifications, {} by evidence; rms {:.3f} mV; {:.3f} s each\n", tally.outcomes,
                     tally.by_evidence, 1e3 * std::sqrt(tally.mean_square_v2 / tally.outcomes),
                     tally.seconds / tally.outcomes);
  return out;
}

}  // namespace voltlap::known_truth
