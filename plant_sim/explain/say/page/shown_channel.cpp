// SPDX-License-Identifier: Apache-2.0
#include "explain/say/page/shown_channel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "explain/say/numbers.hpp"

namespace voltlap::plant {

std::string shown_number(double value) {
  constexpr double kRounding = 1e-6;
  return std::abs(value) < kRounding ? "0" : fmt::format("{:.3g}", value);
}

std::string channel_title(const Explanation& e, const Trace& trace) {
  const std::string& name = trace.channel;
  if (trace.member) return channel_words(name) + " minus the mean of the others";
  const auto any = [&](auto is) { return std::any_of(e.traces.begin(), e.traces.end(), is); };
  const bool cells = any([](const Trace& t) { return t.channel.starts_with("cell_voltage_"); }) ||
                     (any([](const Trace& t) { return t.channel == "voltage"; }) &&
                      any([](const Trace& t) { return t.channel == "pack_voltage"; }));
  if (name == "voltage") return cells ? "mean cell voltage given the current" : "cell voltage given the current";
  if (name == "pack_voltage") return cells ? "pack voltage given the cells" : "pack voltage given the current";
  if (name == "bus_voltage") return "bus voltage given the pack voltage";
  if (name == "temperature") return "temperature given the current";
  if (name == "power") return "electric power, as a torque, given torque and motor speed";
  if (name == "speed") return "speed gained in the last seconds given torque and brake";
  if (name == "motor_speed") return "motor speed given ground speed";
  if (name == "motor_torque") return "torque with the accelerator released";
  return channel_words(name);
}

bool is_changed(const Trace& trace) {
  constexpr double kSeen = 0.02;  // of the noise
  return rms_of(trace.after - trace.before) > kSeen * trace.floor;
}

}  // namespace voltlap::plant
