// SPDX-License-Identifier: Apache-2.0
#include "replay/replay_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

namespace voltlap::plant {
namespace {

constexpr std::size_t kShown = 8;  // lines of one list

std::string percent(double share) {
  return std::isfinite(share) ? fmt::format("{:.1f} %", 100.0 * share) : "not known";
}

std::string frames_text(const FrameAccount& f) {
  return fmt::format("{} frames: {} used, {} ignored, {} corrupt, {} stale", f.in_file, f.used, f.ignored, f.corrupt,
                     f.stale);
}

std::string node_text(const char* name, const FrameComparison::Node& node) {
  std::string out = fmt::format("{} {} of {} the same", name, node.same, node.recorded);
  if (node.different > 0) out += fmt::format(", {} different", node.different);
  if (node.missing > 0) out += fmt::format(", {} not answered", node.missing);
  if (node.extra > 0) out += fmt::format(", {} answered that are not recorded", node.extra);
  return out;
}

std::string comparison_text(const FrameComparison& c, double begin_s) {
  constexpr double kAtOnce_s = 0.015;
  if (c.identical()) {
    return fmt::format("  answered as recorded, byte for byte: {} frames of the BMS, {} of the master controller\n",
                       c.bms.same, c.master.same);
  }
  std::string out = fmt::format("  not answered as recorded: {}; {}\n", node_text("BMS", c.bms),
                                node_text("master controller", c.master));
  if (!c.first) return out;
  out += fmt::format("  first difference at {:.3f} s, {} of the {}\n", c.first->time_s, c.first->message,
                     c.first->node);
  out += fmt::format("    recorded {}\n    answered {}\n", c.first->recorded.empty() ? "nothing" : c.first->recorded,
                     c.first->answered.empty() ? "nothing" : c.first->answered);
  if (c.first->time_s - begin_s < kAtOnce_s) {
    return out + "  at once: does the log begin at power-on? What the nodes knew before is not in it\n";
  }
  return out + "  were the vehicle (--pack) and --set those of the run that was recorded?\n";
}

std::string soc_text(const ReplayResult& r) {
  if (!r.has_cell_model()) {
    return fmt::format("  SOC               no cell model (--pack); logged {} to {}\n", percent(r.logged_soc_start()),
                       percent(r.logged_soc_end()));
  }
  const std::string from = r.soc_from == SocSource::kRest
                               ? ""
                               : fmt::format(" (from {})", kSocSourceNames[static_cast<std::size_t>(r.soc_from)]);
  return fmt::format("  SOC               {}{} to {}; logged {} to {}\n", percent(r.soc_start()), from,
                     percent(r.soc_end()), percent(r.logged_soc_start()), percent(r.logged_soc_end()));
}

struct Lowest {
  double value = kUnknown, time_s = 0.0;
  const ReplayRow* row = nullptr;
};

/// While a limit rises from zero, at the start and after a trip, it keeps the reason that held it there.
bool rises_from_zero(can::LimitReason reason) {
  return reason == can::LimitReason::kContactorsOpen || reason == can::LimitReason::kFault ||
         reason == can::LimitReason::kMeasurementLost;
}

Lowest lowest_limit(const ReplayResult& r, double ReplayRow::*field, can::LimitReason ReplayRow::*reason) {
  Lowest out;
  for (const ReplayRow& row : r.rows) {
    if (row.state != can::BmsState::kTsActive || !std::isfinite(row.*field) || rises_from_zero(row.*reason)) continue;
    if (out.row != nullptr && row.*field >= out.value) continue;
    out = {row.*field, row.time_s, &row};
  }
  return out;
}

std::string limit_text(const ReplayResult& r, bool charge) {
  const char* name = charge ? "charge limit   " : "discharge limit";
  if (!r.has_cell_model()) return fmt::format("  {}   no cell model (--pack)\n", name);
  const Lowest low = charge ? lowest_limit(r, &ReplayRow::charge_limit_a, &ReplayRow::charge_reason)
                            : lowest_limit(r, &ReplayRow::discharge_limit_a, &ReplayRow::discharge_reason);
  if (low.row == nullptr) return fmt::format("  {}   0 A throughout: the contactors never closed\n", name);
  const std::string why = charge ? reason_text(low.row->charge_reason, 0)
                                 : reason_text(low.row->discharge_reason, low.row->limiting_cell);
  return fmt::format("  {}   lowest {:.1f} A at {:.1f} s: {}\n", name, low.value, low.time_s, why);
}

std::string faults_text(const ReplayResult& r) {
  std::map<std::string, std::size_t> count;
  for (const ReplayFault& fault : r.faults) ++count[fault.node + fault.id];
  if (r.faults.empty()) return "  faults            none\n";
  std::string out;
  std::map<std::string, bool> said;
  for (const ReplayFault& fault : r.faults) {
    if (said[fault.node + fault.id] || said.size() > kShown) continue;
    said[fault.node + fault.id] = true;
    const std::size_t times = count[fault.node + fault.id];
    out += fmt::format("  {}{:10.2f} s  {} ({}){}{}{}\n", out.empty() ? "faults " : "       ", fault.time_s, fault.id,
                       fault.node, fault.about.empty() ? "" : ", " + fault.about,
                       fault.opens ? ": opens the contactors" : "",
                       times > 1 ? fmt::format("; {} times in all", times) : "");
  }
  return out;
}

std::string violations_text(const ReplayResult& r) {
  if (!r.has_cell_model()) return "";
  if (r.violations.empty()) {
    if (r.cells_recorded == 0) return "  cells             the log has no reading of a cell\n";
    return r.cells_recorded >= r.cells ? "  cells             within their voltage limits throughout\n"
                                       : fmt::format("  cells             the {} of {} that the log has stay within "
                                                     "their voltage limits\n",
                                                     r.cells_recorded, r.cells);
  }
  const auto worst = std::max_element(r.violations.begin(), r.violations.end(), [](const auto& a, const auto& b) {
    return std::abs(a.voltage_v - a.limit_v) < std::abs(b.voltage_v - b.limit_v);
  });
  return fmt::format("  cells             {} stretches outside of the limits, the farthest: cell {} at {:.3f} V "
                     "({:.3f} V) at {:.1f} s\n",
                     r.violations.size(), worst->cell, worst->voltage_v, worst->limit_v, worst->worst_s);
}

std::string deviation(double value, double sd, int digits) {
  return fmt::format("{:.{}f} +- {:.{}f}", value, digits, sd, digits);
}

/// The cells that hold least and that resist most, by what the filter has learned.
std::string estimates_text(const ReplayResult& r) {
  if (r.estimates.empty()) return "";
  const auto& all = r.estimates;
  const auto most = std::max_element(all.begin(), all.end(),
                                     [](const auto& a, const auto& b) { return a.resistance < b.resistance; });
  const auto least = std::min_element(all.begin(), all.end(),
                                      [](const auto& a, const auto& b) { return a.capacity_ah < b.capacity_ah; });
  return fmt::format("  resistance        highest: cell {}, {} of the pack file's; capacity, lowest: cell {}, {} Ah "
                     "(by the filter; of each cell: --json)\n",
                     most->cell, deviation(most->resistance, most->resistance_sd, 2), least->cell,
                     deviation(least->capacity_ah, least->capacity_sd_ah, 2));
}

std::string disagreements_text(const ReplayResult& r) {
  if (r.disagreements.empty()) return "";
  std::string out = "\nDisagreements, the weightiest first\n";
  for (std::size_t k = 0; k < r.disagreements.size() && k < kShown; ++k) {
    const Disagreement& d = r.disagreements[k];
    out += fmt::format("  {}. {}\n     decided by {:.1f} to {:.1f} s: {}\n", k + 1, d.what, d.begin_s, d.end_s,
                       d.decided_by);
  }
  if (r.disagreements.size() > kShown) out += fmt::format("  and {} more (--json)\n", r.disagreements.size() - kShown);
  return out;
}

template <class Items, class Text>
std::string list_text(const char* head, const Items& items, const Text& text) {
  if (items.empty()) return "";
  std::string out = fmt::format("\n{}\n", head);
  for (std::size_t k = 0; k < items.size() && k < kShown; ++k) out += fmt::format("  {}\n", text(items[k]));
  if (items.size() > kShown) out += fmt::format("  and {} more (--json)\n", items.size() - kShown);
  return out;
}

std::string speed_text(const ReplayResult& r) {
  if (!(r.computed_s > 0.0)) return "";
  return fmt::format("  {:.1f} s of firmware computed in {:.2f} s: {:.0f} times real time, reading apart\n",
                     r.firmware_s, r.computed_s, r.firmware_s / r.computed_s);
}

}  // namespace

std::string reason_text(can::LimitReason reason, int cell) {
  static constexpr const char* kWords[] = {"no limit",         "configured maximum", "cell voltage",
                                           "pack voltage",     "temperature",        "low SOC",
                                           "fault",            "measurement lost",   "contactors open",
                                           "charging",         "energy to go"};
  static_assert(std::size(kWords) == std::size(can::kLimitReasonNames));
  const std::string word = kWords[static_cast<std::size_t>(reason)];
  return cell > 0 ? fmt::format("{} of cell {}", word, cell) : word;
}

std::string replay_text(const ReplayResult& r) {
  std::string out = fmt::format("{}: {:.1f} s{}, {} cells, {}\n", r.log, r.duration_s,
                                r.begin_s != 0.0 && r.begin_s < 1e8 ? fmt::format(" from {:.1f} s", r.begin_s) : "",
                                r.cells, r.has_cell_model() ? "pack " + r.pack : "no cell model");
  out += "  " + frames_text(r.frames) + "\n";
  if (r.comparison) out += comparison_text(*r.comparison, r.begin_s);
  if (!r.never_ready.empty()) out += fmt::format("  the firmware never closed its contactors: {}\n", r.never_ready);
  out += soc_text(r) + limit_text(r, false) + limit_text(r, true) + violations_text(r) + estimates_text(r) +
         faults_text(r);
  if (r.open_s > 0.0 && r.never_ready.empty()) {
    out += fmt::format("  after a trip the log drove on for {:.1f} s and {:.3f} Ah that the firmware does not count\n",
                       r.open_s, r.open_ah);
  }
  out += speed_text(r) + disagreements_text(r);
  const auto itself = [](const std::string& text) { return text; };
  out += list_text("Assumed, since the log does not say it", r.assumptions, itself);
  out += list_text("Defects of the log", r.defects, [](const LogDefect& defect) { return defect.text; });
  return out + list_text("Notes", r.notes, itself);
}

}  // namespace voltlap::plant
