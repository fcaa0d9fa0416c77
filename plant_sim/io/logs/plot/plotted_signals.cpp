// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/plotted_signals.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>

#include "io/logs/can/can_recording.hpp"
#include "io/logs/channel_builder.hpp"

namespace voltlap::plant {

std::unique_ptr<PlottedSignals> open_signals(const SignalSources& sources, const DataFolder& data) {
  if (!sources.dbc_files.empty()) return can_signals(sources, data);
  if (!sources.map.empty()) return role_signals(sources, data);
  return is_can_recording(sources.recording) ? role_signals(sources, data) : table_signals(sources.recording);
}

std::string start_text(double begin_s) {
  if (!is_absolute(begin_s)) return {};
  const auto whole = static_cast<std::time_t>(begin_s);
  return fmt::format("{:%Y-%m-%d %H:%M:%S}.{:03.0f} UTC", fmt::gmtime(whole),
                     std::floor(1e3 * (begin_s - static_cast<double>(whole))));
}

}  // namespace voltlap::plant
