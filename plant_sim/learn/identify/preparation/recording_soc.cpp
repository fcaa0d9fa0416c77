// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/recording_soc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>

#include "core/demand.hpp"
#include "core/signal.hpp"
#include "learn/identify/circuit/fitted_circuit.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

bool is_full(const PreparedLog& one) { return one.run.anchor.from == "full charge"; }

/// What is believed of a recording's SOC at its anchor before the others are asked.
double offset_sigma(const SocAnchor& anchor) {
  constexpr double kFull = 0.01, kRest = 0.02, kUnknown = 0.05;
  if (anchor.from == "full charge") return kFull;
  return anchor.from.starts_with("rest") ? kRest : kUnknown;
}

/// How far a recording has been moved so far, and whether it may be moved on.
struct Moved {
  double offset = 0.0, scale = 1.0;
  double scale_sigma = 0.0;
  bool offset_free = true, scale_free = true;
};

/// The recordings on their way to where they agree.
class Agreement {
 public:
  Agreement(std::vector<PreparedLog>& prepared, FitPriors priors, bool capacity_told)
      : prepared_(prepared), priors_(std::move(priors)), capacity_told_(capacity_told), moved_(prepared.size()) {}

  /// False, and nothing is changed, where the recordings are followed no better for it.
  bool find() {
    constexpr int kRounds = 6;
    constexpr double kStill = 2e-3;  // of SOC
    hold_reference();
    double least = cost_as_they_stand();
    choose_moved(fit());
    if (std::none_of(moved_.begin(), moved_.end(), [](const Moved& m) { return m.offset_free || m.scale_free; }))
      return false;
    std::vector<PreparedLog> best = prepared_;
    std::vector<Moved> best_moved = moved_;
    bool any = false;
    for (int round = 0; round < kRounds; ++round) {
      const double size = move(fit()), cost = cost_as_they_stand();
      if (cost < least) {
        any = true;
        least = cost;
        best = prepared_;
        best_moved = moved_;
      }
      if (size < kStill) break;
    }
    prepared_ = std::move(best);
    moved_ = std::move(best_moved);
    return any;
  }
  [[nodiscard]] const std::vector<Moved>& moved() const { return moved_; }

 private:
  [[nodiscard]] std::vector<MeasuredRun> runs() const {
    std::vector<MeasuredRun> out = coarsened_where_many(runs_of(prepared_));
    VOLTLAP_DEMAND(out.size() == prepared_.size());
    return out;
  }
  [[nodiscard]] TableFit fit() {
    constexpr double kCounters = 0.005, kAgeing = 0.03, kHeld = 1e-6;  // of a capacity
    priors_.soc_doubts.clear();
    for (std::size_t k = 0; k < prepared_.size(); ++k) {
      const SocAnchor& anchor = prepared_[k].run.anchor;
      const Moved& so_far = moved_[k];
      priors_.soc_doubts.push_back({anchor.soc, -so_far.offset, so_far.offset_free ? offset_sigma(anchor) : kHeld,
                                    1.0 / so_far.scale - 1.0,
                                    so_far.scale_free ? (capacity_told_ ? kCounters : kAgeing) : kHeld});
    }
    TableFit found = table_fit(runs(), first_taus(2), priors_, last_ ? &*last_ : nullptr);
    last_ = found.fit.model;
    return found;
  }
  [[nodiscard]] double cost_as_they_stand() {
    priors_.soc_doubts.clear();
    return table_fit(runs(), first_taus(2), priors_, last_ ? &*last_ : nullptr).cost;
  }
  /// Most recordings of a cell agree: only one whose capacity is clearly off may be moved, one whose SOC a first model
  /// has guessed always. One that is full may lack a little: a charge in the cold ends before one at 25 degC. More than
  /// that is another fault, but for cells with hysteresis: on their plateau some per cent of the charge are missing
  /// without showing, and show at the ends.
  void choose_moved(const TableFit& found) {
    constexpr double kOffset = 0.005, kScale = 0.005, kSure = 3.0;
    constexpr double kMostOfFull = 0.03;  // three sigma of what is believed of a full charge
    const bool plateau = priors_.laws.has_hysteresis();
    const auto is_off = [&](Index at, double worth) {
      return std::abs(found.doubts(at)) > std::max(worth, kSure * found.doubts_sigma(at));
    };
    for (std::size_t k = 0; k < moved_.size(); ++k) {
      const auto at = 2 * static_cast<Index>(k);
      Moved& one = moved_[k];
      one.offset_free = one.offset_free && (!is_full(prepared_[k]) ||
                                            (is_off(at, kOffset) &&
                                             (plateau || std::abs(found.doubts(at)) < kMostOfFull)));
      one.scale_free = one.scale_free && is_off(at + 1, kScale);
    }
  }
  /// What is common to all bends no voltage: one is held, which is full and draws most.
  void hold_reference() {
    const auto drawn = [&](std::size_t k) {
      return moved_ah(*prepared_[k].log, prepared_[k].run.hold) * (is_full(prepared_[k]) ? 1.0 : 1e-3);
    };
    std::size_t reference = 0;
    for (std::size_t k = 1; k < moved_.size(); ++k) {
      if (drawn(k) > drawn(reference)) reference = k;
    }
    moved_[reference].scale_free = moved_[reference].offset_free = false;
  }
  void shift(const std::vector<PreparedLog>& from, const TableFit& found, double share) {
    for (std::size_t k = 0; k < prepared_.size(); ++k) {
      const auto at = 2 * static_cast<Index>(k);
      prepared_[k].run.anchor.soc = from[k].run.anchor.soc + share * found.doubts(at);
      prepared_[k].run.capacity_ah = from[k].run.capacity_ah / (1.0 + share * found.doubts(at + 1));
    }
  }
  /// One step, as much of it as lowers the errors of the tables that were found with it. Returns its size [of SOC].
  double move(const TableFit& found) {
    constexpr std::array kShares{1.0, 0.5, 0.25};
    const std::vector<PreparedLog> from = prepared_;
    double best = 0.0, least = 1e300;
    for (const double share : kShares) {
      shift(from, found, share);
      const std::vector<MeasuredRun> shifted = runs();
      const double square = mean_square(shifted, errors_of(found.fit, shifted));
      if (square >= least) continue;
      least = square;
      best = share;
    }
    shift(from, found, best);
    double most = 0.0;
    for (std::size_t k = 0; k < moved_.size(); ++k) {
      const auto at = 2 * static_cast<Index>(k);
      moved_[k].offset += best * found.doubts(at);
      moved_[k].scale *= 1.0 + best * found.doubts(at + 1);
      moved_[k].scale_sigma = found.doubts_sigma(at + 1);
      most = std::max({most, std::abs(best * found.doubts(at)), std::abs(best * found.doubts(at + 1))});
    }
    return most;
  }

  std::vector<PreparedLog>& prepared_;
  FitPriors priors_;
  bool capacity_told_;
  std::vector<Moved> moved_;
  std::optional<CircuitModel> last_;  ///< where the next fit begins
};

/// What all have in common bends no voltage: the fullest of those that are full stands at SOC 1, and where the capacity
/// is what was drawn the emptiest at 0.
void name_ends(std::vector<PreparedLog>& prepared, bool capacity_told) {
  double high = 0.0, low = 1.0;
  for (const PreparedLog& one : prepared) {
    if (is_full(one)) high = std::max(high, one.run.anchor.soc);
  }
  for (const MeasuredRun& run : runs_of(prepared)) low = std::min(low, run.soc.minCoeff());
  if (high == 0.0) high = 1.0;
  const CapacityFrom from = prepared.front().capacity.from;
  const bool is_span = from == CapacityFrom::kWholeDischarge || from == CapacityFrom::kWholeCharge ||
                       from == CapacityFrom::kDrawnOnly;
  const double bottom = capacity_told || !is_span ? high - 1.0 : low;
  for (PreparedLog& one : prepared) {
    one.run.anchor.soc = (one.run.anchor.soc - bottom) / (high - bottom);
    one.run.capacity_ah *= high - bottom;
  }
}

double capacity_of_all(const std::vector<PreparedLog>& prepared) {
  std::vector<double> capacities;
  for (const PreparedLog& one : prepared) capacities.push_back(one.run.capacity_ah);
  return median(std::move(capacities));
}

/// Those that are full first: where another one begins was guessed by a model of recordings that had not agreed yet.
void begin_with_full(std::vector<PreparedLog>& prepared, const FitPriors& priors, bool capacity_told) {
  std::vector<PreparedLog> full;
  for (const PreparedLog& one : prepared) {
    if (is_full(one)) full.push_back(one);
  }
  if (full.size() < 2 || full.size() == prepared.size()) return;
  if (!Agreement(full, priors, capacity_told).find()) return;
  const double middle_ah = capacity_of_all(full);
  auto next = full.begin();
  for (PreparedLog& one : prepared) {
    if (is_full(one)) {
      one = *next++;
      continue;
    }
    one.anchored = one.run.anchor.from == "assumed" || one.run.anchor.from == "rest and OCV";
    one.run.capacity_ah = middle_ah;
  }
  anchor_by_model(prepared, linear_fit(runs_of(full), first_taus(2), priors).model);
}

void note_differences(const std::vector<PreparedLog>& prepared, const std::vector<Moved>& moved, double cell_ah,
                      std::vector<std::string>& notes) {
  constexpr double kWorthIt = 0.015, kSure = 3.0, kPercent = 100.0;
  for (std::size_t k = 0; k < prepared.size(); ++k) {
    const double capacity_ah = prepared[k].run.capacity_ah, off = capacity_ah / cell_ah - 1.0;
    if (std::abs(off) < std::max(kWorthIt, kSure * moved[k].scale_sigma)) continue;
    notes.push_back(fmt::format(
        "{} agrees with the other recordings at a capacity of {:.3f} Ah ({:+.1f} %): its SOC is counted with that. The "
        "cold, a cell that aged between tests, or another counter.",
        std::filesystem::path(prepared[k].log->path).filename().string(), capacity_ah, kPercent * off));
  }
}

}  // namespace

SettledSoc settle_soc(std::vector<PreparedLog>& prepared, FitPriors priors, bool capacity_told,
                      std::vector<std::string>& notes) {
  VOLTLAP_DEMAND(!prepared.empty());
  constexpr double kSaid = 0.002;  // of a capacity
  const double common_ah = prepared.front().run.capacity_ah;
  if (prepared.size() < 2) return {common_ah, false};
  if (!priors.law_priors.fixed) priors.laws.exchange_a = std::exp(priors.law_priors.mean(ResistanceLaws::kLogExchange));
  begin_with_full(prepared, priors, capacity_told);
  Agreement agreement(prepared, std::move(priors), capacity_told);
  if (!agreement.find() && capacity_of_all(prepared) == common_ah) return {common_ah, false};
  name_ends(prepared, capacity_told);
  if (capacity_told) return {common_ah, true};
  const double cell_ah = capacity_of_all(prepared);
  if (std::abs(cell_ah / common_ah - 1.0) > kSaid) {
    notes.push_back(fmt::format(
        "Together the recordings agree best on a capacity of {:.3f} Ah: the cell's is that, not {:.3f}.", cell_ah,
        common_ah));
  }
  note_differences(prepared, agreement.moved(), cell_ah, notes);
  return {cell_ah, true};
}

}  // namespace voltlap::plant
