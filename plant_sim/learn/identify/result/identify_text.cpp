// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/identify_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/number_text.hpp"
#include "learn/identify/result/excitation.hpp"
#include "learn/identify/result/law_facts.hpp"

namespace voltlap::plant {
namespace {

std::string smoothness_text(const IdentifyResult& result) {
  return result.smoothness > 0.0 ? fmt::format("{} by {}", short_number(result.smoothness), result.smoothness_from)
                                 : "by " + result.smoothness_from;
}

std::string file_text(const RecordingResult& file) {
  std::string out = fmt::format(
      "  {}\n    current {} (found from {}); SOC {:.3f} to {:.3f}, {:.3f} by {}; RMS {:.2f} mV over all "
      "rows, {:.2f} mV from there on{}\n",
      file.path, name_of(file.hold), file.hold_from, shown(file.soc_low, 3), shown(file.soc_high, 3),
      shown(file.anchor.soc, 3), file.anchor.from, 1e3 * file.rms_v, 1e3 * file.rms_pulses_v,
      file.read_back ? fmt::format(", by the cell file read back; over the rows that were fitted {:.2f} mV ({:.2f} mV "
                                   "in the fit)",
                                   1e3 * file.read_back->used_rms_v, 1e3 * file.read_back->fit_used_rms_v)
                     : "");
  for (const std::string& repair : file.repairs) out += fmt::format("    {}\n", repair);
  return out;
}

std::string order_text(const OrderScore& order) {
  return fmt::format("  {} branch{}: held-out pulses {:.2f} mV, information criterion {:.0f}\n", order.branches,
                     order.branches == 1 ? "  " : "es", 1e3 * order.heldout_rms_v, order.information_criterion);
}

std::string value_text(const IdentifyResult& r, Eigen::Index table, Eigen::Index node) {
  const Eigen::Index branches = r.model.branches();
  const double value = table == 0           ? 1e3 * r.model.r0_ohm(node, r.model.capacity_ah)
                       : table <= branches ? 1e3 * r.model.r(node, table)
                                           : r.model.tau(node, table - branches - 1);
  const double sigma = r.uncertainty.sigma(r.model.em.size() + table * r.model.grid.size() + node);
  const std::string interval =
      !std::isfinite(sigma) ? "    -  " : 196.0 * sigma < 999.5 ? fmt::format("{:4.0f} %", 196.0 * sigma) : ">999 %";
  return fmt::format("  {:>9} {:6}{}", short_number(value), interval, is_excited(r, table, node) ? " " : "*");
}

std::string table_text(const IdentifyResult& r) {
  const Eigen::Index branches = r.model.branches();
  VOLTLAP_DEMAND(r.uncertainty.sigma.size() >= r.model.em.size() + (2 * branches + 1) * r.model.grid.size());
  std::string out = "    SOC    Em [V]     R0 [mOhm]  ";
  for (Eigen::Index k = 1; k <= branches; ++k) out += fmt::format("      R{} [mOhm]  ", k);
  for (Eigen::Index k = 1; k <= branches; ++k) out += fmt::format("       tau{} [s]  ", k);
  out += fmt::format("   (+- 95 %; * not settled by the recordings{})\n",
                     r.model.laws.has_charge_transfer() ? "; R0 with its charge transfer at 1C" : "");
  for (Eigen::Index node = r.model.grid.size(); node-- > 0;) {
    const double soc = r.model.grid.at(node);
    out += fmt::format("  {:5.3f}  {:8.4f}", soc, r.model.ocv.value(r.model.em, soc));
    for (Eigen::Index table = 0; table <= 2 * branches; ++table) out += value_text(r, table, node);
    out += "\n";
  }
  return out;
}

std::string point_text(const OperatingPoint& point, int cells_in_series, bool temperature_told) {
  const IdentifyResult& r = point.result;
  std::string out = fmt::format(
      "\nat {:.1f} degC{}{}: {} RC branches, RMS {:.2f} mV, smoothness {}, {} iterations, {:.2f} s\n",
      shown(point.temperature_c, 1), temperature_told ? "" : " (assumed)",
      point.current_a > 0.0 ? fmt::format(", {:.0f} A", point.current_a) : "",
      r.model.branches(), 1e3 * r.rms_v, smoothness_text(r), r.iterations, r.seconds);
  for (const RecordingResult& file : r.files) out += file_text(file);
  for (const OrderScore& order : r.orders) out += order_text(order);
  if (r.rms_other_blocks_v) {
    out += fmt::format("  blocks kept back: RMS {:.2f} mV a cell, {:.3f} V over {} in series\n",
                       1e3 * *r.rms_other_blocks_v, *r.rms_other_blocks_v * cells_in_series, cells_in_series);
  }
  for (const std::string& note : r.notes) out += fmt::format("  {}\n", note);
  return out + laws_text(r) + table_text(r);
}

}  // namespace

std::string identification_text(const CellParameters& cell, const CellBody& body,
                                const CellIdentification& identified, int cells_in_series) {
  std::string out = fmt::format("{}: {:.3f} Ah, {:.3f} to {:.3f} V\n", cell.name, cell.capacity_ah, cell.voltage_min_v,
                                cell.voltage_max_v);
  out += cell_facts_text(cell, body, identified.temperature_told);
  for (const OperatingPoint& point : identified.points)
    out += point_text(point, cells_in_series, identified.temperature_told);
  return out;
}

}  // namespace voltlap::plant
