// SPDX-License-Identifier: Apache-2.0
// Before any regression: gaps, held and frozen values, codes at the rail, steps. Bad stretches are masked with the
// reason; nothing is repaired.
#pragma once
#include <string>
#include <vector>

#include "explain/balances/model.hpp"
#include "explain/explanation.hpp"

namespace voltlap::plant {

struct GateFinding {
  std::string cause;  ///< dropped_or_late_frames, quantisation, frozen_signal
  std::string channel;
  std::string measure;  ///< count, step or duration_s
  double value = 0.0;
  std::string unit;
  bool worth_telling = false;  ///< by itself, without references
};

struct Gated {
  Recording log;
  std::vector<GateFinding> findings;
  std::string enough;  ///< empty: enough is left to judge; else why not
  std::string drive;   ///< then: what drive would
};

[[nodiscard]] Gated integrity_gate(Recording log, const Model& model);

/// Step of a signal's readings: nine tenths of neighbouring values are at least so far apart; 0 when there is none.
[[nodiscard]] double step_of(const Eigen::VectorXd& values);

/// Findings that the references do not have to the same degree; without references those worth telling by
/// themselves.
[[nodiscard]] std::vector<FoundCause> unusual_findings(const std::vector<GateFinding>& findings,
                                                       const std::vector<std::vector<GateFinding>>& references);

}  // namespace voltlap::plant
