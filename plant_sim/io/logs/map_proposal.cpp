// SPDX-License-Identifier: Apache-2.0
#include "io/logs/map_proposal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <optional>

#include "core/demand.hpp"
#include "core/listed.hpp"
#include "core/signal.hpp"
#include "io/logs/battery_pair.hpp"
#include "io/logs/signal_candidate.hpp"
#include "io/logs/signal_family.hpp"

namespace voltlap::plant {
namespace {

using SignalCandidates = std::vector<SignalCandidate>;

/// The clock of a table: never goes back but where a recorder begins anew, and moves on in nearly every row.
bool is_clock(const std::vector<double>& values) {
  constexpr double kMoves = 0.5, kBack = 0.01;
  std::size_t on = 0, back = 0, rows = 0;
  double last = std::numeric_limits<double>::quiet_NaN();
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    if (std::isfinite(last)) {
      on += value > last ? 1 : 0;
      back += value < last ? 1 : 0;
      ++rows;
    }
    last = value;
  }
  const double all = static_cast<double>(rows);
  return rows > 0 && static_cast<double>(on) > kMoves * all && static_cast<double>(back) <= kBack * all;
}

/// Steps that are alike but for rounding.
bool is_even(const std::vector<double>& values) {
  constexpr double kAlike = 0.05;
  const std::vector<double> steps = differences(values);
  const double usual = median(steps);
  return usual > 0.0 && quantile(steps, 0.95) - quantile(steps, 0.05) < kAlike * usual;
}

class Proposer {
 public:
  explicit Proposer(const RecordedSignals& recording) : recording_(recording) {
    for (const RecordedSignal& signal : recording.signals) all_.emplace_back(signal);
  }

  /// Beside a map.
  MapProposal propose_others(const RoleMap& map) {
    for (const RecordedSignal& signal : recording_.signals) {
      const bool used = std::any_of(map.roles.begin(), map.roles.end(), [&](const auto& entry) {
        return entry.second.column == signal.source.column;
      });
      if (used) taken_.push_back(&signal);
    }
    propose_families();
    propose_single();
    propose_motor();
    propose_temperature();
    return std::move(out_);
  }

  MapProposal propose() {
    propose_battery();
    if (!recording_.is_can) propose_time();
    propose_families();
    propose_single();
    if (!recording_.is_can) propose_motor();
    propose_temperature();
    if (recording_.is_can) note_unused_cells();
    std::stable_sort(out_.roles.begin(), out_.roles.end(),
                     [](const ProposedRole& a, const ProposedRole& b) { return rank(a.role) < rank(b.role); });
    return std::move(out_);
  }

 private:
  static int rank(const std::string& role) {
    const auto names = role_names();
    for (std::size_t k = 0; k < names.size(); ++k) {
      if (role == names[k] || number_in(names[k], role)) return static_cast<int>(k);
    }
    return static_cast<int>(names.size());
  }

  void add(const std::string& role, const SignalCandidate& candidate, const RoleSource& source,
           const std::string& evidence) {
    taken_.push_back(candidate.signal);
    out_.roles.push_back({role, source, candidate.signal->described(), evidence});
  }
  [[nodiscard]] bool is_taken(const SignalCandidate& candidate) const {
    return std::find(taken_.begin(), taken_.end(), candidate.signal) != taken_.end();
  }

  void propose_battery() {
    pair_ = choose_battery_pair(recording_, all_);
    leave_cells_to_their_family();
    for (const ProposedRole& role : pair_.roles) out_.roles.push_back(role);
    for (const OpenChoice& choice : pair_.open) out_.open.push_back(choice);
    taken_.insert(taken_.end(), pair_.taken.begin(), pair_.taken.end());
  }

  void leave_cells_to_their_family();
  [[nodiscard]] SignalFamily family_of(FamilyKind kind) const;
  [[nodiscard]] SignalCandidates clocks() const;
  void propose_time();
  void propose_time_unit(const SignalCandidate& clock);
  void propose_families();
  void add_family(const std::string& stem, const SignalFamily& family);
  void propose_single();
  void propose_motor();
  void propose_temperature();
  void note_unused_cells();
  [[nodiscard]] SignalCandidates named(Meaning meaning, bool of_others) const;

  const RecordedSignals& recording_;
  std::vector<SignalCandidate> all_;
  BatteryPair pair_;
  std::vector<const RecordedSignal*> taken_;
  MapProposal out_;
};

SignalFamily Proposer::family_of(FamilyKind kind) const {
  SignalCandidates free;
  std::copy_if(all_.begin(), all_.end(), std::back_inserter(free), [&](const SignalCandidate& candidate) {
    return !is_taken(candidate) && candidate.name.is_actual && !candidate.name.is_others;
  });
  return largest_family(free, kind);
}

/// One cell of many is no battery's voltage: all of them together are, where nothing else is.
void Proposer::leave_cells_to_their_family() {
  constexpr std::size_t kMany = 3;
  const SignalFamily cells = family_of(FamilyKind::kCells);
  if (cells.members.size() < kMany) return;
  const auto is_one = [&](const std::string& described) {
    return std::any_of(cells.members.begin(), cells.members.end(),
                       [&](const SignalCandidate& cell) { return cell.signal->described() == described; });
  };
  std::erase_if(pair_.roles, [&](const ProposedRole& role) {
    return (role.role == "voltage" || role.role == "pack_voltage") && is_one(role.described);
  });
  std::erase_if(pair_.taken, [&](const RecordedSignal* signal) { return is_one(signal->described()); });
  std::erase_if(pair_.open, [&](const OpenChoice& choice) {
    return choice.role == "voltage" && !choice.candidates.empty() &&
           std::all_of(choice.candidates.begin(), choice.candidates.end(),
                       [&](const ProposedRole& candidate) { return is_one(candidate.described); });
  });
}

/// Columns that could be the clock. A counter, an energy and a distance run on as one does; a name or a unit tells
/// it, or equal steps that no other has.
SignalCandidates Proposer::clocks() const {
  SignalCandidates named, unnamed, even;
  for (const SignalCandidate& candidate : all_) {
    const auto& unit = candidate.signal->unit;
    if (is_taken(candidate) || !is_clock(candidate.signal->value)) continue;
    if (unit && unit->quantity != Quantity::kTime) continue;
    const SpokenName& name = candidate.name;
    if (unit || (name.meaning == Meaning::kTime && !name.is_letter)) {
      named.push_back(candidate);
    } else if (name.meaning == Meaning::kNothing || name.is_letter) {
      unnamed.push_back(candidate);
      if (is_even(candidate.signal->value)) even.push_back(candidate);
    }
  }
  if (named.empty()) return even.size() == 1 ? even : unnamed;
  SignalCandidates plain;
  std::copy_if(named.begin(), named.end(), std::back_inserter(plain),
               [](const SignalCandidate& candidate) { return candidate.name.is_plain; });
  return plain.size() == 1 ? plain : named;
}

void Proposer::propose_time() {
  const SignalCandidates found = clocks();
  if (found.size() == 1) return propose_time_unit(found.front());
  OpenChoice choice{"time", "no column runs on from row to row", {}};
  if (!found.empty()) choice.why = fmt::format("{} columns run on as a clock does", found.size());
  for (const SignalCandidate& clock : found)
    choice.candidates.push_back(
        {"time", source_in(*clock.signal, "s"), clock.signal->described(), "runs on from row to row"});
  out_.open.push_back(std::move(choice));
}

void Proposer::propose_time_unit(const SignalCandidate& clock) {
  const std::string runs =
      clock.name.meaning == Meaning::kTime ? "by its name" : "runs on from row to row, the only one";
  if (clock.signal->unit) {
    return add("time", clock, source_in(*clock.signal, ""),
               fmt::format("{}, in {}", runs, clock.signal->unit->name));
  }
  const TimeUnits units = time_units(recording_, *clock.signal, pair_);
  if (units.possible.size() == 1) {
    return add("time", clock, source_in(*clock.signal, units.possible.front()),
               fmt::format("{}, in {}: {}", runs, units.possible.front(), units.why));
  }
  OpenChoice choice{"time", "its unit is not told and " + units.why, {}};
  for (const char* unit : {"s", "ms", "min", "h"}) {
    if (!units.possible.empty() &&
        std::find(units.possible.begin(), units.possible.end(), unit) == units.possible.end())
      continue;
    choice.candidates.push_back({"time", source_in(*clock.signal, unit), clock.signal->described(), runs});
  }
  out_.open.push_back(choice);
}

/// Cells and thermistors.
void Proposer::propose_families() {
  for (const FamilyKind kind : {FamilyKind::kCells, FamilyKind::kThermistors}) {
    const SignalFamily family = family_of(kind);
    if (!family.members.empty()) add_family(kind == FamilyKind::kCells ? "cell_voltage_" : "temperature_", family);
  }
}

/// Frame by frame where the same numbers come again in frames behind each other, each with as many.
std::optional<std::uint32_t> last_of_frames(const SignalCandidates& members) {
  std::map<std::uint32_t, std::size_t> frames;
  for (const SignalCandidate& member : members) ++frames[*member.signal->source.frame];
  const std::uint32_t first = frames.begin()->first, last = frames.rbegin()->first;
  const bool alike = std::all_of(frames.begin(), frames.end(), [&](const auto& frame) {
    return frame.second == frames.begin()->second || frame.first == last;  // the last may be filled in part
  });
  const bool close = last - first + 1 == frames.size();
  return alike && close ? std::optional(last) : std::nullopt;
}

/// One entry for all numbers of a frame, or of frames behind each other that count from one again; else each by itself.
void Proposer::add_family(const std::string& stem, const SignalFamily& family) {
  const SignalCandidates& members = family.members;
  VOLTLAP_DEMAND(!members.empty());
  std::map<long, const SignalCandidate*> by_number;
  for (const SignalCandidate& member : members) by_number.try_emplace(*member.name.number, &member);
  const long first = by_number.begin()->first <= 1 ? by_number.begin()->first : 1;
  const std::string evidence = fmt::format("{} alike but for their number{}, in range", members.size(),
                                           family.of_modules ? " and their module's, in that order" : "");
  const char* unit = stem.starts_with("cell") ? members.front().voltage_unit() : "degC";
  const std::optional<std::uint32_t> last = recording_.is_can ? last_of_frames(members) : std::nullopt;
  const bool in_one_frame = !family.of_modules && last && *last == *members.front().signal->source.frame;
  if (!in_one_frame && by_number.size() == members.size()) {
    for (const auto& [n, member] : by_number)
      add(stem + std::to_string(n - first + 1), *member, source_in(*member->signal, unit), evidence);
    return;
  }
  if (!last) return;  // the same numbers again, and nothing says in which order
  RoleSource source = source_in(*members.front().signal, unit);
  source.signal = members.front().name.pattern;
  if (*last != *source.frame) source.last_frame = last;
  if (first != 1) source.first = first;
  add(stem + "<n>", members.front(), source, evidence);
  for (const SignalCandidate& member : members) taken_.push_back(member.signal);
}

SignalCandidates Proposer::named(Meaning meaning, bool of_others) const {
  SignalCandidates out;
  for (const SignalCandidate& candidate : all_) {
    const bool fits = candidate.name.meaning == meaning && !candidate.name.is_letter && candidate.name.is_actual &&
                      !is_taken(candidate) && (of_others || !candidate.name.is_others) &&
                      (!candidate.signal->unit || is_of(candidate.signal->unit->quantity, meaning));
    if (fits) out.push_back(candidate);
  }
  return out;
}

/// Roles that help and that nothing depends on: taken where one name alone says so and its values are in range.
void Proposer::propose_single() {
  struct Single {
    const char* role;
    Meaning meaning;
    const char* unit;
    bool of_others;
  };
  constexpr Single kSingles[] = {{"soc", Meaning::kSoc, "", false},
                                 {"speed", Meaning::kSpeed, "m/s", false},
                                 {"accelerator", Meaning::kAccelerator, "", false},
                                 {"brake", Meaning::kBrake, "", false},
                                 {"motor_speed", Meaning::kMotorSpeed, "rpm", true},
                                 {"motor_torque", Meaning::kMotorTorque, "Nm", true},
                                 {"lateral_acceleration", Meaning::kLateralAcceleration, "m/s2", false}};
  for (const Single& single : kSingles) {
    const SignalCandidates candidates = named(single.meaning, single.of_others);
    if (candidates.size() != 1 || candidates.front().name.owner == Owner::kWheel) continue;
    const SignalCandidate& candidate = candidates.front();
    const bool told = candidate.signal->unit.has_value();
    const bool is_share = *single.unit == '\0';
    if (!told && (!candidate.name.is_plain || !is_share)) continue;  // km/h, m/s or mph: nothing tells
    const char* unit = is_share && !told && candidate.high() > 1.5 ? "%" : single.unit;
    const RoleSource source = source_in(*candidate.signal, unit);
    const RoleRange range = role_range(single.role);
    if (candidate.low() * source.scale + source.offset < range.min ||
        candidate.high() * source.scale + source.offset > range.max)
      continue;
    add(single.role, candidate, source, "by its name, in range");
  }
}

/// The current that makes the motor's torque, and the voltage on the inverter's side: taken where one signal alone is
/// called so and says its unit.
void Proposer::propose_motor() {
  SignalCandidates currents, buses;
  for (const SignalCandidate& candidate : all_) {
    if (is_taken(candidate) || !candidate.signal->unit || !candidate.name.is_actual) continue;
    const Quantity quantity = candidate.signal->unit->quantity;
    if (quantity == Quantity::kCurrent && candidate.name.meaning == Meaning::kCurrent && candidate.name.is_motors)
      currents.push_back(candidate);
    if (quantity == Quantity::kVoltage && candidate.name.owner == Owner::kBus && !candidate.is_cell_voltage())
      buses.push_back(candidate);
  }
  if (currents.size() == 1 && out_.find("motor_current") == nullptr)
    add("motor_current", currents[0], source_in(*currents[0].signal, "A"), "by its name and unit");
  if (buses.size() == 1 && out_.find("bus_voltage") == nullptr)
    add("bus_voltage", buses[0], source_in(*buses[0].signal, "V"), "by its name and unit");
}

void Proposer::propose_temperature() {
  SignalCandidates temperatures, ambients;
  for (const SignalCandidate& candidate : all_) {
    const bool fits = !is_taken(candidate) && candidate.name.is_actual && !candidate.name.is_others &&
                      (candidate.is_temperature() || candidate.is_called_ambient());
    if (fits) (candidate.name.owner == Owner::kAmbient ? ambients : temperatures).push_back(candidate);
  }
  if (ambients.size() == 1)
    add("ambient", ambients[0], source_in(*ambients[0].signal, "degC"), "by its name, in range");
  if (temperatures.size() == 1 && out_.find("temperature_1") == nullptr && out_.find("temperature_<n>") == nullptr)
    add("temperature_1", temperatures[0], source_in(*temperatures[0].signal, "degC"), "by its name, in range");
}

/// Signals of cells and thermistors that stand alone or under an index: a map can name them.
void Proposer::note_unused_cells() {
  std::vector<std::string> unused;
  for (const SignalCandidate& candidate : all_) {
    const bool cell = candidate.name.owner == Owner::kCell && candidate.is_of(Quantity::kVoltage, Meaning::kVoltage);
    if (is_taken(candidate) || !candidate.name.is_actual || !(cell || candidate.is_called_temperature())) continue;
    unused.push_back(candidate.signal->described());
  }
  if (unused.empty()) return;
  out_.notes.push_back(fmt::format("signals that no role takes: {}; a map (--map) can name them, with index where "
                                   "another signal says which cell it is",
                                   first_of(unused, 6)));
}

}  // namespace

MapProposal propose_others(const RecordedSignals& table, const RoleMap& map) {
  VOLTLAP_DEMAND(!table.is_can && map.find("current") != nullptr);
  return Proposer(table).propose_others(map);
}

MapProposal propose_map(const RecordedSignals& recording) {
  MapProposal out = Proposer(recording).propose();
  VOLTLAP_DEMAND(!out.is_complete() || out.find("current") != nullptr);
  VOLTLAP_DEMAND(!out.is_complete() || recording.is_can || out.find("time") != nullptr);
  return out;
}

}  // namespace voltlap::plant
