// SPDX-License-Identifier: Apache-2.0
// A run with the firmware's own nodes, and what a test wants to know of it.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "apps/firmware_loop.hpp"
#include "io/bus/trace_hash.hpp"
#include "race/endurance.hpp"

namespace voltlap::plant::test {

/// The firmware, of which a node can fall silent at a time after power-on: it goes on running, its frames are lost.
class SilenceableLoop : public Ecus {
 public:
  explicit SilenceableLoop(const VehicleParameters& car) : firmware_(car) {}
  void bms(Instant now, FrameView rx, TxQueue& tx) override;
  void master(Instant now, FrameView rx, TxQueue& tx) override;

  std::uint32_t bms_silent_from_ms = UINT32_MAX;
  std::uint32_t master_silent_from_ms = UINT32_MAX;
  std::function<bool(const Frame&)> loses;  ///< asked for every frame and receiver: true loses it there

 private:
  FrameView left_of(FrameView rx);

  std::vector<Frame> left_;
  FirmwareLoop firmware_;
};

struct Record : EnduranceObserver {
  void on_frame(std::uint32_t tick, Sender sender, const Frame& frame) override;
  void on_sample(const TimeSample& sample) override { samples.push_back(sample); }
  void on_progress(double fraction, double) override { progress = fraction; }
  bool stop_requested() override { return samples.size() >= stop_after_samples; }

  bool hashes = false;  ///< only where a test asks: hashing costs as much as a small run
  std::size_t stop_after_samples = SIZE_MAX;
  std::vector<TimeSample> samples;
  TraceHash hash;
  double progress = 0.0;
};

/// vtm16e on Michigan 2015 with a representative cell, flying laps.
[[nodiscard]] EnduranceOptions nominal(int laps = 1);
/// The study's row: its laps from rest, tiled.
[[nodiscard]] EnduranceOptions study_row(int year);
[[nodiscard]] EnduranceResult drive(const EnduranceOptions& options);
[[nodiscard]] EnduranceResult drive(const EnduranceOptions& options, Record& record);

}  // namespace voltlap::plant::test
