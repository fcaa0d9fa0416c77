// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/common_time_constants.hpp"

#include <algorithm>
#include <cmath>
#include <future>
#include <numeric>

#include "learn/identify/circuit/nelder_mead.hpp"

namespace voltlap::plant {

using Eigen::Index;
using Eigen::VectorXd;

std::vector<VectorXd> common_time_constants(const std::vector<IdentificationProblem>& tests,
                                            const std::vector<double>& temperatures_c, int branches) {
  constexpr int kOwnEvaluations = 30, kEvaluations = 80;
  constexpr double kZeroCelsius = 273.15, kThousand = 1000.0, kSameTemperature = 1.0;
  const std::size_t count = tests.size();
  std::vector<CircuitFit> fits;
  fits.reserve(count);
  for (const IdentificationProblem& test : tests) {
    FitPriors priors = test.priors;
    priors.smoothness = 1.0;
    fits.emplace_back(test.runs, branches, priors);
  }
  /// Work of each test, side by side.
  const auto of_each = [&](const auto& work) {
    std::vector<std::future<double>> running;
    for (std::size_t g = 0; g < count; ++g) running.push_back(std::async(std::launch::async, work, g));
    std::vector<double> out;
    for (auto& one : running) out.push_back(one.get());
    return out;
  };
  std::vector<VectorXd> own(count);
  const std::vector<double> own_cost = of_each([&](std::size_t g) {
    own[g] = fits[g].search_taus(first_taus(branches), kOwnEvaluations).array().log();
    return fits[g].cost_of_taus(own[g]);
  });
  const double mean_c = std::accumulate(temperatures_c.begin(), temperatures_c.end(), 0.0) / static_cast<double>(count);
  const auto [coldest, warmest] = std::minmax_element(temperatures_c.begin(), temperatures_c.end());
  const bool by_temperature = *warmest - *coldest > kSameTemperature;
  const auto at_test = [&](const VectorXd& x, std::size_t g) -> VectorXd {
    if (!by_temperature) return x;
    const double inverse = 1.0 / (temperatures_c[g] + kZeroCelsius) - 1.0 / (mean_c + kZeroCelsius);
    return x.head(branches).array() + x(branches) * kThousand * inverse;
  };
  const auto cost = [&](const VectorXd& x) {
    const std::vector<double> each = of_each([&](std::size_t g) { return fits[g].cost_of_taus(at_test(x, g)); });
    double sum = 0.0;
    for (std::size_t g = 0; g < count; ++g) sum += each[g] / own_cost[g];
    return sum;
  };
  // From each test's own answer one look, from the best of them the search.
  VectorXd best;
  double least = 1e300;
  for (const VectorXd& tried : own) {
    VectorXd x = VectorXd::Zero(branches + (by_temperature ? 1 : 0));
    x.head(branches) = tried;
    const double at = cost(x);
    if (at < least) {
      least = at;
      best = x;
    }
  }
  constexpr double kEdge = 0.5;
  best = nelder_mead_minimum(cost, best, kEdge, kEvaluations);
  std::vector<VectorXd> out;
  for (std::size_t g = 0; g < count; ++g) out.push_back(at_test(best, g).array().exp());
  return out;
}

}  // namespace voltlap::plant
