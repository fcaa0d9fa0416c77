// SPDX-License-Identifier: Apache-2.0
// Whoever wants to see the frames of a run: hashes, log files, counters.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"

namespace voltlap::plant {

/// The node that sent a frame; the number stands in the trace hash.
enum class Sender : std::uint8_t { kPlant = 0, kBms = 1, kMaster = 2 };
inline constexpr std::size_t kSenders = 3;

class FrameSink {
 public:
  virtual ~FrameSink() = default;
  virtual void on_frame(std::uint32_t tick, Sender sender, const Frame& frame) = 0;
};

}  // namespace voltlap::plant
