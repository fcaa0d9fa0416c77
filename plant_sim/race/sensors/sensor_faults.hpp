// SPDX-License-Identifier: Apache-2.0
// Faults of instruments and their wires, planted by a harness; none by default. The truth stays what it is.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace voltlap::plant {

struct SensorFaults {
  struct Channel {
    bool lost = false;    ///< the frame says "no value"
    double offset = 0.0;  ///< added to the reading [V, degC]
    double gain = 1.0;    ///< of the reading; cells only
    bool frozen = false;  ///< it reads what it last read, in frames that are new; cells only
  };
  std::vector<Channel> cells{}, thermistors{};  ///< shorter than the pack: the rest is sound
  std::array<bool, 2> brake_lost{};             ///< front, rear
  bool current_lost = false;
  bool current_frozen = false;
  double current_gain = 1.0;         ///< -1: the shunt is the wrong way round
  double current_offset_a = 0.0;
  std::optional<double> dc_link_v;   ///< what the sensor of the DC link reads for good
  double apps1_offset_v = 0.0;
  bool charger_silent = false;
  bool interlock_open = false;       ///< a plug of the tractive system is loose; it opens the shutdown circuit, too
  bool isolation_fault = false;      ///< the isolation monitor reports one; it opens the shutdown circuit, too

  /// The channel to plant a fault in.
  [[nodiscard]] static Channel& at(std::vector<Channel>& channels, std::size_t index) {
    if (channels.size() <= index) channels.resize(index + 1);
    return channels[index];
  }
  [[nodiscard]] static Channel of(const std::vector<Channel>& channels, std::size_t index) {
    return index < channels.size() ? channels[index] : Channel{};
  }
};

}  // namespace voltlap::plant
