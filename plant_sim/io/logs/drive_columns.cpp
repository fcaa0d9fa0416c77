// SPDX-License-Identifier: Apache-2.0
#include "io/logs/drive_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/demand.hpp"
#include "core/listed.hpp"
#include "io/logs/map_proposal.hpp"
#include "io/logs/signal_candidate.hpp"
#include "io/logs/untold_units.hpp"

namespace voltlap::plant {
namespace {

/// A column that is called a voltage and lies beyond any cell's.
void call_the_packs(const RecordedSignals& table, RoleMap& map) {
  const RoleSource* voltage = map.find("voltage");
  if (voltage == nullptr || map.find("pack_voltage") != nullptr) return;
  const double most_v = role_range("cell_voltage_1").max;
  for (const RecordedSignal& signal : table.signals) {
    if (signal.source.column != voltage->column) continue;
    const double middle_v = SignalCandidate(signal).middle() * voltage->scale + voltage->offset;
    if (!(middle_v > most_v)) return;
    map.notes.push_back(fmt::format("\"{}\" is the pack's voltage: {:.4g} V in the middle, beyond any cell's",
                                    voltage->column, middle_v));
    map.roles["pack_voltage"] = *voltage;
    map.roles.erase("voltage");
    return;
  }
}

void note_unused(const RecordedSignals& table, RoleMap& map) {
  std::vector<std::string> unused;
  for (const RecordedSignal& signal : table.signals) {
    const bool used = std::any_of(map.roles.begin(), map.roles.end(), [&](const auto& entry) {
      return entry.second.column == signal.source.column ||
             number_in(entry.second.column, signal.source.column).has_value();
    });
    if (!used) unused.push_back(fmt::format("\"{}\"", signal.label));
  }
  if (unused.empty()) return;
  map.notes.push_back(fmt::format("columns that no role takes: {}; a map (--map) can name them", first_of(unused, 12)));
}

/// Of a numbered role what stands before its number; others as they are.
std::string stem_of(const std::string& role) { return role.substr(0, role.find_last_not_of("0123456789") + 1); }

/// Families in one piece: cell_voltage_1 to 96 from "Cell 1" to "Cell 96".
std::string others_text(const std::vector<ProposedRole>& roles) {
  struct Family {
    const ProposedRole *first, *last;
  };
  std::vector<std::pair<std::string, Family>> families;
  for (const ProposedRole& role : roles) {
    const std::string stem = stem_of(role.role);
    if (families.empty() || families.back().first != stem) families.push_back({stem, {&role, &role}});
    families.back().second.last = &role;
  }
  std::vector<std::string> parts;
  for (const auto& [stem, family] : families) {
    const auto& [first, last] = family;
    const std::string unit = first->source.unit.empty() ? ", no unit given" : " in " + first->source.unit;
    parts.push_back(first == last
                        ? fmt::format("{} from \"{}\"{}", first->role, first->source.column, unit)
                        : fmt::format("{} to {} from \"{}\" to \"{}\"{}", first->role, last->role.substr(stem.size()),
                                      first->source.column, last->source.column, unit));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace

void add_other_roles(const RecordedSignals& table, RoleMap& map) {
  VOLTLAP_DEMAND(!table.is_can && map.find("current") != nullptr);
  settle_untold_units(table, map);
  call_the_packs(table, map);
  // "Temp 1" was one thermistor by its name; with others beside it they are a family, unless that is another's.
  auto first = map.find("temperature_2") == nullptr ? map.roles.extract("temperature_1")
                                                    : std::map<std::string, RoleSource>::node_type();
  std::vector<ProposedRole> others = propose_others(table, map).roles;
  const bool within = first.empty() || std::any_of(others.begin(), others.end(), [&](const ProposedRole& other) {
    return other.source.column == first.mapped().column;
  });
  if (!within) map.roles.insert(std::move(first));
  std::set<std::string> has;
  for (const auto& [role, source] : map.roles) has.insert(stem_of(role));
  std::vector<ProposedRole> added;
  for (ProposedRole& other : others) {
    if (has.contains(stem_of(other.role))) continue;
    map.roles[other.role] = other.source;
    added.push_back(std::move(other));
  }
  if (!added.empty()) map.notes.push_back("columns recognised by their names and ranges: " + others_text(added));
  note_unused(table, map);
}

}  // namespace voltlap::plant
