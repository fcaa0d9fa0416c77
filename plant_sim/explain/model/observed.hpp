// SPDX-License-Identifier: Apache-2.0
// A log held against a model: by channel what was measured beyond it, at the readings' own times.
#pragma once
#include <string>
#include <vector>

#include "discrepancy/balances.hpp"
#include "explain/model/readings.hpp"

namespace voltlap::explain {

/// What one channel, or one member of a group beyond the mean of all, was measured beyond the model.
struct ReadChannel {
  std::string name, unit;
  plant::Balance balance = plant::Balance::kVoltage;
  double practical = 0.0;  ///< RMS that is worth a word
  Reader reader;
  VectorXd residual;  ///< by bin
  VectorXd rough;     ///< how fast the current changed there, over its RMS
};

/// One cell or thermistor.
struct Member {
  ReadChannel channel;  ///< named by its role
  std::size_t group = 0, index = 0;
};

struct Observed {
  plant::World model;
  plant::Comparison comparison;
  plant::Prediction base;
  std::vector<ReadChannel> channels;  ///< as in the comparison
  std::vector<Member> members;
  double block_s = 60.0;
  Index blocks = 1;

  /// What a changed world adds, by channel; empty where nothing.
  [[nodiscard]] std::vector<VectorXd> effect_of(const plant::Prediction& changed) const;
  [[nodiscard]] std::vector<Index> blocks_of(const ReadChannel& channel) const;
};
/// `hold_is_known`: how the logger holds the current between its rows is that of the comparison; else the voltage
/// tells.
[[nodiscard]] Observed observed(const plant::World& model, plant::Comparison comparison,
                                bool hold_is_known = false);

/// RMS of a channel that is worth a word: a step of a good sensor.
[[nodiscard]] double practical_size(const std::string& channel, const plant::World& model,
                                    const plant::Comparison& comparison);

}  // namespace voltlap::explain
