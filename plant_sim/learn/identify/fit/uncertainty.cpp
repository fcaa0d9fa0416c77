// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/fit/uncertainty.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

struct BlockDensity {
  double density_v2_s = 0.0, blocks = 0.0;
};

/// Power density of the means of blocks; length 0: of single rows.
BlockDensity density_at(const std::vector<MeasuredRun>& runs, const std::vector<Eigen::VectorXd>& errors,
                        double length_s) {
  double sum = 0.0, weight = 0.0, blocks = 0.0;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const MeasuredRun& run = runs[k];
    double part = 0.0, part_weight = 0.0, begin = run.time_s(0);
    const auto close = [&] {
      if (part_weight <= 0.0) return;
      sum += part * part;
      weight += part_weight;
      blocks += 1.0;
      part = part_weight = 0.0;
    };
    for (Index row = 0; row < run.rows(); ++row) {
      if (run.time_s(row) - begin >= length_s || run.is_reset(row)) {
        close();
        begin = run.time_s(row);
      }
      part += run.weight_s(row) * errors[k](row);
      part_weight += run.weight_s(row);
    }
    close();
  }
  return {weight > 0.0 ? sum / weight : 0.0, blocks};
}

constexpr std::array kLengths{1.0, 3.0, 10.0, 30.0, 100.0, 300.0};

Eigen::MatrixXd inverse_of(Eigen::MatrixXd whole) {
  whole.diagonal() *= 1.0 + 1e-12;
  return whole.ldlt().solve(Eigen::MatrixXd::Identity(whole.rows(), whole.cols()));
}

Eigen::VectorXd data_share(const Eigen::MatrixXd& inverse, const CircuitResiduals::Sums& sums) {
  return inverse.cwiseProduct(sums.rest + sums.load).rowwise().sum().array().max(0.0).min(1.0);
}

/// Parameters of the same straight lines on the halved grid.
Eigen::VectorXd halved_parameters(const CircuitResiduals& cost, const Eigen::VectorXd& p, const CircuitLayout& to) {
  const CircuitLayout& at = cost.layout();
  Eigen::VectorXd out(to.size());
  out.head(at.em) = p.head(at.em);
  const Index rest = at.size() - at.state();
  out.tail(rest) = p.tail(rest);
  for (Index table = 1; table < at.tables(); ++table) {
    const Eigen::ArrayXd y = p.segment(at.first(table), at.nodes).array();
    for (Index k = 0; k < at.nodes; ++k) {
      out(to.first(table) + 2 * k) = y(k);
      if (k + 1 < at.nodes) out(to.first(table) + 2 * k + 1) = std::log(0.5 * (std::exp(y(k)) + std::exp(y(k + 1))));
    }
  }
  return out;
}

/// Where the parameters of a grid stand among those of the halved one.
std::vector<Index> places_on_halved(const CircuitLayout& at, const CircuitLayout& to) {
  std::vector<Index> out;
  for (Index k = 0; k < at.em; ++k) out.push_back(k);
  for (Index table = 1; table < at.tables(); ++table) {
    for (Index k = 0; k < at.nodes; ++k) out.push_back(to.first(table) + 2 * k);
  }
  for (Index k = at.state(); k < at.size(); ++k) out.push_back(to.state() + k - at.state());
  return out;
}

}  // namespace

double noise_density(const std::vector<MeasuredRun>& runs, const std::vector<Eigen::VectorXd>& errors) {
  constexpr double kFewestBlocks = 20.0;
  VOLTLAP_DEMAND(!runs.empty() && errors.size() == runs.size());
  double largest = 0.0;
  for (const double length : kLengths) {
    const BlockDensity at = density_at(runs, errors, length);
    if (at.blocks >= kFewestBlocks || largest == 0.0) largest = std::max(largest, at.density_v2_s);
  }
  return largest;
}

double lasting_density(const std::vector<MeasuredRun>& runs, const std::vector<Eigen::VectorXd>& errors) {
  constexpr std::array kLasting{1000.0, 3000.0, 10000.0};
  constexpr double kFewestBlocks = 8.0;
  double largest = noise_density(runs, errors);
  for (const double length : kLasting) {
    const BlockDensity at = density_at(runs, errors, length);
    if (at.blocks >= kFewestBlocks) largest = std::max(largest, at.density_v2_s);
  }
  return largest;
}

double instrument_noise(const MeasuredRun& run) {
  constexpr double kLeast = 1e-4, kSame = 0.01, kTrimmed = 0.98;  // V; of the largest current, of dt; of the rows
  const double most = run.current_a.cwiseAbs().maxCoeff();
  std::vector<double> squares;
  for (Index row = 2; row < run.rows(); ++row) {
    const double dt = run.dt_s(row);
    const bool equal = std::abs(run.dt_s(row - 1) - dt) < kSame * dt && !run.is_reset(row) && !run.is_reset(row - 1);
    const bool steady = std::abs(run.current_a(row) - run.current_a(row - 1)) < kSame * most &&
                        std::abs(run.current_a(row - 1) - run.current_a(row - 2)) < kSame * most;
    if (!equal || !steady) continue;
    const double second = run.voltage_v(row) - 2.0 * run.voltage_v(row - 1) + run.voltage_v(row - 2);
    squares.push_back(second * second / 6.0 * dt);
  }
  std::sort(squares.begin(), squares.end());
  squares.resize(static_cast<std::size_t>(kTrimmed * static_cast<double>(squares.size())));
  double sum = 0.0;
  for (const double square : squares) sum += square;
  return std::max(kLeast * kLeast, squares.empty() ? 0.0 : sum / static_cast<double>(squares.size()));
}

ResidualColour colour_of(const std::vector<MeasuredRun>& runs, const std::vector<Eigen::VectorXd>& errors,
                         double instrument_v2_s) {
  VOLTLAP_DEMAND(errors.size() == runs.size() && instrument_v2_s > 0.0);
  constexpr double kSure = 3.0, kMostOfNoise = 4.0;  // standard errors; ratio
  const double white = std::max(1e-30, density_at(runs, errors, 0.0).density_v2_s);
  ResidualColour out;
  for (const double length : kLengths) {
    const BlockDensity at = density_at(runs, errors, length);
    const double ratio = at.density_v2_s / white;
    if (ratio > 1.0 + kSure * std::sqrt(2.0 / std::max(1.0, at.blocks))) out.ratio = std::max(out.ratio, ratio);
  }
  out.is_noise = std::max(out.ratio, white / instrument_v2_s) < kMostOfNoise;
  return out;
}

Uncertainty uncertainty_of_noise(const CircuitResiduals& cost, const Eigen::VectorXd& p, double colour) {
  VOLTLAP_DEMAND(p.size() == cost.parameter_count() && colour >= 1.0);
  const CircuitFit& lines = cost.fit();
  const CircuitFit fit(lines.runs(), lines.branches(), lines.priors(), halved(lines.grid()));
  const CircuitResiduals curve(fit, cost.tau_centre_s());
  const Eigen::VectorXd at = halved_parameters(cost, p, curve.layout());
  const CircuitResiduals::Sums sums = curve.sums(at);
  const Eigen::MatrixXd inverse = inverse_of(sums.whole());
  // Rows that parameters have used up do not count again.
  const auto rows = static_cast<double>(sums.rest_rows + sums.load_rows);
  const double left = std::max(0.1, 1.0 - inverse.cwiseProduct(sums.rest + sums.load).sum() / rows);
  const auto density = [&](double square, Index count) {
    return colour * square / (left * std::max(1.0, static_cast<double>(count)));
  };
  const double rest = density(sums.rest_square, sums.rest_rows), load = density(sums.load_square, sums.load_rows),
               both = density(sums.rest_square + sums.load_square, sums.rest_rows + sums.load_rows);
  const Eigen::MatrixXd middle = rest * sums.rest + load * sums.load + both * sums.prior;
  const Eigen::ArrayXd noise = (inverse * middle).cwiseProduct(inverse).rowwise().sum().array().max(0.0);
  const Eigen::ArrayXd beside = (inverse * sums.gradient).array().square();
  const Eigen::VectorXd sigma = (noise + beside).sqrt();
  const std::vector<Index> nodes = places_on_halved(cost.layout(), curve.layout());
  VOLTLAP_DEMAND(static_cast<Index>(nodes.size()) == p.size());
  return {sigma(nodes), data_share(inverse, sums)(nodes)};
}

Uncertainty uncertainty_of(const CircuitResiduals& cost, const Eigen::VectorXd& p, double noise_v2_s) {
  VOLTLAP_DEMAND(p.size() == cost.parameter_count() && noise_v2_s >= 0.0);
  const CircuitResiduals::Sums sums = cost.sums(p);
  const Eigen::MatrixXd inverse = inverse_of(sums.whole());
  Uncertainty out;
  const Eigen::VectorXd bias = inverse * sums.prior_gradient;
  out.sigma = (noise_v2_s * inverse.diagonal().array().max(0.0) + bias.array().square()).sqrt();
  out.data_share = data_share(inverse, sums);
  return out;
}

}  // namespace voltlap::plant
