// SPDX-License-Identifier: Apache-2.0
// How a voltage answers to a current: steps of one against steps of the other, dV = -R dI. Over short times the
// open circuit voltage stands still, so that this tells a battery's current from everything else that moves with
// the car.
#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "io/logs/recorded_signals.hpp"

namespace voltlap::plant {

/// Signals of one recording as means over the same blocks: some rows of a table, or a stretch of a CAN recording.
class BlockMeans {
 public:
  explicit BlockMeans(const RecordedSignals& recording);
  /// NaN for a block without a value near it. A signal that comes seldom is held from its last sample.
  [[nodiscard]] std::vector<double> of(const RecordedSignal& signal) const;
  [[nodiscard]] std::size_t size() const { return blocks_; }

 private:
  bool is_can_;
  std::size_t rows_a_block_ = 1, blocks_ = 0;
  double begin_s_ = 0.0, block_s_ = 0.1;
};

struct VoltageAnswer {
  static constexpr std::array<std::size_t, 3> kLags{1, 3, 10};  ///< blocks between the two ends of a step
  std::array<double, 3> correlation{};                          ///< of the steps, -1 to 1, by lag
  std::array<double, 3> slope{};                                ///< dV/dI as recorded, by lag
  std::size_t steps = 0;                                        ///< of the current, large ones, at the first lag

  [[nodiscard]] std::size_t best_lag() const;  ///< index of the lag with the clearest correlation
  [[nodiscard]] double clearest() const { return correlation[best_lag()]; }
  /// Share of the voltage's steps that the current does not explain.
  [[nodiscard]] double rest(std::size_t lag) const { return 1.0 - correlation[lag] * correlation[lag]; }
};

/// Both as BlockMeans has them.
[[nodiscard]] VoltageAnswer voltage_answer(const std::vector<double>& current, const std::vector<double>& voltage);

/// Both move as one, but for a scale and an offset: their steps correlate by more than 0.9995.
[[nodiscard]] bool is_same_course(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace voltlap::plant
