// SPDX-License-Identifier: Apache-2.0
// One pair of time constants for several tests of a cell, before each is fitted by itself.
//
// What a pulse shows can be divided among two lags in several ways that fit it alike. Tests that divide it differently
// cannot be mixed: between their currents a table would charge one branch and discharge the other. So all tests look
// for their time constants together,
//
//   ln tau_k(T) = a_k + b (1/T - 1/T_mean) 1000 K       b: one for all branches, none when all tests are equally warm
//
// where the sum over the tests of cost / cost with time constants of its own is least.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "learn/identify/identify.hpp"

namespace voltlap::plant {

/// Time constants [s] of the branches for each test, in its order; `temperatures_c`: of each.
[[nodiscard]] std::vector<Eigen::VectorXd> common_time_constants(const std::vector<IdentificationProblem>& problems,
                                                                 const std::vector<double>& temperatures_c,
                                                                 int branches);

}  // namespace voltlap::plant
