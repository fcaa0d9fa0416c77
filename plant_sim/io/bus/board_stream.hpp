// SPDX-License-Identifier: Apache-2.0
// A board at the other end of a stream, tick by tick: an emulated microcontroller, or the firmware as a process on a
// pipe. What goes over the stream is in firmware/port/lockstep/; one write and one read a tick.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "io/bus/board_account.hpp"
#include "io/bus/frame_sink.hpp"
#include "io/bus/plant_bus.hpp"
#include "port/lockstep/frame_bytes.hpp"
#include "port/lockstep/greeting.hpp"

namespace voltlap::plant {

struct StreamOptions {
  int to_ecu = -1, from_ecu = -1;                    ///< file descriptors; they stay the caller's
  double answer_within_s = 10.0;                     ///< wall time, then the other side counts as stuck
  std::function<bool()> interrupted = [] { return false; };
  std::function<std::string()> what_became_of_it = [] { return std::string("has closed its stream"); };
};

/// Of the nodes of an image, those that a board steps.
struct BoardNodes {
  bool bms = true, master = true;
};

/// Everything throws BusFailure when the other side is gone, does not answer, or answers what no board does.
class BoardStream {
 public:
  using Heard = std::function<void(Sender, const Frame&)>;

  explicit BoardStream(StreamOptions options) : options_(std::move(options)) {}

  /// What the other side is.
  const port::Greeting& await_greeting();
  /// Hands over both configurations, as they lie in memory.
  void configure(std::span<const std::byte> bms, std::span<const std::byte> master, std::uint32_t layout,
                 BoardNodes nodes = {});
  /// A tick: the frames that the board hears, and each of its own in their order.
  void step(std::uint32_t tick, FrameView frames, const Heard& heard);
  /// The board loses its supply for a moment, and greets again.
  void reset();
  /// The run is over: the other side says what it knows of itself, and ends.
  void stop();

  [[nodiscard]] const BoardNodes& nodes() const { return nodes_; }
  [[nodiscard]] const BoardAccount& account() const { return account_; }
  /// BusFailure has been thrown: the other side is not there any more.
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  void take_answer(const Heard& heard);
  /// False for a frame of the lockstep, which is no part of the bus.
  bool is_of_bus(const Frame& frame);
  void count(const can::StepCost& cost);
  void write_frame(const Frame& frame);
  void write_all(const void* bytes, std::size_t count);
  void read_all(void* bytes, std::size_t count);
  bool read_some();
  [[nodiscard]] Frame next_frame();
  [[noreturn]] void fail(const std::string& what);

  StreamOptions options_;
  port::Greeting greeting_;
  BoardNodes nodes_;
  BoardAccount account_;
  std::vector<std::uint8_t> batch_;
  std::array<std::uint8_t, 4096> raw_{};
  std::size_t raw_count_ = 0, raw_taken_ = 0;
  Sender speaks_ = Sender::kBms;  ///< whose frames the board sends now
  bool answered_ = false, failed_ = false;
  std::uint32_t cost_of_tick_ = 0;  ///< of both nodes
  std::uint32_t tick_ = 0;
};

}  // namespace voltlap::plant
