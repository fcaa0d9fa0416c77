// SPDX-License-Identifier: Apache-2.0
// A hypothesis is a set of columns (causes and nuisances) with sizes and noise of its own. It is judged on minutes
// it has not seen:
//
//   ln p(block b | the other blocks) = ln Z(all) - ln Z(all but b)
//   ln Z = -1/2 sum over channels [n ln(2 pi s^2) + ln det + y'y / s^2] + 1/2 c'A^-1 c - 1/2 ln det A + 1/2 ln det
//   P A = P + sum X'X / s^2,   c = sum X'y / s^2
//
// with P the precision of the priors, s^2 of each channel that of the other blocks, and the noise of each channel
// the most probable of its grid. Everything is sums over Gram matrices (fit/gram.hpp): no row is touched again.
#pragma once
#include <vector>

#include "explain/fit/gram.hpp"

namespace voltlap::explain {

/// Columns next to each other that are the points of a curve: it goes on straight where nothing tells how it bends.
struct Curve {
  Index first = 0, points = 0;
  double bend = 0.0;  ///< standard deviation of a second difference
};

/// Channels that share columns.
struct Problem {
  std::vector<ChannelGram> channels;
  VectorXd prior_sigma;  ///< of each column's size
  std::vector<Curve> curves;
  std::vector<double> least_sigma;  ///< of each channel's noise: no sensor and no model is better
  std::vector<double> most_slow;    ///< standard deviation of each channel's slow noise: sound logs have no more
  std::vector<Index> nuisances;     ///< columns that every hypothesis has
  std::size_t free = 0;             ///< of them, the first: what they can take is no effect of a cause
  Index blocks = 0;
};

struct Fit {
  std::vector<Index> columns;  ///< nuisances first
  VectorXd size;
  VectorXd plain_starts;  ///< sizes of the nuisances that plain least squares give beside the causes
  MatrixXd covariance;
  VectorXd log_p;                  ///< of each block under the fit of the others
  MatrixXd left;                   ///< channel x block: plain sum of squares under the fit of the others
  std::vector<std::size_t> noise;  ///< by channel, of its grid
  VectorXd variance;               ///< s^2 by channel
  [[nodiscard]] double total() const { return log_p.sum(); }
};
/// Least squares of nuisances, none further from nothing than three of its standard deviations.
[[nodiscard]] VectorXd bounded_starts(MatrixXd normal, VectorXd right, const VectorXd& sigma);
/// Standard deviation of the slow part of a channel's noise.
[[nodiscard]] double slow_noise(const Problem& problem, const Fit& fit, std::size_t channel);
/// Variance of the rest of it: white, and what grows with the change of the current.
[[nodiscard]] double fast_variance(const Problem& problem, const Fit& fit, std::size_t channel);
/// `with` beside the nuisances.
[[nodiscard]] Fit fit_of(const Problem& problem, const std::vector<Index>& with);

/// How much more probable `better` makes the blocks than `worse`, and whether that is decisive: more than ln 20 on
/// the whole and without its best block, and the blocks that speak against it lose less than half of what the
/// others win.
struct Lead {
  double ln = 0.0;
  bool decisive = false;
};
[[nodiscard]] Lead lead_of(const Fit& better, const Fit& worse);

}  // namespace voltlap::explain
