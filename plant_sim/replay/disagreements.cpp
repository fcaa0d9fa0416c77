// SPDX-License-Identifier: Apache-2.0
#include "replay/disagreements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/signal.hpp"
#include "replay/replay_text.hpp"

namespace voltlap::plant {
namespace {

// What a kind weighs; within a kind its size adds up to less than the step to the next.
constexpr double kTrip = 400.0, kCell = 300.0, kCurrent = 200.0, kTripAtRest = 150.0, kSoc = 100.0, kSaidLimit = 50.0,
                 kOfReplay = 0.0, kMost = 49.0;

double sized(double kind, double size) { return kind + std::min(kMost, std::isfinite(size) ? std::abs(size) : 0.0); }

/// Whether the log carries a current in the seconds behind a moment.
bool drives_on(const ReplayResult& r, double time_s) {
  constexpr double kSoon_s = 5.0, kDriven_a = 5.0;
  return std::any_of(r.rows.begin(), r.rows.end(), [&](const ReplayRow& row) {
    return row.time_s > time_s && row.time_s < time_s + kSoon_s && std::abs(row.current_a) > kDriven_a;
  });
}

/// What a trip says: of a drive, of a car that stands, or of the recording and its replay alone.
struct TripClass {
  double weight = kTrip;
  std::string said{};
};

TripClass class_of(const ReplayResult& r, const ReplayFault& trip) {
  constexpr double kLater_s = 0.6, kSettles_s = 5.0;  // a time-out and its debounce; a step of current without its sag
  for (const RecordingHole& hole : r.holes) {
    if (trip.time_s < hole.begin_s || trip.time_s > hole.end_s + kLater_s) continue;
    return {kOfReplay, fmt::format("the recording has a hole there, {:.1f} s without any reading: it says nothing of "
                                   "the car",
                                   hole.end_s - hole.begin_s)};
  }
  for (const double closed_s : r.closed_again_s) {
    if (trip.time_s < closed_s || trip.time_s > closed_s + kSettles_s) continue;
    return {kOfReplay, fmt::format("{:.1f} s after the replay closed them again in the running log, which no car does",
                                   trip.time_s - closed_s)};
  }
  if (drives_on(r, trip.time_s)) return {kTrip, "current flowed on"};
  return {kTripAtRest, "no current flowed then"};
}

void add_trips(const ReplayResult& r, std::vector<Disagreement>& out) {
  struct Trips {
    const ReplayFault* first = nullptr;
    std::string said{};
    std::size_t count = 0;
  };
  std::map<std::pair<double, std::string>, Trips> trips;  // by weight and fault
  for (const ReplayFault& fault : r.faults) {
    if (!fault.opens) continue;
    TripClass of = class_of(r, fault);
    Trips& alike = trips[{of.weight, fault.id}];
    if (alike.count++ == 0) alike = {&fault, std::move(of.said), 1};
  }
  for (const auto& [key, alike] : trips) {
    const auto& [weight, id] = key;
    const std::string more = alike.count > 1 ? fmt::format(", {} times in all", alike.count) : "";
    const ReplayFault& first = *alike.first;
    out.push_back({sized(weight, static_cast<double>(alike.count)), first.time_s - 2.0, first.time_s,
                   fmt::format("the firmware opens the contactors at {:.1f} s: {}{}{}; {}", first.time_s, id,
                               first.about.empty() ? "" : ", " + first.about, more, alike.said),
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

/// A fault of the car's own unit that the firmware does not have at that time.
void add_logged_faults(const ReplayResult& r, std::vector<Disagreement>& out) {
  constexpr double kSame_s = 5.0;
  std::map<std::string, std::pair<const LoggedFault*, std::size_t>> alone;
  for (const LoggedFault& logged : r.logged_faults) {
    const bool also = std::any_of(r.faults.begin(), r.faults.end(), [&](const ReplayFault& own) {
      return std::abs(own.time_s - logged.time_s) < kSame_s;
    });
    if (also) continue;
    auto& [first, count] = alone[logged.role];
    if (count++ == 0) first = &logged;
  }
  for (const auto& [role, found] : alone) {
    const auto& [first, count] = found;
    out.push_back({sized(kSoc, static_cast<double>(count)), first->time_s - 2.0, first->time_s,
                   fmt::format("the log's own unit says {} = {:.0f} ({}) at {:.1f} s{}, the firmware has no fault "
                               "within {:.0f} s",
                               role, first->value, first->source, first->time_s,
                               count > 1 ? fmt::format(", {} times in all", count) : "", kSame_s),
                   "what that fault of the unit means, in its manual"});
  }
}

/// Cells that carry little current stand at their open-circuit voltage. Where in the end they stand far from the pack
/// file's at the charge that is counted, file and pack do not belong together.
void add_wrong_pack(const ReplayResult& r, std::vector<Disagreement>& out) {
  constexpr double kFar_v = 0.06, kFar = 0.08;  // chosen: relaxation and the end of a curve are less than both
  constexpr std::size_t kFewest = 100;
  const std::size_t count = r.quiet_cells.size();
  if (count < kFewest) return;
  std::vector<double> volts, points;
  for (std::size_t k = count - std::max(kFewest, count / 4); k < count; ++k) {
    const QuietCell& quiet = r.quiet_cells[k];
    volts.push_back(quiet.voltage_v - quiet.ocv_v);
    points.push_back(quiet.by_voltage - quiet.counted);
  }
  const double volts_apart = median(std::move(volts)), apart = median(std::move(points));
  if (std::abs(volts_apart) < kFar_v || std::abs(apart) < kFar) return;
  out.push_back({sized(kTrip, kMost), r.quiet_cells[count - kFewest].time_s, r.quiet_cells.back().time_s,
                 fmt::format("at little current the cells stand {:+.0f} mV from the open-circuit voltage of {} at the "
                             "charge that is counted ({:+.0f} points of SOC): the log is of another cell or capacity, "
                             "has other cells in series, or its current is off",
                             1e3 * volts_apart, r.pack, 100.0 * apart),
                 "the pack file: its curve, its capacity, its cells"});
}

/// A filter that is led by cells which its model does not describe leaves the charge that is counted.
void add_soc_against_charge(const ReplayResult& r, std::vector<Disagreement>& out) {
  constexpr double kSettled_s = 5.0, kLongest_s = 1.0, kLeast = 0.005, kApart = 0.02;  // s, s; of the capacity
  if (!(r.capacity_ah > 0.0) || r.open_s > 0.0) return;
  const ReplayRow *first = nullptr, *last = nullptr;
  double drawn_ah = 0.0;
  for (const ReplayRow& row : r.rows) {
    if (!std::isfinite(row.soc) || !std::isfinite(row.current_a) || row.time_s < r.begin_s + kSettled_s) continue;
    if (last != nullptr && row.time_s - last->time_s > kLongest_s) return;
    if (last != nullptr) drawn_ah += row.current_a * (row.time_s - last->time_s) / 3600.0;
    if (first == nullptr) first = &row;
    last = &row;
  }
  if (first == nullptr) return;
  const double drawn = drawn_ah / r.capacity_ah, moved = last->soc - first->soc;
  const bool against = drawn * moved > 0.0 && std::abs(drawn) > kLeast && std::abs(moved) > kLeast;
  if (!against || std::abs(moved + drawn) < kApart) return;
  out.push_back({sized(kTrip, kMost - 1.0), first->time_s, last->time_s,
                 fmt::format("the firmware's SOC {} by {:.1f} points while {:.2f} Ah ({:.1f} points) are {}: its "
                             "filter is led by cells that the pack file does not describe, and neither it nor what was "
                             "learned of them is to be believed",
                             moved > 0.0 ? "rises" : "falls", 100.0 * std::abs(moved), std::abs(drawn_ah),
                             100.0 * std::abs(drawn), drawn > 0.0 ? "drawn" : "charged"),
                 "the pack file's curve and resistance, or soc_method = \"coulomb\" in it"});
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
  add_wrong_pack(r, out);
  add_soc_against_charge(r, out);
  add_logged_faults(r, out);
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
