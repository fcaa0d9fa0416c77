// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/capacity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/demand.hpp"
#include "learn/identify/preparation/first_estimates.hpp"

namespace voltlap::plant {
namespace {

/// Voltages at rest of full cells: NMC, NCA, LMO and LCO; LFP, whose plateau ends below 3.34 V; LTO.
bool is_full_voltage(double v) { return v >= 4.12 || (v >= 3.345 && v <= 3.75) || (v >= 2.5 && v <= 2.9); }

/// A known OCV by SOC.
class KnownOcv {
 public:
  explicit KnownOcv(std::vector<OcvKnowledge> points) : points_(std::move(points)) {
    std::sort(points_.begin(), points_.end(), [](const auto& a, const auto& b) { return a.soc < b.soc; });
  }

  struct Place {
    double soc, sigma;
  };
  /// Where it has a voltage, and how well that voltage tells it. None outside of it, and where it is flat.
  [[nodiscard]] std::optional<Place> place_of(double voltage_v, double sigma_v) const {
    constexpr double kLeastSlope = 0.05;  // V
    for (std::size_t k = 1; k < points_.size(); ++k) {
      const OcvKnowledge &low = points_[k - 1], &high = points_[k];
      if (voltage_v < low.voltage_v || voltage_v > high.voltage_v || !(high.soc > low.soc)) continue;
      const double slope = (high.voltage_v - low.voltage_v) / (high.soc - low.soc);
      if (slope < kLeastSlope) return std::nullopt;
      const double sigma = std::hypot(sigma_v, std::max(low.sigma_v, high.sigma_v));
      return Place{low.soc + (voltage_v - low.voltage_v) / slope, sigma / slope};
    }
    return std::nullopt;
  }

 private:
  std::vector<OcvKnowledge> points_;
};

/// Rests of a recording with the charge drawn before their end in place of the SOC [Ah], negative.
std::vector<OcvKnowledge> rests_by_charge(const CellLog& log, CurrentHold hold) {
  constexpr double kShortest = 60.0;  // s; what the voltage still has to go is in the rest's sigma
  RunOptions options;
  options.hold = hold;
  options.capacity_ah = 1.0;
  options.anchor = {0, 0.0, "charge"};
  return ocv_from_rests(make_run(log, options), kShortest);
}

/// V + I R0, so that a high current does not look like an empty cell.
double unloaded_v(const CellLog& log, std::size_t row, double r0_ohm) {
  return log.voltage_v[row] + r0_ohm * log.current_a[row];
}

}  // namespace

std::string_view name_of(CapacityFrom from) {
  switch (from) {
    case CapacityFrom::kTold:
      return "told";
    case CapacityFrom::kGivenCell:
      return "given cell";
    case CapacityFrom::kWholeDischarge:
      return "whole discharge";
    case CapacityFrom::kWholeCharge:
      return "whole charge";
    case CapacityFrom::kRestsAndOcv:
      return "rests and OCV";
    default:
      return "drawn only";
  }
}

std::string capacity_note(const Capacity& capacity, double moved_ah) {
  switch (capacity.from) {
    case CapacityFrom::kTold:
      return fmt::format("Capacity {:.3f} Ah, as known; these recordings span {:.3f} Ah.", capacity.ah, moved_ah);
    case CapacityFrom::kGivenCell:
      return fmt::format("The recordings span {:.3f} Ah; the capacity of {:.3f} Ah is the given cell's.", moved_ah,
                         capacity.ah);
    case CapacityFrom::kWholeDischarge:
      return fmt::format("Capacity {:.3f} Ah: what the longest discharge draws after SOC 1; SOC 0 is its end.",
                         capacity.ah);
    case CapacityFrom::kWholeCharge:
      return fmt::format("Capacity {:.3f} Ah: what the charge to SOC 1 puts back; SOC 0 is its beginning.",
                         capacity.ah);
    case CapacityFrom::kRestsAndOcv:
      return fmt::format("Capacity {:.3f} +- {:.3f} Ah (95 %): the charge between two rests over their SOC by the "
                         "given OCV; these recordings span {:.3f} Ah.",
                         capacity.ah, capacity.ci95_ah.value_or(0.0), moved_ah);
    default:
      return fmt::format(
          "Capacity unknown: {:.3f} Ah is only what the recordings drew; nothing says that they went from a full cell "
          "to an empty one. The cell may hold more; SOC counts in this charge. --capacity AH gives the true one; --ocv "
          "with rests at both ends estimates it.",
          capacity.ah);
  }
}

std::string capacity_source(const Capacity& capacity) {
  switch (capacity.from) {
    case CapacityFrom::kTold:
      return "--capacity";
    case CapacityFrom::kGivenCell:
      return "that of the cell given with --ocv";
    case CapacityFrom::kWholeDischarge:
      return "identified, of a whole discharge";
    case CapacityFrom::kWholeCharge:
      return "identified, of a whole charge";
    case CapacityFrom::kRestsAndOcv:
      return fmt::format("identified, of two rests and the OCV, +- {:.3g} Ah at 95 %", capacity.ci95_ah.value_or(0.0));
    default:
      return "only what was drawn, the cell may hold more: --capacity AH";
  }
}

bool ends_undriven(const std::vector<MeasuredRun>& runs, const Capacity& capacity) {
  constexpr double kEnd = 0.05;  // of SOC
  double low = 1.0, high = 0.0;
  for (const MeasuredRun& run : runs) {
    low = std::min(low, run.soc.minCoeff());
    high = std::max(high, run.soc.maxCoeff());
  }
  return capacity.is_lower_bound() || low > kEnd || high < 1.0 - kEnd;
}

double moved_ah(const CellLog& log, CurrentHold hold) {
  const std::vector<double> drawn = charge_drawn_ah(log, hold);
  VOLTLAP_DEMAND(!drawn.empty());
  const auto [low, high] = std::minmax_element(drawn.begin(), drawn.end());
  return *high - *low;
}

namespace {

/// Voltage after ten minutes of rest from a row on; 0 where there is no such rest.
double rested_v(const CellLog& log, const std::vector<bool>& resting, std::size_t row) {
  constexpr double kRested = 600.0;  // s
  const double begin = log.time_s[row];
  for (std::size_t at = row + 1; at < log.rows() && resting[at] && !log.gap[at]; ++at) {
    if (log.time_s[at] - begin >= kRested && std::isfinite(log.voltage_v[at])) return log.voltage_v[at];
  }
  return 0.0;
}

}  // namespace

std::vector<std::size_t> possible_full_rows(const CellLog& log) {
  constexpr double kFullBand = 0.04;  // V, of the highest that rests
  constexpr double kDrift = 0.1;  // of what was moved: a counter's drift over weeks of cycles, and losses
  std::vector<std::size_t> rows = full_charges(log);
  const std::vector<double> drawn = charge_drawn_ah(log, CurrentHold::kLinear);
  const std::vector<bool> resting = resting_rows(log);
  double rest_high_v = 0.0;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (resting[row] && std::isfinite(log.voltage_v[row])) rest_high_v = std::max(rest_high_v, log.voltage_v[row]);
  }
  std::erase_if(rows, [&](std::size_t full) {
    // It rests as high as any: full, whatever the counter has lost.
    if (rested_v(log, resting, full) > rest_high_v - kFullBand) return false;
    std::size_t first = full, last = full;
    while (first > 0 && !log.gap[first]) --first;
    while (last + 1 < log.rows() && !log.gap[last + 1]) ++last;
    const auto [low, high] = std::minmax_element(drawn.begin() + static_cast<std::ptrdiff_t>(first),
                                                 drawn.begin() + static_cast<std::ptrdiff_t>(last) + 1);
    return drawn[full] - *low > kDrift * (*high - *low);
  });
  return rows;
}

RecordedEnds recorded_ends(const CellLog& log, const RunOptions& options) {
  // Of the full voltage: an NCA cell has 3.3 V at a tenth of its charge, an NMC cell 3.45; of the charge that moved.
  constexpr double kEmpty = 0.79, kNear = 0.005;
  const std::vector<double> drawn = charge_drawn_ah(log, options.hold);
  const double r0 = resistance_step_median({make_run(log, options)});
  const auto [low, high] = std::minmax_element(drawn.begin(), drawn.end());
  const double near = kNear * (*high - *low), nothing = std::numeric_limits<double>::infinity();
  double full_v = 0.0, empty_v = nothing;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (!std::isfinite(log.voltage_v[row])) continue;
    const double v = unloaded_v(log, row, r0);
    if (drawn[row] <= *low + near) full_v = std::max(full_v, v);
    if (drawn[row] >= *high - near) empty_v = std::min(empty_v, v);
  }
  const bool charged = std::any_of(options.full_rows.begin(), options.full_rows.end(),
                                   [](std::size_t row) { return row > 0; });
  return {charged || is_full_voltage(full_v), empty_v <= kEmpty * full_v};
}

std::optional<CapacityOfRests> capacity_of_rests(const CellLog& log, CurrentHold hold,
                                                 const std::vector<OcvKnowledge>& ocv) {
  constexpr double kLeastSoc = 0.1, kWidest = 0.25;
  if (std::find(log.gap.begin(), log.gap.end(), true) != log.gap.end() && log.charge_ah.empty()) return std::nullopt;
  const KnownOcv known(ocv);
  const std::vector<OcvKnowledge> rests = rests_by_charge(log, hold);
  std::optional<CapacityOfRests> best;
  for (const OcvKnowledge& first : rests) {
    const auto from = known.place_of(first.voltage_v, first.sigma_v);
    for (const OcvKnowledge& later : rests) {
      const auto to = known.place_of(later.voltage_v, later.sigma_v);
      const double charge = first.soc - later.soc;
      if (!from || !to || !(charge > 0.0) || from->soc - to->soc < kLeastSoc) continue;
      const double ah = charge / (from->soc - to->soc);
      const double ci95 = 1.96 * ah * std::hypot(from->sigma, to->sigma) / (from->soc - to->soc);
      if (ci95 > kWidest * ah || (best && ci95 / ah >= *best->capacity.ci95_ah / best->capacity.ah)) continue;
      best = CapacityOfRests{{ah, CapacityFrom::kRestsAndOcv, ci95}, from->soc - first.soc / ah};
    }
  }
  return best;
}

std::optional<double> soc_by_first_rest(const CellLog& log, const RunOptions& options,
                                        const std::vector<OcvKnowledge>& ocv) {
  VOLTLAP_DEMAND(options.capacity_ah > 0.0);
  const KnownOcv known(ocv);
  for (const OcvKnowledge& rest : rests_by_charge(log, options.hold)) {
    if (const auto place = known.place_of(rest.voltage_v, rest.sigma_v))
      return place->soc - rest.soc / options.capacity_ah;
  }
  return std::nullopt;
}

}  // namespace voltlap::plant
