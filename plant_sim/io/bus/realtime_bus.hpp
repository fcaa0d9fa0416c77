// SPDX-License-Identifier: Apache-2.0
// The plant on a bus that the wall clock paces: no frame but the car's, control units that run by their own clocks.
#pragma once
#include <array>
#include <string>

#include "can_dbc/tables.hpp"
#include "io/bus/socket_bus.hpp"
#include "port/host/pacer.hpp"

namespace voltlap::plant {

class RealtimeBus final : public SocketBus {
 public:
  /// Throws port::BusSetupError, also when another plant sends already.
  explicit RealtimeBus(const std::string& interface);

  const Interventions& begin_tick(std::uint32_t tick) override;
  FrameView exchange(const TxQueue& plant) override;
  [[nodiscard]] StopAsked stop_asked() const override { return StopAsked::kNo; }
  [[nodiscard]] BusStatistics statistics() const override;

 private:
  static constexpr std::uint32_t kSilence_ticks = 50;  // every message of a control unit comes far more often

  void note_silence();

  port::Pacer pacer_{can::kTickMs * 1000, port::Lag::kCatchUp};
  std::array<std::uint64_t, kSenders> frames_before_{};
  std::array<std::uint32_t, kSenders> heard_{};  ///< tick of the last frame
  std::array<bool, kSenders> gone_{};
  std::uint32_t tick_ = 0;
  Interventions none_;
};

}  // namespace voltlap::plant
