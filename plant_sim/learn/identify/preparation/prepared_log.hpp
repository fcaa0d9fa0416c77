// SPDX-License-Identifier: Apache-2.0
// What a recording tells before any fit: where it is full, how much charge it spans, how its current is held.
#pragma once
#include <optional>
#include <vector>

#include "learn/identify/circuit/circuit_fit.hpp"
#include "learn/identify/preparation/capacity.hpp"
#include "learn/identify/recording/measured_run.hpp"

namespace voltlap::plant {

/// One recording with what is known of it.
struct PreparedLog {
  const CellLog* log;
  RunOptions run;
  std::string hold_from;     ///< counter, voltage, like the first file
  bool anchored = false;     ///< SOC is known without a model
  std::optional<SocAnchor> full_in_doubt{};  ///< another recording stands higher where it is full
  bool hold_certain = true;  ///< false: the recording cannot tell, and the first candidate was taken
  bool temperature_estimated = false;  ///< by the heat that it makes and an assumed body
  Capacity capacity{};       ///< the same for all recordings of a cell
};

/// What is known of the cell before its recordings are read.
struct PriorKnowledge {
  std::optional<double> capacity_ah;           ///< certain
  /// Of the cell that the OCV is of: used when the recordings span less than nine tenths of it and no two rests tell.
  std::optional<double> capacity_fallback_ah;
  std::vector<double> temperatures_c;  ///< told, one a recording; empty: 25 degC
  std::optional<CurrentHold> hold;  ///< declared; else it is found
  std::vector<OcvKnowledge> ocv{};  ///< from a slow test or another cell file; empty: unknown
};

/// Throws InputError for recordings that are too short to identify anything from, with their numbers.
void require_enough_rows(const std::vector<CellLog>& logs);

/// Capacity, anchors and holds. Throws InputError when there is no current in a recording, or it never changes.
[[nodiscard]] std::vector<PreparedLog> prepare(const std::vector<CellLog>& logs, const PriorKnowledge& known,
                                               std::vector<std::string>& notes);

/// A recording that was full in doubt is so where the model that gave it a SOC puts it near the top, or on a plateau
/// that tells nothing.
void settle_full_in_doubt(std::vector<PreparedLog>& prepared, const CircuitModel& model);

/// Charge from a row to the lowest point after it.
[[nodiscard]] double span_ah(const CellLog& log, std::size_t from, CurrentHold hold);
/// What is put back up to a row from the lowest point before it.
[[nodiscard]] double put_back_ah(const CellLog& log, std::size_t to, CurrentHold hold);
/// The larger of both: a recording may end where it is full.
[[nodiscard]] double counted_ah(const CellLog& log, std::size_t anchor, CurrentHold hold);

/// Gives the recordings that `prepare` could not anchor a SOC: from their first rest by the model's OCV, else the
/// one at which the model predicts them best.
void anchor_by_model(std::vector<PreparedLog>& prepared, const CircuitModel& model, double shortest_rest_s = 240.0);

/// Runs of the recordings that are anchored, steady rows averaged unless every row is wanted.
[[nodiscard]] std::vector<MeasuredRun> runs_of(const std::vector<PreparedLog>& prepared, bool every_row = false);

}  // namespace voltlap::plant
