// SPDX-License-Identifier: Apache-2.0
#include "report/bus_load_table.hpp"

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

std::string bus_load_table(const BusLoadResult& load) {
  std::string out = fmt::format("  bus load at {} kbit/s: {:.1f} % on average, {:.1f} % in the fullest 100 ms\n",
                                load.bit_rate / 1000, load.total_pct, load.peak_100ms_pct);
  out += fmt::format("    {:<10}  {:<18} {:>9} {:>9} {:>10} {:>10} {:>8} {:>8}\n", "id", "message", "frames", "frames/s",
                     "bits, mean", "bits, most", "load, %", "share, %");
  std::vector<BusLoadRow> rows = load.rows;
  std::stable_sort(rows.begin(), rows.end(), [](const BusLoadRow& a, const BusLoadRow& b) { return a.bits > b.bits; });
  for (const BusLoadRow& row : rows) {
    out += fmt::format("    {:<10}  {:<18} {:>9} {:>9.2f} {:>10.1f} {:>10} {:>8.2f} {:>8.2f}\n", id_text(row.id),
                       message_name(row.id), row.frames, load.frames_per_s(row), row.bits_mean(), row.bits_worst,
                       load.load_pct(row), load.share_pct(row));
  }
  return out;
}

}  // namespace voltlap::plant
