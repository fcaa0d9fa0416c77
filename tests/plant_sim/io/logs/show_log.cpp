// SPDX-License-Identifier: Apache-2.0
// show_log RECORDING [MAP [ROLE...]]: a recording's channels ("channel role samples begin end lowest highest") and what
// was said about it; "-" for no map; of the roles every sample ("sample role time value").
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "core/errors.hpp"
#include "io/logs/drive_log.hpp"

int main(int argc, char** argv) {
  using namespace voltlap::plant;
  if (argc < 2) return 2;
  const DataFolder data(VOLTLAP_DATA_FOLDER);
  try {
    RoleMap map;
    const bool given = argc > 2 && std::string(argv[2]) != "-";
    if (given) map = load_role_map(data.find("maps", argv[2], "MAP"));
    const DriveLog log = read_drive_log(argv[1], given ? &map : nullptr, data);
    for (int k = 3; k < argc; ++k) {
      const Channel* channel = log.find(argv[k]);
      for (std::size_t row = 0; channel != nullptr && row < channel->size(); ++row)
        fmt::print("sample {} {:.6f} {:.9g}\n", argv[k], channel->time_s[row], channel->value[row]);
    }
    for (const auto& [role, channel] : log.channels) {
      double low = 1e300, high = -1e300;
      for (const double value : channel.value) {
        if (!std::isfinite(value)) continue;
        low = std::min(low, value);
        high = std::max(high, value);
      }
      fmt::print("channel {} {} {:.6f} {:.6f} {:.9g} {:.9g}\n", role, channel.size(), channel.time_s.front(),
                 channel.time_s.back(), low, high);
    }
    for (const LogDefect& defect : log.defects) fmt::print("{}\n", defect.text);
    for (const std::string& note : log.notes) fmt::print("{}\n", note);
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
