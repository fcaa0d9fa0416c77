// SPDX-License-Identifier: Apache-2.0
#include "replay/disagreements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "replay/replay_text.hpp"

namespace voltlap::plant {
namespace {

// What a kind weighs; within a kind its size adds up to less than the step to the next.
constexpr double kTrip = 400.0, kCell = 300.0, kCurrent = 200.0, kSoc = 100.0, kSaidLimit = 50.0, kMost = 49.0;

double sized(double kind, double size) { return kind + std::min(kMost, std::isfinite(size) ? std::abs(size) : 0.0); }

/// Whether the log carries a current in the seconds behind a moment.
bool drives_on(const ReplayResult& r, double time_s) {
  constexpr double kSoon_s = 5.0, kDriven_a = 5.0;
  return std::any_of(r.rows.begin(), r.rows.end(), [&](const ReplayRow& row) {
    return row.time_s > time_s && row.time_s < time_s + kSoon_s && std::abs(row.current_a) > kDriven_a;
  });
}

void add_trips(const ReplayResult& r, std::vector<Disagreement>& out) {
  std::map<std::string, std::vector<const ReplayFault*>> trips;
  for (const ReplayFault& fault : r.faults) {
    if (fault.opens) trips[fault.id].push_back(&fault);
  }
  for (const auto& [id, times] : trips) {
    const ReplayFault& first = *times.front();
    const std::string more = times.size() > 1 ? fmt::format(", {} times in all", times.size()) : "";
    out.push_back({sized(kTrip, static_cast<double>(times.size())), first.time_s - 2.0, first.time_s,
                   fmt::format("the firmware opens the contactors at {:.1f} s: {}{}{}; {}", first.time_s, id,
                               first.about.empty() ? "" : ", " + first.about, more,
                               drives_on(r, first.time_s) ? "current flowed on" : "no current flowed then"),
                   "the readings that made it trip"});
  }
}

/// What the firmware had allowed at most before a moment, since its last full permission.
const OverLimit* cut_before(const ReplayResult& r, double time_s, bool charging) {
  const OverLimit* out = nullptr;
  for (const OverLimit& over : r.over_limits) {
    if (over.charging == charging && over.begin_s <= time_s) out = &over;
  }
  return out;
}

void add_cells(const ReplayResult& r, bool low, std::vector<Disagreement>& out) {
  const LimitViolation* worst = nullptr;
  std::set<int> cells;
  std::size_t stretches = 0;
  for (const LimitViolation& v : r.violations) {
    if ((v.voltage_v < v.limit_v) != low) continue;
    cells.insert(v.cell);
    ++stretches;
    const auto depth = [](const LimitViolation& one) { return std::abs(one.voltage_v - one.limit_v); };
    if (worst == nullptr || depth(v) > depth(*worst)) worst = &v;
  }
  if (worst == nullptr) return;
  std::string what = fmt::format("cell {} {} {:.3f} V at {:.1f} s, its limit is {:.3f} V ({} stretches, {} cells)",
                                 worst->cell, low ? "falls to" : "rises to", worst->voltage_v, worst->worst_s,
                                 worst->limit_v, stretches, cells.size());
  if (const OverLimit* over = cut_before(r, worst->time_s, !low)) {
    what += fmt::format("; the firmware had cut the {} limit from {:.1f} s on, to {:.0f} A at {:.1f} s, when the log "
                        "has {:.0f} A",
                        low ? "discharge" : "charge", over->begin_s, over->limit_a, over->worst_s, over->current_a);
  }
  out.push_back({sized(kCell, 10.0 * (worst->voltage_v - worst->limit_v)), worst->time_s, worst->until_s,
                 std::move(what), "the cell's own readings"});
}

void add_currents(const ReplayResult& r, bool charging, std::vector<Disagreement>& out) {
  const OverLimit* worst = nullptr;
  double seconds = 0.0;
  std::size_t stretches = 0;
  for (const OverLimit& over : r.over_limits) {
    if (over.charging != charging) continue;
    seconds += over.end_s - over.begin_s;
    ++stretches;
    if (worst == nullptr || over.excess_a() > worst->excess_a()) worst = &over;
  }
  if (worst == nullptr) return;
  out.push_back({sized(kCurrent, 0.1 * worst->excess_a()), worst->begin_s, worst->end_s,
                 fmt::format("{:.0f} A of {} at {:.1f} s where the firmware allows {:.0f} A ({}); {:.1f} s in {} "
                             "stretches",
                             worst->current_a, charging ? "charge" : "discharge", worst->worst_s, worst->limit_a,
                             reason_text(worst->reason, worst->cell), seconds, stretches),
                 "whether that limit is right: the cell voltages there"});
}

void add_soc(const ReplayResult& r, std::vector<Disagreement>& out) {
  const ReplayRow* worst = nullptr;
  const auto apart = [](const ReplayRow& row) { return std::abs(row.soc - row.logged_soc); };
  for (const ReplayRow& row : r.rows) {
    if (std::isfinite(apart(row)) && (worst == nullptr || apart(row) > apart(*worst))) worst = &row;
  }
  if (worst == nullptr || apart(*worst) < 0.01) return;
  out.push_back({sized(kSoc, 100.0 * apart(*worst)), r.begin_s, worst->time_s,
                 fmt::format("SOC {:.1f} % by the firmware, {:.1f} % by the log at {:.1f} s; at the end {:.1f} and "
                             "{:.1f} %",
                             100.0 * worst->soc, 100.0 * worst->logged_soc, worst->time_s, 100.0 * r.soc_end(),
                             100.0 * r.logged_soc_end()),
                 r.soc_from == SocSource::kLogged
                     ? "the charge counted since: both start alike"
                     : "whether the cells rested where the firmware started (below), and the charge counted since"});
}

void add_soc_jump(const ReplayResult& r, std::vector<Disagreement>& out) {
  if (!r.soc_jump) return;
  const SocJump& jump = *r.soc_jump;
  std::string decided = fmt::format("the charge of these seconds, {:.4f} Ah", jump.charge_ah);
  if (std::isfinite(jump.explained)) decided += fmt::format(", is {:.2f} points of SOC", 100.0 * jump.explained);
  out.push_back({sized(kSoc, 100.0 * (jump.to - jump.from)), jump.begin_s, jump.end_s,
                 fmt::format("the logged SOC jumps from {:.1f} to {:.1f} % within {:.1f} s: no battery does",
                             100.0 * jump.from, 100.0 * jump.to, jump.end_s - jump.begin_s),
                 std::move(decided)});
}

void add_said_limit(const ReplayResult& r, bool charging, std::vector<Disagreement>& out) {
  const auto own = charging ? &ReplayRow::charge_limit_a : &ReplayRow::discharge_limit_a;
  const auto said = charging ? &ReplayRow::logged_charge_limit_a : &ReplayRow::logged_discharge_limit_a;
  const ReplayRow* worst = nullptr;
  double sum = 0.0, count = 0.0;
  for (const ReplayRow& row : r.rows) {
    const double apart = row.*own - row.*said;
    if (!std::isfinite(apart) || row.state != can::BmsState::kTsActive) continue;
    sum += apart;
    count += 1.0;
    if (worst == nullptr || std::abs(apart) > std::abs(worst->*own - worst->*said)) worst = &row;
  }
  if (worst == nullptr || std::abs(worst->*own - worst->*said) < 1.0) return;
  out.push_back({sized(kSaidLimit, 0.1 * (worst->*own - worst->*said)), worst->time_s, worst->time_s + 0.1,
                 fmt::format("{} limit {:.0f} A by the firmware ({}), {:.0f} A by the log's own unit at {:.1f} s; "
                             "on the mean {:+.0f} A",
                             charging ? "charge" : "discharge", worst->*own,
                             charging ? reason_text(worst->charge_reason, 0)
                                      : reason_text(worst->discharge_reason, worst->limiting_cell),
                             worst->*said, worst->time_s, sum / count),
                 "the configuration of both units"});
}

}  // namespace

std::vector<Disagreement> find_disagreements(const ReplayResult& r) {
  std::vector<Disagreement> out;
  add_trips(r, out);
  add_cells(r, true, out);
  add_cells(r, false, out);
  add_currents(r, false, out);
  add_currents(r, true, out);
  add_soc(r, out);
  add_soc_jump(r, out);
  add_said_limit(r, false, out);
  add_said_limit(r, true, out);
  std::stable_sort(out.begin(), out.end(),
                   [](const Disagreement& a, const Disagreement& b) { return a.weight > b.weight; });
  return out;
}

}  // namespace voltlap::plant
