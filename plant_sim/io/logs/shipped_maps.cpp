// SPDX-License-Identifier: Apache-2.0
// Which of the maps that ship (data/maps) fits a recording that is given without one.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "core/errors.hpp"
#include "io/logs/can/can_recording.hpp"
#include "io/logs/drive_log.hpp"
#include "io/logs/frame_checksum.hpp"
#include "io/logs/drive_columns.hpp"
#include "io/logs/map_proposal.hpp"
#include "io/logs/plain_columns.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kEnough = 20000;  // frames; every sender has spoken by then

struct Seen {
  std::size_t frames = 0;
  unsigned length = 0;
  double first_s = 0.0, last_s = 0.0;
  std::size_t holds[4] = {};  ///< frames of which a checksum holds, by FrameChecksum
};

std::map<std::uint32_t, Seen> frames_of(const std::string& path) {
  std::map<std::uint32_t, Seen> seen;
  CanRecording recording(path);
  RecordedFrame frame;
  for (std::size_t k = 0; k < kEnough && recording.next(frame); ++k) {
    Seen& entry = seen[frame.id & ~RecordedFrame::kExtendedFlag];
    if (entry.frames++ == 0) entry.first_s = frame.time_s;
    entry.last_s = frame.time_s;
    entry.length = std::max<unsigned>(entry.length, frame.length);
    for (const auto rule : {FrameChecksum::kOrion, FrameChecksum::kSum, FrameChecksum::kCrc8})
      entry.holds[static_cast<std::size_t>(rule)] += checksum_holds(rule, frame) ? 1U : 0U;
  }
  return seen;
}

/// Another sender may use the same identifiers: a checksum that the map knows must hold in most frames.
bool checksums_hold(const RoleMap& map, const std::map<std::uint32_t, Seen>& seen) {
  constexpr double kMost = 0.5;
  return std::all_of(map.roles.begin(), map.roles.end(), [&](const auto& entry) {
    const RoleSource& source = entry.second;
    if (!source.frame || source.checksum == FrameChecksum::kNone) return true;
    const auto at = seen.find(*source.frame & ~RecordedFrame::kExtendedFlag);
    if (at == seen.end()) return true;
    const double holds = static_cast<double>(at->second.holds[static_cast<std::size_t>(source.checksum)]);
    return holds > kMost * static_cast<double>(at->second.frames);
  });
}

bool has_columns(const RoleMap& map, const MeasuredTable& table) {
  return !map.match_columns.empty() && std::all_of(map.match_columns.begin(), map.match_columns.end(),
                                                   [&](const std::string& name) { return table.find(name) >= 0; });
}

std::string hexadecimal(std::uint32_t id) {
  return fmt::format("0x{:03X}", id);
}

/// "leaf_ze1_can fits but for frame 0x1DB": the map of which most is there, from half of it on.
std::string nearest(const std::vector<RoleMap>& shipped, const std::map<std::uint32_t, Seen>& seen) {
  const RoleMap* best = nullptr;
  std::vector<std::string> missing;
  for (const RoleMap& map : shipped) {
    std::vector<std::string> lacks;
    for (const std::uint32_t id : map.match_frames) {
      if (!seen.contains(id)) lacks.push_back(hexadecimal(id));
    }
    if (2 * lacks.size() > map.match_frames.size() || map.match_frames.empty()) continue;
    const bool closer = best == nullptr || lacks.size() < missing.size() ||
                        (lacks.size() == missing.size() && map.match_frames.size() > best->match_frames.size());
    if (!closer) continue;
    best = &map;
    missing = lacks;
  }
  if (best == nullptr) return "";
  const std::string name = std::filesystem::path(best->source).stem().string();
  if (missing.empty()) return fmt::format("{} fits but for the checksums of its frames. ", name);
  return fmt::format("{} fits but for frame{} {}. ", name, missing.size() > 1 ? "s" : "", fmt::join(missing, ", "));
}

/// What the bus carries, where no DBC file says what it means.
std::string frames_text(const std::map<std::uint32_t, Seen>& seen) {
  std::string out;
  for (const auto& [id, entry] : seen) {
    const double span_s = entry.last_s - entry.first_s;
    const double period_s = entry.frames > 1 ? span_s / static_cast<double>(entry.frames - 1) : 0.0;
    out += fmt::format("#   {}, {} bytes, {} frames, every {:.0f} ms\n", hexadecimal(id), entry.length,
                       entry.frames, 1e3 * period_s);
  }
  return out;
}

/// A start for a map: the roles with blanks, and the frames.
std::string blank_map(const std::map<std::uint32_t, Seen>& seen) {
  return "[roles]\n"
         "current = {frame = 0x?, signal = \"?\", dbc = \"?.dbc\", unit = \"A\", discharge = \"auto\"}\n"
         "pack_voltage = {frame = 0x?, signal = \"?\", dbc = \"?.dbc\", unit = \"V\"}\n"
         "\"cell_voltage_<n>\" = {frame = 0x?, signal = \"?\", index = \"?\", dbc = \"?.dbc\", unit = \"V\"}\n"
         "# frames of this recording:\n" +
         frames_text(seen);
}

std::vector<RoleMap> shipped_maps(const DataFolder& data) {
  std::vector<RoleMap> out;
  for (const std::string& name : data.names("maps")) out.push_back(load_role_map(data.find("maps", name, "maps")));
  return out;
}

RoleMap map_for_can(const std::string& path, const std::vector<RoleMap>& shipped) {
  const auto seen = frames_of(path);
  // One recording may carry the frames of several: the one that asks for most is the car's.
  const RoleMap* best = nullptr;
  for (const RoleMap& map : shipped) {
    const bool has = std::all_of(map.match_frames.begin(), map.match_frames.end(),
                                 [&](std::uint32_t id) { return seen.contains(id); });
    if (map.match_frames.empty() || !has || !checksums_hold(map, seen)) continue;
    if (best == nullptr || map.match_frames.size() > best->match_frames.size()) best = &map;
  }
  if (best != nullptr) return *best;
  throw InputError(
      path, fmt::format("a CAN recording with {} identifiers that no shipped map fits", seen.size()),
      "the DBC file of that bus (--dbc), or a role map (--map)",
      fmt::format("{}Give the DBC file, and a map is made from it; or save this draft, fill it and give it "
                  "with --map:\n{}",
                  nearest(shipped, seen), blank_map(seen)));
}

/// The map of a table, and whether it is a shipped one.
std::pair<RoleMap, bool> map_for_table(const MeasuredTable& table, const DataFolder& data) {
  for (const RoleMap& map : shipped_maps(data)) {
    if (has_columns(map, table)) return {map, true};
  }
  RoleMap map = role_map_for(table, data);
  return {map, !map.match.empty()};
}

}  // namespace

MapProposal map_proposal_for(const std::string& path, const std::vector<std::string>& dbc_files) {
  if (!is_can_recording(path)) return propose_map(signals_of(read_measured_table(path)));
  if (!dbc_files.empty()) return propose_map(signals_of(path, dbc_files));
  throw InputError(path, "a CAN recording without its DBC file", "--dbc FILE, once for each file",
                   "Give the DBC file of the bus that was recorded");
}

RoleMap proposed_map(const std::string& path, const MapProposal& proposal) {
  if (proposal.is_complete()) return proposal.map();
  std::vector<std::string> open;
  for (const OpenChoice& choice : proposal.open) open.push_back(fmt::format("{}: {}", choice.role, choice.why));
  throw InputError(
      path, fmt::format("{}", fmt::join(open, "; ")), "one signal for each of these roles",
      "This draft is a map but for that; save it (--write-map FILE does), choose, and give it with --map:\n" +
          proposal.draft());
}

RoleMap role_map_for_recording(const std::string& path, const DataFolder& data,
                               const std::vector<std::string>& dbc_files) {
  if (!is_can_recording(path)) return map_for_table(read_measured_table(path), data).first;
  if (!dbc_files.empty()) return proposed_map(path, map_proposal_for(path, dbc_files));
  return map_for_can(path, shipped_maps(data));
}

RoleMap role_map_for_drive(const std::string& path, const DataFolder& data) {
  if (is_can_recording(path)) return map_for_can(path, shipped_maps(data));
  const MeasuredTable table = read_measured_table(path);
  auto [map, shipped] = map_for_table(table, data);
  if (shipped) return map;
  add_pack_voltage(table, map);
  add_other_roles(signals_of(table), map);
  return map;
}

}  // namespace voltlap::plant
