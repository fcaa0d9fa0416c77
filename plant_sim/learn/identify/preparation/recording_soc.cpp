// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/recording_soc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/demand.hpp"
#include "core/signal.hpp"
#include "learn/identify/circuit/fitted_circuit.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

/// What is believed of a recording's SOC before the others are asked.
double offset_sigma(const SocAnchor& anchor) {
  constexpr double kFull = 0.005, kRest = 0.02, kUnknown = 0.05;
  if (anchor.from == "full charge") return kFull;
  return anchor.from.starts_with("rest") ? kRest : kUnknown;
}

/// How far a recording has been moved so far, and whether it may be moved on.
struct Moved {
  double offset = 0.0, scale = 1.0;
  double scale_sigma = 0.0;
  bool offset_free = true, scale_free = true;
};

std::vector<SocDoubt> doubts_of(const std::vector<PreparedLog>& prepared, const std::vector<Moved>& moved,
                                bool capacity_told) {
  constexpr double kCounters = 0.005, kAgeing = 0.03, kHeld = 1e-6;  // of a capacity
  std::vector<SocDoubt> out;
  for (std::size_t k = 0; k < prepared.size(); ++k) {
    const SocAnchor& anchor = prepared[k].run.anchor;
    const Moved& so_far = moved[k];
    out.push_back({anchor.soc, -so_far.offset, so_far.offset_free ? offset_sigma(anchor) : kHeld,
                   1.0 / so_far.scale - 1.0, so_far.scale_free ? (capacity_told ? kCounters : kAgeing) : kHeld});
  }
  return out;
}

TableFit fit_together(const std::vector<PreparedLog>& prepared, const std::vector<Moved>& moved, bool capacity_told,
                      FitPriors& priors) {
  const std::vector<MeasuredRun> runs = coarsened_where_many(runs_of(prepared));
  VOLTLAP_DEMAND(runs.size() == prepared.size());
  priors.soc_doubts = doubts_of(prepared, moved, capacity_told);
  return table_fit(runs, first_taus(2), priors);
}

/// Most recordings of a cell agree: only what is clearly off may be moved. One whose SOC a first model has guessed may
/// always. A capacity that is common to all is no difference.
void choose_moved(const std::vector<PreparedLog>& prepared, const TableFit& found, std::vector<Moved>& moved) {
  constexpr double kOffset = 0.005, kScale = 0.01, kSure = 2.0;
  const auto scale_at = [](std::size_t k) { return 2 * static_cast<Index>(k) + 1; };
  std::vector<double> scales;
  for (std::size_t k = 0; k < moved.size(); ++k) scales.push_back(found.doubts(scale_at(k)));
  const double common = median(scales);
  for (std::size_t k = 0; k < moved.size(); ++k) {
    const auto is_off = [&](double by, Index place, double worth) {
      return std::abs(by) > std::max(worth, kSure * found.doubts_sigma(place));
    };
    const Index offset = scale_at(k) - 1;
    moved[k].offset_free =
        prepared[k].run.anchor.from != "full charge" || is_off(found.doubts(offset), offset, kOffset);
    moved[k].scale_free = is_off(scales[k] - common, scale_at(k), kScale);
  }
}

/// One step of the recordings. Returns the largest [of SOC].
double move_together(std::vector<PreparedLog>& prepared, const TableFit& found, std::vector<Moved>& moved) {
  double most = 0.0;
  for (std::size_t k = 0; k < prepared.size(); ++k) {
    const auto at = 2 * static_cast<Index>(k);
    const double offset = found.doubts(at), scale = 1.0 + found.doubts(at + 1);
    prepared[k].run.anchor.soc += offset;
    prepared[k].run.capacity_ah /= scale;
    moved[k].offset += offset;
    moved[k].scale *= scale;
    moved[k].scale_sigma = found.doubts_sigma(at + 1);
    most = std::max({most, std::abs(offset), std::abs(scale - 1.0)});
  }
  return most;
}

/// What all have in common is no difference: the recording that drew most has the capacity that all had.
void keep_widest(std::vector<PreparedLog>& prepared, double common_ah) {
  std::size_t widest = 0;
  const auto drawn = [&](std::size_t k) { return moved_ah(*prepared[k].log, prepared[k].run.hold); };
  for (std::size_t k = 1; k < prepared.size(); ++k) {
    if (drawn(k) > drawn(widest)) widest = k;
  }
  const double factor = common_ah / prepared[widest].run.capacity_ah;
  for (PreparedLog& one : prepared) {
    one.run.capacity_ah *= factor;
    one.run.anchor.soc = 1.0 - (1.0 - one.run.anchor.soc) / factor;
  }
}

void note_differences(const std::vector<PreparedLog>& prepared, const std::vector<Moved>& moved, double cell_ah,
                      std::vector<std::string>& notes) {
  constexpr double kWorthIt = 0.015, kSure = 3.0, kPercent = 100.0;
  for (std::size_t k = 0; k < prepared.size(); ++k) {
    const double capacity_ah = prepared[k].run.capacity_ah, off = capacity_ah / cell_ah - 1.0;
    if (std::abs(off) < std::max(kWorthIt, kSure * moved[k].scale_sigma)) continue;
    notes.push_back(fmt::format(
        "{} agrees with the other recordings at a capacity of {:.3f} Ah ({:+.1f} %): its SOC is counted with that. A "
        "cell that aged between tests, or another counter.",
        std::filesystem::path(prepared[k].log->path).filename().string(), capacity_ah, kPercent * off));
  }
}

}  // namespace

double settle_soc(std::vector<PreparedLog>& prepared, FitPriors priors, bool capacity_told,
                  std::vector<std::string>& notes) {
  constexpr int kRounds = 4;
  constexpr double kStill = 2e-3;  // of SOC
  VOLTLAP_DEMAND(!prepared.empty());
  const double common_ah = prepared.front().run.capacity_ah;
  if (prepared.size() < 2) return common_ah;
  if (!priors.law_priors.fixed) priors.laws.exchange_a = std::exp(priors.law_priors.mean(ResistanceLaws::kLogExchange));
  std::vector<Moved> moved(prepared.size());
  choose_moved(prepared, fit_together(prepared, moved, capacity_told, priors), moved);
  for (int round = 0; round < kRounds; ++round) {
    if (move_together(prepared, fit_together(prepared, moved, capacity_told, priors), moved) < kStill) break;
  }
  if (capacity_told) return common_ah;
  keep_widest(prepared, common_ah);
  std::vector<double> capacities;
  for (const PreparedLog& one : prepared) capacities.push_back(one.run.capacity_ah);
  const double cell_ah = median(capacities);
  note_differences(prepared, moved, cell_ah, notes);
  return cell_ah;
}

}  // namespace voltlap::plant
