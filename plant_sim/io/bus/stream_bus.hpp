// SPDX-License-Identifier: Apache-2.0
// Control units at the other end of a stream: an emulated microcontroller, or the firmware as a process on a pipe. What
// goes over the stream is in firmware/port/lockstep/; one write and one read a tick.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "io/bus/board_account.hpp"
#include "io/bus/in_process_bus.hpp"
#include "io/bus/in_process_loop.hpp"
#include "io/bus/plant_bus.hpp"
#include "port/lockstep/frame_bytes.hpp"
#include "port/lockstep/greeting.hpp"

namespace voltlap::plant {

struct StreamOptions {
  int to_ecu = -1, from_ecu = -1;                    ///< file descriptors; they stay the caller's
  double answer_within_s = 10.0;                     ///< wall time, then the other side counts as stuck
  std::function<bool()> interrupted = [] { return false; };
  std::function<std::string()> what_became_of_it = [] { return std::string("has closed its stream"); };
  Ecus* inside = nullptr;                            ///< nodes that the other side does not have
};

class StreamBus final : public PlantBus {
 public:
  explicit StreamBus(StreamOptions options) : options_(std::move(options)) {}

  /// What the other side is. Throws BusFailure when it does not greet as the firmware does.
  [[nodiscard]] const port::Greeting& await_greeting();
  /// Hands over both configurations, as they lie in memory.
  void configure(std::span<const std::byte> bms, std::span<const std::byte> master, std::uint32_t layout);
  /// The run is over: the other side says what it knows of itself, and ends.
  void stop();

  void attach(FrameSink& sink) override { bus_.attach(sink); }
  const Interventions& begin_tick(std::uint32_t tick) override;
  /// Throws BusFailure when the other side is gone or does not answer.
  FrameView exchange(const TxQueue& plant) override;
  [[nodiscard]] const std::vector<LostNode>& lost() const override { return lost_; }
  [[nodiscard]] StopAsked stop_asked() const override { return StopAsked::kNo; }
  [[nodiscard]] std::uint64_t frames_sent() const override { return bus_.frames_sent(); }
  [[nodiscard]] std::uint32_t frames_in_tick_max() const override { return bus_.frames_in_tick_max(); }
  [[nodiscard]] const BoardAccount& account() const { return account_; }
  /// BusFailure has been thrown: the other side is not there any more.
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  void step_inside(Sender node);
  void call_board(FrameView frames);
  void take_answer();
  /// False for a frame of the lockstep, which is no part of the bus.
  bool is_of_bus(const Frame& frame);
  void count(const can::StepCost& cost);
  void write_all(const void* bytes, std::size_t count);
  void read_all(void* bytes, std::size_t count);
  bool read_some();
  [[nodiscard]] Frame next_frame();
  [[noreturn]] void fail(const std::string& what);

  StreamOptions options_;
  InProcessBus bus_;
  port::Greeting greeting_;
  BoardAccount account_;
  std::vector<std::uint8_t> batch_;
  std::array<std::uint8_t, 4096> raw_{};
  std::size_t raw_count_ = 0, raw_taken_ = 0;
  TxQueue tx_;
  Sender speaks_ = Sender::kBms;  ///< whose frames the board sends now
  bool answered_ = false, failed_ = false;
  std::uint32_t cost_of_tick_ = 0;  ///< of both nodes
  std::uint32_t tick_ = 0;
  const Interventions none_{};
  const std::vector<LostNode> lost_{};
};

}  // namespace voltlap::plant
