// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/fit/evidence.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {

using Eigen::Index;

namespace {

/// D y of a table and its derivatives by the packed parameters of that table.
struct Roughness {
  Eigen::VectorXd value;
  Eigen::MatrixXd by_p;
};

Roughness roughness_of(const CircuitResiduals& cost, const Eigen::VectorXd& p, Index table) {
  const CircuitLayout& at = cost.layout();
  const Eigen::MatrixXd rows = table == 0 ? cost.fit().ocv().roughness() : cost.fit().grid().roughness();
  Eigen::VectorXd y = p.segment(at.first(table), at.count(table));
  if (table == 0 || table > at.branches + 1) return {rows * y, rows};
  y = y.array().exp();
  return {rows * y, rows * y.asDiagonal()};
}

/// gamma of a table: how many rows of its roughness the data decide.
double decided_rows(const CircuitResiduals& cost, const Roughness& rough, const Eigen::MatrixXd& inverse, Index table) {
  constexpr double kLeastShare = 0.02;  // of the rows
  const CircuitLayout& at = cost.layout();
  const double weight = cost.fit().priors().roughness_weight(table, at.branches);
  const auto block = inverse.block(at.first(table), at.first(table), at.count(table), at.count(table));
  const double trace = (rough.by_p * block).cwiseProduct(rough.by_p).sum();
  const auto rank = static_cast<double>(rough.value.size());
  return std::max(kLeastShare * rank, rank - weight * weight * trace);
}

/// What a table's values are measured in.
double unit_of(const CircuitResiduals& cost, Index table) {
  const bool is_resistance = table > 0 && table <= cost.layout().branches + 1;
  return is_resistance ? cost.fit().priors().resistance_scale : 1.0;
}

}  // namespace

Evidence evidence_at(const CircuitResiduals& cost, const Eigen::VectorXd& p, double colour) {
  constexpr double kMostChange = 30.0;  // of a variance in one update
  constexpr double kStraight = 0.05;  // least spread of a roughness in its unit: as good as a straight line
  const CircuitLayout& at = cost.layout();
  VOLTLAP_DEMAND(p.size() == at.size() && colour >= 1.0);
  const CircuitResiduals::Sums sums = cost.sums(p);
  Eigen::MatrixXd whole = sums.whole();
  whole.diagonal() *= 1.0 + 1e-12;
  const Eigen::MatrixXd inverse = whole.ldlt().solve(Eigen::MatrixXd::Identity(at.size(), at.size()));
  Evidence out;
  const double decided = (inverse.cwiseProduct(sums.rest + sums.load)).sum();
  out.noise_v2_s = colour * (sums.rest_square + sums.load_square) /
                   std::max(1.0, static_cast<double>(sums.rest_rows + sums.load_rows) - decided);
  out.roughness_weights.resize(at.tables());
  for (Index table = 0; table < at.tables(); ++table) {
    const double before = cost.fit().priors().roughness_weight(table, at.branches);
    const Roughness rough = roughness_of(cost, p, table);
    const double gamma = decided_rows(cost, rough, inverse, table);
    const double wanted = out.noise_v2_s * gamma / std::max(rough.value.squaredNorm(), 1e-30);
    const double square = before * before;
    const double least = kStraight * unit_of(cost, table), most = out.noise_v2_s / (least * least);
    out.roughness_weights(table) =
        std::sqrt(std::min(most, std::clamp(wanted, square / kMostChange, square * kMostChange)));
  }
  return out;
}

EvidenceFit fit_by_evidence(const std::vector<MeasuredRun>& runs, Index branches, FitPriors priors,
                            const Eigen::VectorXd& tau_centre_s, const Eigen::VectorXd& start, double colour) {
  constexpr int kRounds = 12;
  constexpr double kStill = 0.1;  // of the logarithm of a weight
  VOLTLAP_DEMAND(tau_centre_s.size() == branches && colour >= 1.0);
  EvidenceFit out{std::move(priors), {start}};
  for (; out.rounds < kRounds; ++out.rounds) {
    const CircuitFit fit(runs, branches, out.priors);
    const CircuitResiduals cost(fit, tau_centre_s);
    const int before = out.fit.iterations;
    out.fit = refine(cost, out.fit.p, out.rounds == 0 ? 15 : 5);
    out.fit.iterations += before;
    const Evidence evidence = evidence_at(cost, out.fit.p, colour);
    double change = 0.0;
    for (Index table = 0; table < evidence.roughness_weights.size(); ++table)
      change = std::max(change, std::abs(std::log(evidence.roughness_weights(table) /
                                                  out.priors.roughness_weight(table, branches))));
    out.priors.roughness_weights = evidence.roughness_weights;
    out.priors.noise_v2_s = evidence.noise_v2_s;
    if (change < kStill) break;
  }
  return out;
}

}  // namespace voltlap::plant
