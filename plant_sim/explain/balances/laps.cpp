// SPDX-License-Identifier: Apache-2.0
#include "explain/balances/laps.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kStanding = 0.5;    // m/s
constexpr double kShortest = 400.0;  // m, of a stint
constexpr double kGrid = 4.0;        // m

/// Speed over the way, every kGrid metres.
VectorXd over_way(const Recording& log, const Stint& stint) {
  const VectorXd& speed = *log.find("speed");
  const VectorXd& way = stint.position_m;
  VectorXd out(static_cast<Index>(way(way.size() - 1) / kGrid));
  Index row = 0;
  for (Index k = 0; k < out.size(); ++k) {
    while (row + 1 < way.size() && way(row) < kGrid * static_cast<double>(k)) ++row;
    out(k) = speed(stint.first + row);
  }
  return out;
}

/// How alike the speeds are that lie this far apart: their correlation, or 0 where too little overlaps.
double alike(const std::vector<VectorXd>& profiles, Index apart) {
  constexpr Index kOverlap = 75;  // of the grid
  double count = 0.0, a = 0.0, b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  for (const VectorXd& profile : profiles) {
    const Index n = profile.size() - apart;
    if (n <= 0) continue;
    const auto x = profile.head(n), y = profile.tail(n);
    count += static_cast<double>(n);
    a += x.sum();
    b += y.sum();
    aa += x.squaredNorm();
    bb += y.squaredNorm();
    ab += x.dot(y);
  }
  if (count < static_cast<double>(kOverlap)) return 0.0;
  const double spread = (aa - a * a / count) * (bb - b * b / count);
  return spread > 0.0 ? (ab - a * b / count) / std::sqrt(spread) : 0.0;
}

}  // namespace

std::vector<Stint> stints_of(const Recording& log, std::size_t most) {
  const VectorXd& speed = *log.find("speed");
  std::vector<Stint> out;
  for (Index first = 0; first < log.rows();) {
    Index last = first;
    while (last < log.rows() && !(speed(last) < kStanding)) ++last;
    Stint stint{first, VectorXd::Zero(last - first)};
    for (Index row = first + 1; row < last; ++row) {
      const double v = std::isfinite(speed(row)) ? speed(row) : 0.0;
      stint.position_m(row - first) =
          stint.position_m(row - first - 1) + v * (log.time_s(row) - log.time_s(row - 1));
    }
    if (last > first && stint.position_m(last - first - 1) > kShortest) out.push_back(std::move(stint));
    first = last + 1;
  }
  const auto way = [](const Stint& s) { return s.position_m(s.position_m.size() - 1); };
  while (out.size() > most) {
    const auto shorter = [&](const Stint& a, const Stint& b) { return way(a) < way(b); };
    out.erase(std::min_element(out.begin(), out.end(), shorter));
  }
  return out;
}

double lap_length(const Recording& log, const std::vector<Stint>& stints) {
  constexpr Index kLeast = 40;                      // of the grid
  constexpr double kRepeats = 0.6, kAsGood = 0.05;  // correlation; several laps repeat as well as one
  std::vector<VectorXd> profiles;
  Index most = 0;
  for (const Stint& stint : stints) {
    profiles.push_back(over_way(log, stint));
    most = std::max(most, profiles.back().size());
  }
  std::vector<double> likeness;
  for (Index apart = kLeast; apart < most; ++apart) likeness.push_back(alike(profiles, apart));
  if (likeness.empty()) return 0.0;
  const double best = *std::max_element(likeness.begin(), likeness.end());
  if (best < kRepeats) return 0.0;
  for (std::size_t k = 1; k + 1 < likeness.size(); ++k) {
    const bool peak = likeness[k] >= likeness[k - 1] && likeness[k] >= likeness[k + 1];
    if (peak && likeness[k] > best - kAsGood) return kGrid * static_cast<double>(kLeast + static_cast<Index>(k));
  }
  return 0.0;
}

}  // namespace voltlap::plant
