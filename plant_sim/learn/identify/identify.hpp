// SPDX-License-Identifier: Apache-2.0
// From recordings of a cell to its model: capacity, hold, smoothness and order from the data, then the full fit.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "car/battery/cell_thermal.hpp"
#include "io/logs/cell_log.hpp"
#include "learn/identify/fit/full_fit.hpp"
#include "learn/identify/fit/recording_result.hpp"
#include "learn/identify/fit/systematic_errors.hpp"
#include "learn/identify/preparation/first_estimates.hpp"
#include "learn/identify/preparation/prepared_log.hpp"
#include "learn/identify/recording/holdout_blocks.hpp"
#include "learn/methods/stage_methods.hpp"

namespace voltlap::plant {

struct IdentifyOptions {
  int branches = 0;            ///< 1..4; 0: chosen by held-out pulses
  std::vector<double> temperatures_c;  ///< of the recordings that have none of their own, one each; empty: 25 degC
  bool temperature_told = true;  ///< else a recording without rests has warmed by nobody knows how much
  double reference_temperature_c = 25.0;       ///< at which the tables hold
  std::vector<OcvKnowledge> ocv;               ///< from a slow test or another cell file; empty: from the rests
  std::optional<double> capacity_ah;           ///< known from another recording of the cell; empty: from these
  std::optional<double> capacity_fallback_ah;  ///< used when the recordings span clearly less
  std::optional<CurrentHold> hold;             ///< declared; empty: found in each recording
  InstrumentLimits instruments;                ///< what the intervals must cover beside noise
  double block_s = 0.0;                        ///< > 0: fit every other block of this length, predict the rest
  bool fit_even_blocks = true;
  /// Tests at several temperatures and currents: one table with laws, or a table for each test.
  enum class Tables { kByLaws, kByTest } tables = Tables::kByLaws;
  /// What keeps and sheds the heat of a cell of a capacity; empty: without a temperature it is held at its own.
  std::function<CellThermal(double capacity_ah)> thermal;
  bool agree_soc = true;  ///< recordings whose charge does not agree are moved until it does
  /// Slow charge and slow discharge that are more than so many steps of the resistance apart are so by hysteresis.
  double hysteresis_steps = kWholeOverStep;
  bool constant = false;  ///< a plain circuit: one value of each resistance and time constant for all SOC
  std::optional<Method> method;  ///< of the reference study; empty: the full fit from its own start
  std::function<void(const std::string&)> progress;  ///< called with a line now and then; may be empty
};

struct IdentifyResult {
  CircuitModel model;
  std::optional<CircuitModel> plain;  ///< whose OCV goes on where the model's was not driven
  Uncertainty uncertainty;  ///< of the packed parameters, see CircuitResiduals
  Eigen::VectorXd packed;
  std::vector<RecordingResult> files;
  std::vector<OrderScore> orders;
  std::string smoothness_from;         ///< evidence, held-out pulses; --constant where too few are left out
  SmoothnessScores smoothness_scores;  ///< of held-out pulses
  Capacity capacity;  ///< and where it is from
  double smoothness = 0.0, noise_v2_s = 0.0, hysteresis_v = 0.0;
  bool hysteresis_in_doubt = false;  ///< slow charge and discharge may stand apart by one, or by slow branches
  bool soc_moved = false;     ///< for recordings to agree, which count or begin otherwise
  bool laws_assumed = false;  ///< what changes with temperature is what is believed of cells, not what was recorded
  double rms_v = 0.0;  ///< of all rows that were used
  std::vector<SectionScore> sections;  ///< of a pulse or layered method its sections, of a full fit its recordings
  double noise_floor_v2 = 0.0;         ///< of the voltage's instrument, see noise_floor
  std::optional<double> rms_other_blocks_v;  ///< with block_s
  int iterations = 0;
  double seconds = 0.0;
  std::vector<std::string> notes;  ///< what a reader must know, in sentences
};

/// Recordings of one operating point, ready for the fit: anchored, their holds chosen, what is known of the OCV
/// collected. Throws InputError when the recordings cannot carry a model: no current, no change of current, no known
/// SOC.
struct IdentificationProblem {
  IdentificationProblem(const std::vector<CellLog>& recorded, const IdentifyOptions& given);
  IdentificationProblem(const IdentificationProblem&) = delete;  // `prepared` would point into the other's logs
  IdentificationProblem(IdentificationProblem&&) = default;
  /// `tau_centre_s`: time constants by branch that were found from these recordings and others together; else they are
  /// looked for here.
  [[nodiscard]] IdentifyResult fit(const std::optional<Eigen::VectorXd>& tau_centre_s = {}) &&;
  [[nodiscard]] bool by_stage() const { return options.method && *options.method != Method::kFinalFull; }

  std::vector<CellLog> logs;
  IdentifyOptions options;
  std::vector<PreparedLog> prepared;  ///< point into `logs`
  std::vector<MeasuredRun> runs, everything;
  std::vector<std::vector<Block>> blocks;
  double capacity_ah = 0.0;  ///< of the cell; a recording may have one of its own
  std::vector<OcvKnowledge> rests;
  FitPriors priors;
  bool one_temperature = false;  ///< of all recordings
  IdentifyResult result;  ///< notes and hysteresis so far

 private:
  void make_runs();
  [[nodiscard]] std::vector<std::string> settle_recordings();  ///< why some were left out
  [[nodiscard]] std::vector<MeasuredRun> weighed_runs() const;
  void drop_slope_of_warmed_cell();
  void estimate_temperatures();
  [[nodiscard]] double temperature_spread() const;
  void assume_laws_of_one_temperature();
  double estimate_temperatures_by(const CircuitModel& model);
  void note_warming();
  void collect_rests();
  void hold_out_blocks();
  void widen_intervals(const FullFit& full);
  [[nodiscard]] double rms_of_held_out_blocks(const FullFit& full) const;
};

/// Throws InputError as IdentificationProblem does.
[[nodiscard]] IdentifyResult identify(const std::vector<CellLog>& logs, const IdentifyOptions& options);

}  // namespace voltlap::plant
