// SPDX-License-Identifier: Apache-2.0
#include "apps/recording_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "apps/flag_checks.hpp"
#include "core/errors.hpp"
#include "core/input_files.hpp"
#include "io/logs/role_map.hpp"

namespace voltlap::plant {

void RecordingInput::add(CLI::App& command) {
  command
      .add_option("LOG", path_,
                  "A recording of a CAN bus: candump, Vector ASC, SLCAN, raw hex, BLF, TRC, MF4, GVRET CSV, BUSMASTER, "
                  "PCAP; plain, gzip or zstd")
      ->required();
  command.add_option("--dbc", dbc_, "DBC file (KCD, SYM, ARXML as well) that knows the frames; may be given again")
      ->allow_extra_args(false);
  command.add_option("--map", map_, "Role map, whose DBC files and intervals are used");
}

std::unique_ptr<CanRecording> RecordingInput::open(const DbcSet& dbc, bool keep_remote) const {
  CanReading reading;
  reading.broken = BrokenStream::kKeep;
  reading.keep_remote = keep_remote;
  reading.period_s = period_s_;
  for (const auto& file : dbc.files()) {
    for (const DbcMessage& message : file->messages()) {
      if (message.cycle_time_s) reading.period_s.try_emplace(message.id, *message.cycle_time_s);
    }
  }
  return std::make_unique<CanRecording>(path_, reading);
}

void RecordingInput::refuse_as_output(const std::string& out) const {
  note_input(path_);
  refuse_input_as_output(out);
}

DbcSet RecordingInput::dbc(const DataFolder& data) {
  std::vector<std::string> files = dbc_;
  if (!map_.empty()) {
    const RoleMap map = load_role_map(data.find("maps", map_, "--map"));
    std::set<std::string> named;
    for (const auto& [role, source] : map.roles) {
      if (source.frame) named.insert(path_in_map(map, source.dbc));
      if (source.frame && source.period_s) period_s_[*source.frame] = *source.period_s;
    }
    files.insert(files.end(), named.begin(), named.end());
  }
  return DbcSet(files);
}

DbcSet RecordingInput::needed_dbc(const DataFolder& data) {
  DbcSet out = dbc(data);
  if (!out.empty()) return out;
  throw InputError("voltlap log", "no DBC file", "--dbc FILE, or a --map that names some",
                   "Give the DBC file of the car; `voltlap log info` shows what is on the bus without one");
}

std::string remarks_text(const std::string& path, const CanSummary& summary) {
  std::string out;
  for (const CanDefect& defect : summary.defects) {
    out += fmt::format("  {:7} x {}{}{}\n", defect.count, defect.kind, defect.used ? " (used)" : ", left out",
                       defect.first_line > 0 ? fmt::format(", first in line {}", defect.first_line) : "");
  }
  for (const std::string& note : summary.notes) out += fmt::format("  {}\n", note);
  if (!summary.broken.empty()) out += fmt::format("  {}: {}; what stands before it is kept\n", path, summary.broken);
  return out;
}

}  // namespace voltlap::plant
