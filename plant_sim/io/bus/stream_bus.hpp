// SPDX-License-Identifier: Apache-2.0
// The bus of memory with a board at the other end of a stream for its control units: firmware that runs on an emulated
// microcontroller, or as a process on a pipe.
#pragma once
#include <cstdint>
#include <vector>

#include "io/bus/board_stream.hpp"
#include "io/bus/in_process_bus.hpp"
#include "io/bus/in_process_loop.hpp"
#include "io/bus/plant_bus.hpp"

namespace voltlap::plant {

class StreamBus final : public PlantBus {
 public:
  /// A board that has greeted, and the nodes that it does not have; both stay the caller's.
  StreamBus(BoardStream& board, Ecus& inside) : board_(board), inside_(inside) {}

  void attach(FrameSink& sink) override { bus_.attach(sink); }
  const Interventions& begin_tick(std::uint32_t tick) override;
  /// Throws BusFailure when the other side is gone or does not answer.
  FrameView exchange(const TxQueue& plant) override;
  [[nodiscard]] const std::vector<LostNode>& lost() const override { return lost_; }
  [[nodiscard]] StopAsked stop_asked() const override { return StopAsked::kNo; }
  [[nodiscard]] std::uint64_t frames_sent() const override { return bus_.frames_sent(); }
  [[nodiscard]] std::uint32_t frames_in_tick_max() const override { return bus_.frames_in_tick_max(); }

 private:
  void step_inside(Sender node);
  void step_board(FrameView frames);

  BoardStream& board_;
  Ecus& inside_;
  InProcessBus bus_;
  TxQueue tx_;
  std::uint32_t tick_ = 0;
  const Interventions none_{};
  const std::vector<LostNode> lost_{};
};

}  // namespace voltlap::plant
