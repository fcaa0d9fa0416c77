// SPDX-License-Identifier: Apache-2.0
// A role map for a recording that nobody has described: by the names of its columns or signals, their units, their
// ranges, and by behaviour: the battery's current is the one that its voltage answers to, with the resistance of a
// battery. What the recording leaves open is not chosen but asked, since a wrong current is worse than none.
#pragma once
#include <string>
#include <vector>

#include "io/logs/recorded_signals.hpp"
#include "io/logs/role_map.hpp"

namespace voltlap::plant {

struct ProposedRole {
  std::string role;
  RoleSource source;
  std::string described;  ///< the signal, for people
  std::string evidence;
};

/// A role that is needed, and what could play it.
struct OpenChoice {
  std::string role, why;
  std::vector<ProposedRole> candidates;  ///< the likeliest first; empty: nothing could
};

struct MapProposal {
  std::vector<ProposedRole> roles;
  std::vector<OpenChoice> open;
  std::vector<std::string> notes{};

  /// Time (of a table), current and voltage are there, each with clear evidence.
  [[nodiscard]] bool is_complete() const { return open.empty(); }
  [[nodiscard]] const ProposedRole* find(const std::string& role) const;
  /// With a note for each role. It has to be complete.
  [[nodiscard]] RoleMap map() const;
  /// The content of a map's file; what is open stands there as lines of which one is to be chosen.
  [[nodiscard]] std::string draft() const;
};

[[nodiscard]] MapProposal propose_map(const RecordedSignals& recording);

/// The same of a file: a table, or a CAN recording with the DBC files of its bus.
[[nodiscard]] MapProposal map_proposal_for(const std::string& path, const std::vector<std::string>& dbc_files);

/// Of a table, what columns that a map does not use say beside it: cells, thermistors, SOC, speeds, pedals.
[[nodiscard]] MapProposal propose_others(const RecordedSignals& table, const RoleMap& map);

/// The map of a complete proposal; throws InputError with the draft for one that leaves a choice open.
[[nodiscard]] RoleMap proposed_map(const std::string& path, const MapProposal& proposal);

}  // namespace voltlap::plant
