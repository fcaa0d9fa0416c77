// SPDX-License-Identifier: Apache-2.0
// One log against one model: residuals, and the signature of every form of every cause in every channel. Columns are in
// typical sizes of their parameter, so that a coefficient of 1 is a usual change.
#pragma once
#include <Eigen/Dense>
#include <string>
#include <vector>

#include "discrepancy/cause.hpp"

namespace voltlap::plant {

/// Signature of one linear parameter of a form that acts on everything; `cause` is -1 for a shape that nobody named.
struct Column {
  int cause = -1;
  std::size_t form = 0, parameter = 0;
  std::string key;                         ///< the same in every log
  Balance balance = Balance::kVoltage;
  std::vector<Eigen::VectorXd> effect;     ///< by channel; empty: none there
  std::size_t kin = 0;                     ///< of a shape without a name: shapes of a channel that are of one size
  double usual = 0.0;                      ///< how much of it a sound model usually misses, one sigma
  double repeats = 0.0;                    ///< and how much that differs from log to log
  bool of_start = false;                   ///< as large as something that this log's start shows: no measure of others'
  double free = 0.0;                       ///< how much nobody can know of it beforehand; then it is never a cause
};

/// Signature of one linear parameter on a member of a group; `cause` is -1 for what differs between sound members.
struct Shape {
  int cause = -1;
  std::size_t form = 0, parameter = 0;
  std::string key;
  double spread = 0.0, repeats = 0.0;      ///< among sound members, and of one of them from log to log
  Eigen::VectorXd effect;
};

struct Design {
  World model;
  Comparison comparison;
  Prediction base;
  std::vector<Eigen::VectorXd> residual;   ///< by channel; NaN where not valid
  std::vector<std::vector<Form>> forms;    ///< by cause
  std::vector<Column> columns;
  std::vector<std::vector<Shape>> shapes;  ///< by group
};

[[nodiscard]] Design design_of(const World& model, Comparison comparison, const std::vector<Cause>& causes);

/// measured - predicted of every channel.
[[nodiscard]] std::vector<Eigen::VectorXd> residuals_of(const Comparison& comparison, const Prediction& prediction);

}  // namespace voltlap::plant
