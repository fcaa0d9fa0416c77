// SPDX-License-Identifier: Apache-2.0
// Which of the maps that ship (data/maps) fits a recording that is given without one.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/errors.hpp"
#include "io/logs/can/can_recording.hpp"
#include "io/logs/drive_log.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kEnough = 20000;  // frames; every sender has spoken by then

struct Seen {
  std::size_t frames = 0;
  unsigned length = 0;
  double first_s = 0.0, last_s = 0.0;
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
  }
  return seen;
}

/// A start for a map: the roles with blanks, and what the bus carries.
std::string draft(const std::map<std::uint32_t, Seen>& seen) {
  std::string out =
      "[roles]\n"
      "current = {frame = 0x?, signal = \"?\", dbc = \"?.dbc\", unit = \"A\", discharge = \"auto\"}\n"
      "pack_voltage = {frame = 0x?, signal = \"?\", dbc = \"?.dbc\", unit = \"V\"}\n"
      "\"cell_voltage_<n>\" = {frame = 0x?, signal = \"?\", index = \"?\", dbc = \"?.dbc\", unit = \"V\"}\n"
      "# frames of this recording:\n";
  for (const auto& [id, entry] : seen) {
    const double span_s = entry.last_s - entry.first_s;
    const double period_s = entry.frames > 1 ? span_s / static_cast<double>(entry.frames - 1) : 0.0;
    out += fmt::format("#   0x{:03X}, {} bytes, {} frames, every {:.0f} ms\n", id, entry.length, entry.frames,
                       1e3 * period_s);
  }
  return out;
}

}  // namespace

RoleMap role_map_for_recording(const std::string& path, const DataFolder& data) {
  if (!is_can_recording(path)) return role_map_for(read_measured_table(path), data);
  const auto seen = frames_of(path);
  for (const std::string& name : data.names("maps")) {
    RoleMap map = load_role_map(data.find("maps", name, "maps"));
    const auto has = [&](std::uint32_t id) { return seen.contains(id); };
    if (!map.match_frames.empty() && std::all_of(map.match_frames.begin(), map.match_frames.end(), has)) return map;
  }
  throw InputError(path, fmt::format("a CAN recording with {} identifiers that no shipped map fits", seen.size()),
                   "a role map that names frames, signals and a DBC file (--map)",
                   "This draft is a start for one; save it, fill it and give it with --map:\n" + draft(seen));
}

}  // namespace voltlap::plant
