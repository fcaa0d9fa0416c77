// SPDX-License-Identifier: Apache-2.0
#include "apps/map_finding.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "apps/flag_checks.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"
#include "io/logs/map_proposal.hpp"

namespace voltlap::plant {
namespace {

std::string text_of(const std::string& recording, const MapProposal& proposal) {
  return fmt::format("# Role map of {}.\n{}", recording, proposal.draft());
}

}  // namespace

void MapFinding::add(CLI::App& command) {
  command
      .add_option(
          "--dbc", dbc_files,
          "DBC file of the bus that was recorded: a role map is made from its signals, by their names, units and "
          "behaviour; once for each file")
      ->check(CLI::ExistingFile)
      ->allow_extra_args(false);
  add_output_file(
      command, "--write-map", write_map,
      "Write the role map that was made for the recording (TOML), for --map; what it leaves open is to be "
      "chosen there");
}

void MapFinding::check_needed(bool every_file_has_a_map) const {
  if (!is_asked() || !every_file_has_a_map) return;
  throw InputError(dbc_files.empty() ? "--write-map" : "--dbc", "--map for every recording",
                   "a recording without a map, for which one is made", "Leave out one of the flags");
}

std::optional<RoleMap> MapFinding::find_only(const std::string& recording) const {
  if (!is_asked()) return std::nullopt;
  return proposed_map(recording, map_proposal_for(recording, dbc_files));
}

std::optional<RoleMap> MapFinding::find(const std::string& recording) const {
  if (write_map.empty()) return find_only(recording);
  const MapProposal proposal = map_proposal_for(recording, dbc_files);
  AtomicFile file(write_map);
  file.write(text_of(recording, proposal));
  file.complete();
  file.commit();
  if (proposal.is_complete()) return proposal.map();
  throw InputError(recording, fmt::format("open: {}, {}", proposal.open.front().role, proposal.open.front().why),
                   "one signal for each role", fmt::format("Choose in {} and give it with --map", write_map));
}

std::string MapFinding::text(const std::string& recording) const {
  const MapProposal proposal = map_proposal_for(recording, dbc_files);
  static_cast<void>(proposed_map(recording, proposal));
  return text_of(recording, proposal);
}

ScratchFile::ScratchFile(const std::string& text)
    : path_((std::filesystem::temp_directory_path() / "voltlap-XXXXXX.toml").string()) {
  constexpr int kEnding = 5;  // ".toml"
  const int file = ::mkstemps(path_.data(), kEnding);
  if (file < 0) {
    throw OutputError(
        fmt::format("{}: {}. Set TMPDIR to a folder that can be written", path_, std::strerror(errno)));
  }
  ::close(file);
  std::ofstream(path_) << text;
}

ScratchFile::~ScratchFile() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace voltlap::plant
