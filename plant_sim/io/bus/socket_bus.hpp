// SPDX-License-Identifier: Apache-2.0
// The plant's end of a CAN interface: its own frames and everybody else's, read back in the order of the bus.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "io/bus/bus_statistics.hpp"
#include "io/bus/plant_bus.hpp"
#include "port/host/socket_can.hpp"

namespace voltlap::plant {

class SocketBus : public PlantBus {
 public:
  void attach(FrameSink& sink) override { sinks_.push_back(&sink); }
  [[nodiscard]] const std::vector<LostNode>& lost() const override { return lost_; }
  [[nodiscard]] std::uint64_t frames_sent() const override { return frames_sent_; }
  [[nodiscard]] std::uint32_t frames_in_tick_max() const override { return frames_in_tick_max_; }
  [[nodiscard]] virtual BusStatistics statistics() const;

 protected:
  /// Throws port::BusSetupError.
  explicit SocketBus(const std::string& interface);

  void read() { data_.drain(arrivals_); }
  /// Hands everything that was read to the sinks; the frames of the control units.
  FrameView hand_out(std::uint32_t tick);

  port::SocketCan data_;
  std::vector<port::Arrival> arrivals_;                 ///< read and not yet handed out
  std::vector<LostNode> lost_;
  std::array<std::uint64_t, kSenders> frames_of_{};     ///< read back so far

 private:
  std::vector<FrameSink*> sinks_;
  std::vector<Frame> commands_;
  std::uint64_t frames_sent_ = 0, foreign_ = 0;
  std::uint32_t frames_in_tick_max_ = 0;
};

}  // namespace voltlap::plant
