// SPDX-License-Identifier: Apache-2.0
#include "car/battery/branch_reduction.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kTimes = 60, kParts = 3;  // of the sum: what is over at once, the two branches
using Curve = std::array<double, kTimes>;

/// Seconds after the step.
const Curve& times() {
  static const Curve kAt = [] {
    constexpr double kFirst = 1.0, kLast = 600.0;
    Curve out{};
    for (std::size_t k = 0; k < kTimes; ++k) {
      out[k] = kFirst * std::pow(kLast / kFirst, static_cast<double>(k) / (kTimes - 1));
    }
    return out;
  }();
  return kAt;
}

Curve rise(double tau_s) {
  Curve out{};
  std::transform(times().begin(), times().end(), out.begin(), [&](double t) { return 1.0 - std::exp(-t / tau_s); });
  return out;
}

double product(const Curve& a, const Curve& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < kTimes; ++k) sum += a[k] * b[k];
  return sum;
}

/// What a step takes beside R0.
Curve branches_of(const CircuitParameters& circuit) {
  Curve out{};
  for (std::size_t b = 0; b < kMostCellBranches; ++b) {
    if (circuit.r_ohm[b] == 0.0) continue;
    const Curve one = rise(circuit.tau_s[b]);
    for (std::size_t k = 0; k < kTimes; ++k) out[k] += circuit.r_ohm[b] * one[k];
  }
  return out;
}

struct Shares {
  std::array<double, kParts> ohm{};
  double square = 1e300;  ///< sum of squared errors
};

/// The parts of `used` alone, by Gauss; the others are 0. False where one would be negative.
bool solve(std::array<std::array<double, kParts + 1>, kParts> rows, unsigned used, std::array<double, kParts>& x) {
  for (std::size_t i = 0; i < kParts; ++i) {
    if ((used >> i & 1U) != 0) continue;
    rows[i] = {};
    for (auto& row : rows) row[i] = 0.0;
    rows[i][i] = 1.0;
  }
  for (std::size_t i = 0; i < kParts; ++i) {
    for (std::size_t below = i + 1; below < kParts; ++below) {
      const double factor = rows[below][i] / rows[i][i];
      for (std::size_t c = i; c <= kParts; ++c) rows[below][c] -= factor * rows[i][c];
    }
  }
  for (std::size_t i = kParts; i-- > 0;) {
    x[i] = rows[i][kParts];
    for (std::size_t c = i + 1; c < kParts; ++c) x[i] -= rows[i][c] * x[c];
    x[i] /= rows[i][i];
  }
  return std::all_of(x.begin(), x.end(), [](double v) { return v >= 0.0; });
}

/// Least squares without negative parts: the best of all subsets of the parts whose solution has none.
Shares shares_of(const Curve& wanted, double tau_a_s, double tau_b_s) {
  Curve at_once{};
  at_once.fill(1.0);
  const std::array<Curve, kParts> parts{at_once, rise(tau_a_s), rise(tau_b_s)};
  std::array<std::array<double, kParts + 1>, kParts> normal{};
  for (std::size_t i = 0; i < kParts; ++i) {
    for (std::size_t k = 0; k < kParts; ++k) normal[i][k] = product(parts[i], parts[k]);
    normal[i][kParts] = product(parts[i], wanted);
  }
  Shares best;
  for (unsigned used = 1; used < 1U << kParts; ++used) {
    Shares tried;
    if (!solve(normal, used, tried.ohm)) continue;
    Curve left = wanted;
    for (std::size_t i = 0; i < kParts; ++i) {
      for (std::size_t k = 0; k < kTimes; ++k) left[k] -= tried.ohm[i] * parts[i][k];
    }
    tried.square = product(left, left);
    if (tried.square < best.square) best = tried;
  }
  VOLTLAP_DEMAND(best.square < 1e300);
  return best;
}

/// Where `cost` of two logarithms is least: a grid, then eight neighbours at half the distance again and again.
template <class Cost>
std::pair<double, double> search(const Cost& cost, double low, double high) {
  constexpr int kGrid = 24;
  constexpr double kEnough = 1e-6;
  double step = (high - low) / kGrid, a = low, b = high, least = cost(a, b);
  const auto look = [&](double x, double y) {
    if (x < low || y > high || x >= y) return false;
    const double here = cost(x, y);
    if (!(here < least)) return false;
    least = here;
    a = x;
    b = y;
    return true;
  };
  for (int i = 0; i <= kGrid; ++i) {
    for (int k = i + 1; k <= kGrid; ++k) look(low + step * i, low + step * k);
  }
  while (step > kEnough) {
    bool moved = false;
    const double x = a, y = b;
    for (const double dx : {-step, 0.0, step}) {
      for (const double dy : {-step, 0.0, step}) moved = look(x + dx, y + dy) || moved;
    }
    if (!moved) step *= 0.5;
  }
  return {a, b};
}

}  // namespace

CircuitOf<2> two_branches(const CircuitParameters& circuit, std::size_t branches) {
  VOLTLAP_DEMAND(branches >= 1 && branches <= kMostCellBranches);
  if (branches <= 2) {
    return {circuit.r0_ohm,
            {circuit.r_ohm[0], circuit.r_ohm[1]},
            {circuit.tau_s[0], branches == 2 ? circuit.tau_s[1] : circuit.tau_s[0]}};
  }
  const auto last = circuit.tau_s.begin() + static_cast<std::ptrdiff_t>(branches);
  const auto [shortest, longest] = std::minmax_element(circuit.tau_s.begin(), last);
  const Curve wanted = branches_of(circuit);
  const auto cost = [&](double ln_a, double ln_b) { return shares_of(wanted, std::exp(ln_a), std::exp(ln_b)).square; };
  const auto [ln_a, ln_b] = search(cost, std::log(*shortest), std::log(*longest));
  const Shares found = shares_of(wanted, std::exp(ln_a), std::exp(ln_b));
  return {circuit.r0_ohm + found.ohm[0], {found.ohm[1], found.ohm[2]}, {std::exp(ln_a), std::exp(ln_b)}};
}

StepError step_error(const CircuitParameters& circuit, const CircuitOf<2>& reduced) {
  Curve left = branches_of(circuit);
  const Curve a = rise(reduced.tau_s[0]), b = rise(reduced.tau_s[1]);
  StepError out;
  for (std::size_t k = 0; k < kTimes; ++k) {
    left[k] += circuit.r0_ohm - reduced.r0_ohm - reduced.r_ohm[0] * a[k] - reduced.r_ohm[1] * b[k];
    out.largest_ohm = std::max(out.largest_ohm, std::abs(left[k]));
  }
  out.rms_ohm = std::sqrt(product(left, left) / kTimes);
  return out;
}

BranchReduction reduce_branches(const CellParameters& cell, const std::vector<double>& soc) {
  VOLTLAP_DEMAND(!soc.empty() && cell.capacity_ah > 0.0);
  const CellTables tables(cell);
  BranchReduction out;
  out.branches = tables.branches();
  double square = 0.0;
  for (const double at : soc) {
    const CircuitParameters whole = tables.circuit(at, cell.reference_temperature_c, cell.reference_current_a);
    out.circuits.push_back(two_branches(whole, out.branches));
    const StepError error = step_error(whole, out.circuits.back());
    square += error.rms_ohm * error.rms_ohm / static_cast<double>(soc.size());
    if (error.largest_ohm * cell.capacity_ah <= out.largest_v) continue;
    out.largest_v = error.largest_ohm * cell.capacity_ah;
    out.largest_at_soc = at;
  }
  out.rms_v = std::sqrt(square) * cell.capacity_ah;
  return out;
}

}  // namespace voltlap::plant
