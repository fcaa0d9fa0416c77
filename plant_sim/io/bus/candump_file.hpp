// SPDX-License-Identifier: Apache-2.0
// The frames of a run as a log of `candump -l`: (1.230000) vcan0 044#2A36, with simulated time.
#pragma once
#include <chrono>
#include <string>

#include "io/atomic_file.hpp"
#include "io/bus/frame_sink.hpp"

namespace voltlap::plant {

/// One line without its end, for a frame at a time in milliseconds since the start of the simulation.
[[nodiscard]] std::string candump_line(std::uint64_t time_ms, const Frame& frame);
/// The same for any time and interface.
[[nodiscard]] std::string candump_line(std::chrono::microseconds time, const Frame& frame,
                                       const std::string& interface);

class CandumpFile : public FrameSink {
 public:
  CandumpFile(const std::string& path, std::uint32_t tick_ms) : file_(path), tick_ms_(tick_ms) {}
  void on_frame(std::uint32_t tick, Sender sender, const Frame& frame) override;
  void complete() { file_.complete(); }
  void commit() { file_.commit(); }

 private:
  AtomicFile file_;
  std::uint32_t tick_ms_;
};

}  // namespace voltlap::plant
