// SPDX-License-Identifier: Apache-2.0
#include "io/bus/bus_load_table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "can_dbc/tables.hpp"
#include "codec/message_table.hpp"

namespace voltlap::plant {

std::string message_name(std::uint32_t id) {
  const std::size_t row = codec::find_row(can::kMessages, codec::kMessageCount, id);
  return row == codec::kNoRow ? "-" : can::kMessageNames[row];
}

std::string id_text(std::uint32_t id) {
  const bool extended = (id & Frame::kExtendedFlag) != 0;
  return extended ? fmt::format("0x{:08X}", id & ~Frame::kExtendedFlag) : fmt::format("0x{:03X}", id);
}

namespace {

/// One line: a message, or those of one group.
struct Line {
  std::string ids, name;
  BusLoadRow sum;
};

/// "CellVoltages" of CellVoltages_07; empty for a message of no group.
std::string group_of(const std::string& name) {
  const std::size_t mark = name.rfind('_');
  const bool numbered =
      mark != std::string::npos && name.find_first_not_of("0123456789", mark + 1) == std::string::npos;
  return numbered ? name.substr(0, mark) : "";
}

std::vector<Line> lines_of(const BusLoadResult& load) {
  std::vector<Line> out;
  for (const BusLoadRow& row : load.rows) {
    const std::string name = message_name(row.id), group = group_of(name);
    if (out.empty() || group.empty() || group_of(out.back().name) != group) {
      out.push_back({id_text(row.id), name, row});
      continue;
    }
    Line& line = out.back();
    line.ids = fmt::format("{}..{:03X}", id_text(line.sum.id), row.id);
    line.sum.frames += row.frames;
    line.sum.bits += row.bits;
    line.sum.bits_worst = std::max(line.sum.bits_worst, row.bits_worst);
  }
  std::stable_sort(out.begin(), out.end(), [](const Line& a, const Line& b) { return a.sum.bits > b.sum.bits; });
  return out;
}

}  // namespace

std::string bus_load_table(const BusLoadResult& load) {
  std::string out = fmt::format("  bus load at {} kbit/s: {:.1f} % on average, {:.1f} % in the fullest 100 ms\n",
                                load.bit_rate / 1000, load.total_pct, load.peak_100ms_pct);
  out += fmt::format("    {:<10}  {:<17} {:>9} {:>9} {:>10} {:>10} {:>8} {:>8}\n", "id", "message", "frames",
                     "frames/s", "bits, mean", "bits, most", "load, %", "share, %");
  for (const Line& line : lines_of(load)) {
    const BusLoadRow& row = line.sum;
    const std::string name = line.ids == id_text(row.id) ? line.name : group_of(line.name);
    out += fmt::format("    {:<10}  {:<17} {:>9} {:>9.2f} {:>10.1f} {:>10} {:>8.2f} {:>8.2f}\n", line.ids, name,
                       row.frames, load.frames_per_s(row), row.bits_mean(), row.bits_worst, load.load_pct(row),
                       load.share_pct(row));
  }
  return out;
}

}  // namespace voltlap::plant
