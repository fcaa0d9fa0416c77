// SPDX-License-Identifier: Apache-2.0
// A log held against a model: by channel what was measured beyond it, at the readings' own times.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "explain/balances/balances.hpp"
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
  double between_rows = 0.0;  ///< practical sizes that the prediction may be off for what was not recorded
  double apart = 0.0;         ///< the same of cells that were read between the rows, steps of the load and all
  double stepped = 0.0;       ///< the same of what the steps of its sensors hide
};

/// One cell or thermistor.
struct Member {
  ReadChannel channel;  ///< named by its role
  std::size_t group = 0, index = 0;
};

struct Observed {
  plant::World model;
  plant::Comparison comparison;
  plant::Recording read;  ///< what its sensors read: coarse steps of thermistors taken away
  VectorXd thermistors_c;  ///< their mean, smoothed; empty: none
  VectorXd read_c;         ///< their mean, not a number where one of them was not read
  VectorXd fine_c;         ///< the same where their steps are taken away; empty: none
  plant::Prediction base;
  std::vector<ReadChannel> channels;  ///< as in the comparison
  std::vector<Member> members;
  VectorXd recorded_s;    ///< by row: recorded until then, gaps left out
  double block_s = 60.0;  ///< recorded time in a block
  Index blocks = 1;
  double left_beside_charge = 1.0;  ///< beginning.hpp
  bool begins_charged = false;      ///< by a drive that is not in the log

  /// What was reckoned of it: effects by channel, by what was changed.
  std::shared_ptr<std::map<std::string, std::vector<VectorXd>>> known =
      std::make_shared<std::map<std::string, std::vector<VectorXd>>>();

  /// What a changed world adds, by channel; empty where nothing.
  [[nodiscard]] std::vector<VectorXd> effect_of(const plant::Prediction& changed) const;
  [[nodiscard]] std::vector<Index> blocks_of(const ReadChannel& channel) const;  ///< of each bin
};
[[nodiscard]] Observed observed(const plant::World& model, plant::Comparison comparison);

/// RMS of a channel that is worth a word: a step of a good sensor.
[[nodiscard]] double practical_size(const std::string& channel, const Observed& log);

}  // namespace voltlap::explain
