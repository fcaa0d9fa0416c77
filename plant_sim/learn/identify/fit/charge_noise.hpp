// SPDX-License-Identifier: Apache-2.0
// SOC is a count of a noisy current: its error walks, and moves the OCV's voltage at every row after it together.
//
//   dSOC(t) = W(q) sqrt(T) / C,   T = integral of n_I^2 dt [A^2 s^2],   q: share of T up to t,   n_I^2 [A^2 s]
//   W: a Brownian bridge where the recording's own span is the capacity (SOC is 1 and 0 at its ends), else a motion:
//   W = sum_k z_k sqrt(2) sin(w_k q) / w_k,   w_k = k pi or (k - 1/2) pi,   z_k normal           (Karhunen and Loeve)
//
// Each term is put into the recording, dV = dOCV/dSOC dSOC, and the fit's answer, one Gauss-Newton step, is a term of
// the variance.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "learn/identify/fit/full_fit.hpp"
#include "learn/identify/preparation/prepared_log.hpp"

namespace voltlap::plant {

/// Noise of a recorded current as power density [A^2 s], from second differences of rows with a steady current.
struct CurrentNoise {
  double rest_a2_s = 0.0, load_a2_s = 0.0;
};
[[nodiscard]] CurrentNoise current_noise(const CellLog& log);

/// Variance of each packed parameter. `runs`: the recordings as they were fitted.
[[nodiscard]] Eigen::VectorXd charge_noise_variance(const std::vector<PreparedLog>& prepared,
                                                    const std::vector<MeasuredRun>& runs, bool capacity_known,
                                                    const FullFit& full);

}  // namespace voltlap::plant
