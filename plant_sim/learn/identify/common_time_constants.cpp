// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/common_time_constants.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <future>
#include <numeric>

#include "core/demand.hpp"
#include "learn/identify/circuit/fitted_circuit.hpp"
#include "learn/identify/circuit/nelder_mead.hpp"

namespace voltlap::plant {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Work of each test, side by side.
std::vector<double> of_each(std::size_t count, const std::function<double(std::size_t)>& work) {
  std::vector<std::future<double>> running;
  for (std::size_t g = 0; g < count; ++g) running.push_back(std::async(std::launch::async, work, g));
  std::vector<double> out;
  for (auto& one : running) out.push_back(one.get());
  return out;
}

/// x = [a_1 .. a_K | b] to ln tau of a test; without b where all are equally warm.
class TemperatureLaw {
 public:
  TemperatureLaw(const std::vector<double>& temperatures_c, Index branches)
      : temperatures_c_(temperatures_c),
        branches_(branches),
        mean_c_(std::accumulate(temperatures_c.begin(), temperatures_c.end(), 0.0) /
                static_cast<double>(temperatures_c.size())) {
    constexpr double kSameTemperature = 1.0;
    const auto [coldest, warmest] = std::minmax_element(temperatures_c.begin(), temperatures_c.end());
    by_temperature_ = *warmest - *coldest > kSameTemperature;
  }
  [[nodiscard]] VectorXd start_at(const VectorXd& log_tau) const {
    VectorXd x = VectorXd::Zero(branches_ + (by_temperature_ ? 1 : 0));
    x.head(branches_) = log_tau;
    return x;
  }
  [[nodiscard]] VectorXd log_tau_at(const VectorXd& x, std::size_t test) const {
    constexpr double kZeroCelsius = 273.15, kThousand = 1000.0;
    if (!by_temperature_) return x;
    const double inverse = 1.0 / (temperatures_c_[test] + kZeroCelsius) - 1.0 / (mean_c_ + kZeroCelsius);
    return x.head(branches_).array() + x(branches_) * kThousand * inverse;
  }

 private:
  const std::vector<double>& temperatures_c_;
  Index branches_;
  double mean_c_;
  bool by_temperature_;
};

std::vector<CircuitFit> fits_of(const std::vector<IdentificationProblem>& problems, Index branches) {
  std::vector<CircuitFit> fits;
  fits.reserve(problems.size());
  for (const IdentificationProblem& problem : problems) {
    FitPriors priors = problem.priors;
    priors.smoothness = 1.0;
    fits.emplace_back(problem.runs, branches, priors);
  }
  return fits;
}

}  // namespace

std::vector<VectorXd> common_time_constants(const std::vector<IdentificationProblem>& problems,
                                            const std::vector<double>& temperatures_c, int branches) {
  constexpr int kOwnEvaluations = 30, kEvaluations = 80;
  constexpr double kEdge = 0.5;  // of the simplex, of ln tau
  VOLTLAP_DEMAND(!problems.empty() && temperatures_c.size() == problems.size());
  const std::size_t count = problems.size();
  const std::vector<CircuitFit> fits = fits_of(problems, branches);
  std::vector<VectorXd> own(count);
  const std::vector<double> own_cost = of_each(count, [&](std::size_t g) {
    own[g] = fits[g].search_taus(first_taus(branches), kOwnEvaluations).array().log();
    return fits[g].cost_of_taus(own[g]);
  });
  const TemperatureLaw law(temperatures_c, branches);
  const auto cost = [&](const VectorXd& x) {
    const std::vector<double> each =
        of_each(count, [&](std::size_t g) { return fits[g].cost_of_taus(law.log_tau_at(x, g)); });
    double sum = 0.0;
    for (std::size_t g = 0; g < count; ++g) sum += each[g] / own_cost[g];
    return sum;
  };
  // From each test's own answer one look, from the best of them the search.
  VectorXd best = law.start_at(own.front());
  double least = 1e300;
  for (const VectorXd& tried : own) {
    const VectorXd x = law.start_at(tried);
    const double at = cost(x);
    if (at < least) {
      least = at;
      best = x;
    }
  }
  best = nelder_mead_minimum(cost, best, kEdge, kEvaluations);
  std::vector<VectorXd> out;
  for (std::size_t g = 0; g < count; ++g) out.push_back(law.log_tau_at(best, g).array().exp());
  return out;
}

}  // namespace voltlap::plant
