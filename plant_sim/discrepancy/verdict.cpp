// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/verdict.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Members = std::vector<std::size_t>;

constexpr double kSmallDifference = 0.3;  // between the halves of a log, of the larger

bool contains(const Members& whole, const Members& part) {
  return std::includes(whole.begin(), whole.end(), part.begin(), part.end());
}

/// The smallest set that is not clearly worse than the best.
std::size_t sized_down(const std::vector<WeighedSet>& sets, double larger) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < sets.size(); ++k) {
    if (sets[0].evidence - sets[k].evidence > larger) break;
    if (sets[k].members.size() < sets[best].members.size() && contains(sets[0].members, sets[k].members)) best = k;
  }
  return best;
}

/// The one member in which two sets of equal size differ: its place in `a`, and the other in `b`.
std::optional<std::pair<std::size_t, std::size_t>> one_difference(const Members& a, const Members& b) {
  if (a.size() != b.size()) return std::nullopt;
  Members only_a, only_b;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(only_a));
  std::set_difference(b.begin(), b.end(), a.begin(), a.end(), std::back_inserter(only_b));
  if (only_a.size() != 1) return std::nullopt;
  return std::pair{static_cast<std::size_t>(std::find(a.begin(), a.end(), only_a[0]) - a.begin()), only_b[0]};
}

bool same_names(const System& system, const Members& a, const Members& b) {
  if (a.size() != b.size()) return false;
  return std::all_of(a.begin(), a.end(), [&](std::size_t x) {
    return std::any_of(b.begin(), b.end(), [&](std::size_t y) { return x == y || same_name(system, x, y); });
  });
}

}  // namespace

bool is_of_all_cells(const System& system, const Members& members) {
  return std::any_of(members.begin(), members.end(), [&](std::size_t m) { return system.candidates[m].of_all_cells; });
}

bool same_name(const System& system, std::size_t a, std::size_t b) {
  const Candidate &x = system.candidates[a], &y = system.candidates[b];
  return x.cause >= 0 && x.cause == y.cause && x.channel == y.channel;
}

Decision decide(const System& system, const std::vector<WeighedSet>& sets, int draws, std::uint64_t seed) {
  Decision out;
  if (sets.empty() || sets[0].evidence <= 0.0) return out;
  const double freedom = is_of_all_cells(system, sets[0].members) ? kFreedomOfCells : kFreedom;
  const double null = null_probability(system, sets[0].evidence, freedom, draws, seed, kNullLevel);
  if (null <= kNullLevel) out = choose(system, sets);
  out.null_probability = null;
  return out;
}

Decision choose(const System& system, const std::vector<WeighedSet>& sets, double larger) {
  Decision out;
  std::size_t chosen = sized_down(sets, larger);
  // A shape without a name that is no better than names of the same class gives way to them.
  for (std::size_t k = 0; !sets[chosen].named && k < sets.size(); ++k) {
    if (sets[chosen].evidence - sets[k].evidence > kDecisive) break;
    if (!sets[k].named || sets[k].members.size() > sets[chosen].members.size()) continue;
    const SetFit fit = fit_set(system, sets[chosen].members);
    if (overlap(system, sets[chosen].members, fit.coefficients, sets[k].members) > kSameClass) chosen = k;
  }
  out.members = sets[chosen].members;
  out.anonymous = !sets[chosen].named;
  out.equivalents.resize(out.members.size());
  const SetFit fit = fit_set(system, out.members);
  out.margin = sets[chosen].evidence;  // to nothing at all
  bool decided = false;
  for (std::size_t k = 0; k < sets.size(); ++k) {
    const WeighedSet& rival = sets[k];
    const double behind = sets[chosen].evidence - rival.evidence;
    if (k == chosen || contains(rival.members, out.members) || same_names(system, rival.members, out.members)) {
      if (contains(rival.members, out.members) && k != chosen) out.next_gain = std::max(out.next_gain, -behind);
      continue;
    }
    const bool same_class = overlap(system, out.members, fit.coefficients, rival.members) > kSameClass;
    if (same_class) {
      const auto difference = one_difference(out.members, rival.members);
      if (difference && behind < kDecisive && system.candidates[difference->second].cause >= 0) {
        out.equivalents[difference->first].push_back(difference->second);
      }
      if (difference || !rival.named || rival.members.size() > out.members.size()) continue;
    }
    if (!decided) {
      out.margin = std::min(out.margin, behind);
      decided = true;
    }
    if (behind > 2.0 * kDecisive && rival.members.size() > 1) continue;
    if (rival.named && behind < kDecisive) out.rivals.push_back(k);
    if (rival.named && out.anonymous && !out.named_rival && behind < 2.0 * kDecisive) out.named_rival = k;
  }
  return out;
}

HeldOut held_out(const Parts& parts, const Members& members) {
  const std::vector<System>&quarters = parts.quarters, &halves = parts.halves;
  std::vector<double> gains;
  double possible = 0.0;
  for (std::size_t k = 0; k < quarters.size(); ++k) {
    const VectorXd all = sizes_of_all(quarters[k], members, fit_set(all_but(quarters, k), members).coefficients);
    gains.push_back(2.0 * all.dot(quarters[k].score) - all.dot(quarters[k].information * all));
    possible += fit_set(quarters[k], members).gain;
  }
  HeldOut out;
  double sum = 0.0, square = 0.0;
  for (const double g : gains) sum += g;
  const auto n = static_cast<double>(gains.size());
  for (const double g : gains) square += (g - sum / n) * (g - sum / n);
  const double error = std::sqrt(square / (n - 1.0) * n);
  out.share = possible > 0.0 ? sum / possible : 0.0;
  out.low = possible > 0.0 ? (sum - 1.96 * error) / possible : 0.0;
  const SetFit a = fit_set(halves[0], members), b = fit_set(halves[1], members);
  for (Index k = 0; k < a.coefficients.size(); ++k) {
    const double sigma = std::sqrt(a.covariance(k, k) + b.covariance(k, k));
    const double apart = std::abs(a.coefficients(k) - b.coefficients(k));
    const double size = std::max(std::abs(a.coefficients(k)), std::abs(b.coefficients(k)));
    if (apart > kSmallDifference * size) out.unstable = std::max(out.unstable, apart / sigma);
  }
  return out;
}

}  // namespace voltlap::plant
