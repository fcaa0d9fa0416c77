// SPDX-License-Identifier: Apache-2.0
// From recordings of a cell to its model: capacity, hold, smoothness and order from the data, then the full fit.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/logs/cell_log.hpp"
#include "learn/identify/circuit/circuit_cost.hpp"
#include "learn/identify/fit/model_selection.hpp"
#include "learn/identify/fit/systematic_errors.hpp"
#include "learn/identify/fit/uncertainty.hpp"
#include "learn/identify/preparation/prepared_log.hpp"
#include "learn/identify/recording/holdout_blocks.hpp"
#include "learn/methods/stage_methods.hpp"

namespace voltlap::plant {

struct IdentifyOptions {
  int branches = 0;            ///< 1..3; 0: chosen by information criterion and held-out pulses, at most 2
  double per_kelvin = -0.014;  ///< [1/K] of resistances within one test; reference study, 2016, Table 7.2
  bool temperature_told = true;  ///< else a recording without rests has warmed by nobody knows how much
  double reference_temperature_c = 25.0;       ///< at which the tables hold
  std::vector<OcvKnowledge> ocv;               ///< from a slow test or another cell file; empty: from the rests
  std::optional<double> capacity_ah;           ///< known from another recording of the cell; empty: from these
  std::optional<double> capacity_fallback_ah;  ///< used when the recordings span clearly less
  std::optional<CurrentHold> hold;             ///< declared; empty: found in each recording
  InstrumentLimits instruments;                ///< what the intervals must cover beside noise
  double block_s = 0.0;                        ///< > 0: fit every other block of this length, predict the rest
  bool fit_even_blocks = true;
  bool constant = false;  ///< a plain circuit: one value of each resistance and time constant for all SOC
  std::optional<Method> method;  ///< of the reference study; empty: the full fit from its own start
  std::function<void(const std::string&)> progress;  ///< called with a line now and then; may be empty
};

/// A recording and the model's answer to it, row by row.
struct RecordingTrace {
  Eigen::VectorXd time_s, current_a, voltage_v, error_v, soc, weight_s;  ///< error: model less recorded
};

/// What was found out about one recording before the fit.
struct RecordingResult {
  std::string path, map;
  std::vector<std::string> repairs;
  CurrentHold hold = CurrentHold::kNext;
  std::string hold_from;  ///< counter, voltage, like the first file
  SocAnchor anchor;
  double soc_low = 0.0, soc_high = 1.0, duration_s = 0.0;
  double voltage_low_v = 0.0, voltage_high_v = 0.0;  ///< of the rows that the model follows
  Eigen::Index rows = 0;
  double rms_v = 0.0, rms_pulses_v = 0.0;  ///< of the fit: all rows; from the full charge on
  RecordingTrace trace{};
};

struct IdentifyResult {
  CircuitModel model;
  Uncertainty uncertainty;  ///< of the packed parameters, see CircuitCost
  Eigen::VectorXd packed;
  std::vector<RecordingResult> files;
  std::vector<OrderScore> orders;
  std::string smoothness_from;         ///< evidence, held-out pulses; --constant where too few are left out
  SmoothnessScores smoothness_scores;  ///< of held-out pulses
  double smoothness = 0.0, noise_v2_s = 0.0, hysteresis_v = 0.0;
  double rms_v = 0.0;  ///< of all rows that were used
  std::vector<SectionScore> sections;  ///< of a pulse or layered method its sections, of a full fit its recordings
  double noise_floor_v2 = 0.0;         ///< of the voltage's instrument, see noise_floor
  std::optional<double> rms_other_blocks_v;  ///< with block_s
  int iterations = 0;
  double seconds = 0.0;
  std::vector<std::string> notes;  ///< what a reader must know, in sentences
};

/// Recordings of one test that are ready for the fit: anchored, their holds chosen, what is known of the OCV collected.
/// Throws InputError when the recordings cannot carry a model: no current, no change of current, no known SOC.
struct IdentificationProblem {
  IdentificationProblem(const std::vector<CellLog>& recorded, const IdentifyOptions& given);
  IdentificationProblem(const IdentificationProblem&) = delete;  // `prepared` would point into the other's logs
  IdentificationProblem(IdentificationProblem&&) = default;
  /// `tau_centre_s`: time constants by branch that were found from these tests and others together; else they are
  /// looked for here.
  [[nodiscard]] IdentifyResult fit(const std::optional<Eigen::VectorXd>& tau_centre_s = {}) &&;
  [[nodiscard]] bool by_stage() const { return options.method && *options.method != Method::kFinalFull; }

  std::vector<CellLog> logs;
  IdentifyOptions options;
  std::vector<PreparedLog> prepared;  ///< point into `logs`
  std::vector<MeasuredRun> runs, everything;
  std::vector<std::vector<Block>> blocks;
  std::vector<OcvKnowledge> rests;
  FitPriors priors;
  IdentifyResult result;  ///< notes and hysteresis so far
};

/// Throws InputError as ReadyTests does.
[[nodiscard]] IdentifyResult identify(const std::vector<CellLog>& logs, const IdentifyOptions& options);

}  // namespace voltlap::plant
