// SPDX-License-Identifier: Apache-2.0
// The full fit of runs that are ready: time constants, smoothness, number of branches, all parameters, intervals.
//
// First the circuit is taken for true: smoothness by evidence, nothing assumed about rests. If what is left is noise
// (uncertainty.hpp), that is the fit. If not, the circuit is an approximation: then half of the pulses, predicted from
// the other half, decide how smooth the tables are, and the ends of rests hold the OCV.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "learn/identify/circuit/circuit_residuals.hpp"
#include "learn/identify/fit/model_selection.hpp"
#include "learn/identify/fit/uncertainty.hpp"
#include "learn/identify/recording/holdout_blocks.hpp"

namespace voltlap::plant {

struct FullFitOptions {
  int branches = 0;  ///< 1..4; 0: chosen
  std::vector<OcvKnowledge> rests;  ///< OCV at the ends of rests
  double instrument_v2_s = 1e-8;    ///< noise of the recordings, see instrument_noise()
  std::function<void(const std::string&)> progress;  ///< may be empty
  std::optional<CircuitModel> start;                 ///< instead of a quick linear fit
  std::optional<Eigen::VectorXd> tau_centre_s{};     ///< of several tests together, instead of a search
  bool ends_undriven = false;    ///< a plain circuit is fitted beside tables, whose OCV goes on there
  bool one_temperature = false;  ///< laws over the temperature are fitted only where noise is all that is left
};

struct FullFit {
  FittedCircuit fit;
  FitPriors priors;              ///< as they were settled
  Eigen::VectorXd tau_centre_s;  ///< as CircuitResiduals takes them
  std::optional<CircuitModel> plain;  ///< a plain circuit beside the tables that were chosen
  Eigen::VectorXd packed;
  Uncertainty uncertainty;
  std::string smoothness_from;  ///< evidence, held-out pulses; --constant where too few are left out
  double smoothness = 0.0;      ///< of held-out pulses; 0 with evidence
  SmoothnessScores smoothness_scores;
  std::vector<OrderScore> orders;
  double noise_v2_s = 0.0;
  int iterations = 0;
  bool laws_held = false;  ///< those over the temperature, at what is believed
};

/// `priors`: typical resistance, longest time constant and OCV from elsewhere. Rows that no circuit follows lose
/// their weight in `runs`; what a reader must know is added to `notes`.
[[nodiscard]] FullFit full_fit(std::vector<MeasuredRun>& runs, FitPriors priors, const FullFitOptions& options,
                               std::vector<std::string>& notes);

}  // namespace voltlap::plant
