// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/contradictions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "core/demand.hpp"
#include "learn/identify/circuit/fitted_circuit.hpp"
#include "learn/identify/preparation/steep_ends.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

double rms_of(const MeasuredRun& run, const Eigen::VectorXd& error) {
  const double weight = run.weight_s.sum();
  return weight > 0.0 ? std::sqrt(run.weight_s.dot(error.cwiseAbs2()) / weight) : 0.0;
}

std::vector<double> rms_of_each(const std::vector<MeasuredRun>& runs, const FittedCircuit& fit) {
  const auto errors = errors_of(fit, runs);
  std::vector<double> out;
  for (std::size_t k = 0; k < runs.size(); ++k) out.push_back(rms_of(runs[k], errors[k]));
  return out;
}

/// RMS of each run under one quick fit of all of them, with the laws as they are assumed [V].
std::vector<double> rms_of_fit(const std::vector<MeasuredRun>& runs, const FitPriors& priors) {
  return rms_of_each(runs, linear_fit(runs, first_taus(2), priors));
}

/// The same with time constants and laws free, charge transfer and all: what other temperatures and rates do is no
/// contradiction.
std::vector<double> rms_of_free_fit(const std::vector<MeasuredRun>& runs, FitPriors priors) {
  if (!priors.law_priors.fixed) priors.laws.exchange_a = std::exp(priors.law_priors.mean(ResistanceLaws::kLogExchange));
  return rms_of_each(runs, table_fit(runs, first_taus(2), priors).fit);
}

/// Steps of the current by more than a tenth of the largest of all recordings.
Index steps_of(const MeasuredRun& run, double most_a) {
  constexpr double kStep = 0.1;
  Index steps = 0;
  for (Index row = 1; row < run.rows(); ++row)
    steps += std::abs(run.current_a(row) - run.current_a(row - 1)) > kStep * most_a ? 1 : 0;
  return steps;
}

struct Contradiction {
  std::size_t recording = 0;
  double with_v = 0.0, without_v = 0.0;  ///< the others' mean RMS
  double gain = 0.0;                     ///< mean logarithm of their ratios
};

std::vector<MeasuredRun> without_one(const std::vector<MeasuredRun>& runs, std::size_t left_out) {
  std::vector<MeasuredRun> others = runs;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
  return others;
}

/// What leaving one recording out does for the others: RMS of all with it, and of the others without.
Contradiction compared(std::size_t left_out, const std::vector<double>& with, const std::vector<double>& alone) {
  constexpr double kFloor = 1e-3;  // V: what no quick fit tells
  Contradiction out{left_out};
  const auto count = static_cast<double>(alone.size());
  for (std::size_t k = 0; k < alone.size(); ++k) {
    const double before = with[k < left_out ? k : k + 1];
    out.with_v += before / count;
    out.without_v += alone[k] / count;
    out.gain += std::log((before + kFloor) / (alone[k] + kFloor)) / count;
  }
  return out;
}

/// A circuit leaves some mV of what any two recordings differ by, and of two alone each fits itself.
bool counts(const Contradiction& one, std::size_t recordings) {
  constexpr double kGain = 1.1, kLeast = 0.015, kLeastOfTwo = 0.04;  // a factor of three; V
  return one.gain > kGain && one.with_v - one.without_v > (recordings > 2 ? kLeast : kLeastOfTwo);
}

std::optional<Contradiction> worst_of(const std::vector<MeasuredRun>& runs, const FitPriors& priors) {
  const std::vector<double> with = rms_of_fit(runs, priors);
  VOLTLAP_DEMAND(with.size() == runs.size());
  std::optional<Contradiction> worst;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const Contradiction one = compared(k, with, rms_of_fit(without_one(runs, k), priors));
    if (counts(one, runs.size()) && (!worst || one.gain > worst->gain)) worst = one;
  }
  if (!worst) return worst;
  worst = compared(worst->recording, rms_of_free_fit(runs, priors),
                   rms_of_free_fit(without_one(runs, worst->recording), priors));
  if (!counts(*worst, runs.size())) return std::nullopt;
  if (runs.size() > 2) return worst;
  // Of two recordings each is better off without the other.
  double most = 0.0;
  for (const MeasuredRun& run : runs) most = std::max(most, run.current_a.cwiseAbs().maxCoeff());
  const std::size_t fewer = steps_of(runs[0], most) < steps_of(runs[1], most) ? 0 : 1;
  return fewer == worst->recording
             ? worst
             : std::optional(compared(fewer, rms_of_free_fit(runs, priors),
                                      rms_of_free_fit(without_one(runs, fewer), priors)));
}

}  // namespace

bool leave_out_contradictions(std::vector<PreparedLog>& prepared, const FitPriors& priors,
                              std::vector<std::string>& notes) {
  bool any = false;
  while (prepared.size() > 1) {
    std::vector<MeasuredRun> runs = coarsened_where_many(runs_of(prepared));
    VOLTLAP_DEMAND(runs.size() == prepared.size());
    discount_steep_ends(runs, priors);
    const std::optional<Contradiction> worst = worst_of(runs, priors);
    if (!worst) return any;
    any = true;
    notes.push_back(fmt::format(
        "{} contradicts the other recordings and is left out: with it they are followed within {:.1f} mV, without it "
        "within {:.1f} mV. Another cell, a voltage that was measured behind a cable or contact, a wrong unit or count?",
        std::filesystem::path(prepared[worst->recording].log->path).filename().string(), 1e3 * worst->with_v,
        1e3 * worst->without_v));
    prepared.erase(prepared.begin() + static_cast<std::ptrdiff_t>(worst->recording));
  }
  return any;
}

void forget_left_out(std::vector<PreparedLog>& prepared, std::vector<CellLog>& logs,
                     std::vector<double>& temperatures_c) {
  std::vector<CellLog> kept;
  std::vector<double> kept_c;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    const auto is_of = [&](const PreparedLog& one) { return one.log == &logs[k]; };
    if (std::none_of(prepared.begin(), prepared.end(), is_of)) continue;
    if (k < temperatures_c.size()) kept_c.push_back(temperatures_c[k]);
    kept.push_back(std::move(logs[k]));
  }
  prepared.clear();
  logs = std::move(kept);
  temperatures_c = std::move(kept_c);
}

}  // namespace voltlap::plant
