// SPDX-License-Identifier: Apache-2.0
// The capacity that a model's SOC is counted with, and how much of it is known: a whole discharge tells it, a drive
// tells only what it drew.
//
//   C = (Q2 - Q1) / (s1 - s2)            between two rests, s by a known OCV
//   sigma_C = C sqrt(sigma_s1^2 + sigma_s2^2) / (s1 - s2),   sigma_s = sqrt(sigma_rest^2 + sigma_ocv^2) / (dOCV/ds)
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "learn/identify/circuit/circuit_fit.hpp"
#include "learn/identify/recording/measured_run.hpp"

namespace voltlap::plant {

enum class CapacityFrom { kTold, kGivenCell, kWholeDischarge, kWholeCharge, kRestsAndOcv, kDrawnOnly };
/// "told", "given cell", "whole discharge", "whole charge", "rests and OCV", "drawn only".
[[nodiscard]] std::string_view name_of(CapacityFrom from);

struct Capacity {
  double ah = 0.0;
  CapacityFrom from = CapacityFrom::kWholeDischarge;
  std::optional<double> ci95_ah{};  ///< half width at 95 %, where it was estimated
  /// The cell holds more, nobody knows how much.
  [[nodiscard]] bool is_lower_bound() const { return from == CapacityFrom::kDrawnOnly; }
};

/// A capacity in a sentence. `moved_ah`: between the fullest and the emptiest row of the recordings.
[[nodiscard]] std::string capacity_note(const Capacity& capacity, double moved_ah);
/// Where it is from, in a few words, for a table of facts.
[[nodiscard]] std::string capacity_source(const Capacity& capacity);

/// Is there charge that no recording passed, or of which nobody knows how much there is?
[[nodiscard]] bool ends_undriven(const std::vector<MeasuredRun>& runs, const Capacity& capacity);

/// Charge between the fullest and the emptiest row [Ah].
[[nodiscard]] double moved_ah(const CellLog& log, CurrentHold hold);

/// Rows at which a recording says "full", without those that cannot be: at which much more had been drawn than at
/// another row that nothing unrecorded lies between.
[[nodiscard]] std::vector<std::size_t> possible_full_rows(const CellLog& log);

/// What a recording says of its own ends: a voltage at which cells are full, or a charge that ended at the highest
/// voltage; a voltage, with the drop of R0 added, that no cell has above a tenth of its charge.
struct RecordedEnds {
  bool full = false, empty = false;
};
[[nodiscard]] RecordedEnds recorded_ends(const CellLog& log, const RunOptions& options);

/// What two rests and a known OCV say: capacity, and the SOC of row 0. None where they are too near each other, or
/// where the interval is wider than a quarter of the capacity.
struct CapacityOfRests {
  Capacity capacity;
  double soc_at_first_row = 1.0;
};
[[nodiscard]] std::optional<CapacityOfRests> capacity_of_rests(const CellLog& log, CurrentHold hold,
                                                               const std::vector<OcvKnowledge>& ocv);
/// SOC at row 0 by the first rest and a known OCV, for a capacity that is known. None without a rest.
[[nodiscard]] std::optional<double> soc_by_first_rest(const CellLog& log, const RunOptions& options,
                                                      const std::vector<OcvKnowledge>& ocv);

}  // namespace voltlap::plant
