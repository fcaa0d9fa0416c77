// SPDX-License-Identifier: Apache-2.0
// A BMS that listens to a drive and believes something wrong: what its state of charge is then, against the truth. Its
// own frames go nowhere, so that any number of them hear the same drive, each with errors of its own.
#pragma once
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "app/bms_node.hpp"
#include "codec/seal.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// What is wrong with what a BMS is told; without a value nothing is.
struct SocErrors {
  double start_points = 0.0;          ///< of the record that it starts from in mid-drive, against the truth
  bool restarted = false;             ///< in mid-drive, from a record
  double current_offset = 0.0;        ///< share of the range of the channel in use, from the start of the drive on
  double current_gain = 1.0, resistance = 1.0, capacity = 1.0;
  double voltage_gain = 1.0, voltage_offset_v = 0.0;
  bool noise = false, quantisation = false;
};

/// Errors of an estimate against the truth, in points.
class SocScore {
 public:
  void add(double error_points);
  [[nodiscard]] std::size_t samples() const { return samples_; }
  [[nodiscard]] double rms() const;
  [[nodiscard]] double largest() const { return largest_; }

 private:
  double squares_ = 0.0, largest_ = 0.0;
  std::size_t samples_ = 0;
};

/// True states of the cells, at an instant.
struct SocTruth {
  double pack;
  const std::vector<double>& cells;
};

class SocListener {
 public:
  SocListener(const bms::Config& config, const SocErrors& errors, const SensorSection& sensors, std::uint64_t seed);

  /// Frames of one tick as the bus has them; `rests`: nothing has been drawn yet.
  void tick(Instant now, FrameView rx, bool rests);
  /// The record of a restart; not before it is there does a restarted one hear anything.
  void begin(const SocTruth& truth);
  [[nodiscard]] bool waits() const { return errors_.restarted && !node_; }

  /// Of the pack, and of the cell with the lowest true charge, by that cell's own filter where there is one [points].
  void judge(const SocTruth& truth);

  [[nodiscard]] const SocScore& pack() const { return pack_; }
  [[nodiscard]] const SocScore& weakest() const { return weakest_; }
  [[nodiscard]] const app::BmsNode& node() const { return *node_; }
  [[nodiscard]] double soc() const;
  [[nodiscard]] double cell_soc(std::size_t cell) const;

 private:
  [[nodiscard]] Frame heard(const Frame& frame, bool rests);
  [[nodiscard]] std::int32_t current_ma(std::int32_t truth_ma, bool rests);
  [[nodiscard]] std::int32_t cell_100uv(std::int32_t truth_100uv);

  bms::Config config_;
  SocErrors errors_;
  SensorSection sensors_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  codec::Sealer sealer_{};
  std::optional<app::BmsNode> node_;
  std::vector<Frame> heard_;
  SocScore pack_, weakest_;
};

/// A configuration whose capacity and resistances are off as the errors say.
[[nodiscard]] bms::Config mistaken(bms::Config config, const SocErrors& errors);

}  // namespace voltlap::plant
