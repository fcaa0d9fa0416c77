// SPDX-License-Identifier: Apache-2.0
// How full the bus was, from the frames that were sent: every bit of each, stuff bits included.
//   load = bits / (bit rate * time); the time of a frame is the tick in which it was sent.
#pragma once
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "io/bus/frame_bits.hpp"
#include "io/bus/frame_sink.hpp"

namespace voltlap::plant {

/// The frames of one identifier.
struct BusLoadRow {
  std::uint32_t id = 0;  ///< bit 31: 29-bit identifier
  std::uint64_t frames = 0;
  std::uint64_t bits = 0;
  std::uint32_t bits_worst = 0;  ///< of the longest frame seen

  [[nodiscard]] double bits_mean() const {
    return frames > 0 ? static_cast<double>(bits) / static_cast<double>(frames) : 0.0;
  }
};

struct BusLoadResult {
  std::uint32_t bit_rate = 0;
  double time_s = 0.0;
  double total_pct = 0.0;
  double peak_100ms_pct = 0.0;  ///< the fullest 100 ms, by ticks
  std::vector<BusLoadRow> rows;  ///< by identifier

  [[nodiscard]] double frames_per_s(const BusLoadRow& row) const;
  [[nodiscard]] double load_pct(const BusLoadRow& row) const;
  /// Of all bits that were sent.
  [[nodiscard]] double share_pct(const BusLoadRow& row) const;
};

class BusLoad : public FrameSink {
 public:
  BusLoad(std::uint32_t tick_ms, std::uint32_t bit_rate);
  /// Ticks never go back.
  void on_frame(std::uint32_t tick, Sender sender, const Frame& frame) override;
  /// Of the time from the start of tick 0 to the end of the last tick that had a frame.
  [[nodiscard]] BusLoadResult result() const;

 private:
  struct Counter {
    BusLoadRow row;
    std::array<FrameHead, Frame::kMaxBytes + 1> heads;
  };
  Counter& counter(std::uint32_t id);
  void go_to(std::uint32_t tick);

  static constexpr std::uint32_t kWindow_ms = 100;
  static constexpr std::uint32_t kStandardIds = 0x800;

  std::uint32_t tick_ms_, bit_rate_;
  std::vector<Counter> counters_;
  std::array<std::uint16_t, kStandardIds> index_{};        // one more than the place in counters_; 0: none yet
  std::unordered_map<std::uint32_t, std::size_t> extended_;  // the same for 29-bit identifiers
  std::uint32_t tick_ = 0;
  std::vector<std::uint64_t> window_;  // bits of the last ticks, a ring
  std::uint64_t in_window_ = 0, peak_ = 0;
};

}  // namespace voltlap::plant
