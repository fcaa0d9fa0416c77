// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/curved_member.hpp"

#include <algorithm>
#include <optional>

#include "discrepancy/discount.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The sizes that the candidate's signatures have in an effect on the member.
class SizesOf {
 public:
  SizesOf(const Design& design, const NoiseModel& noise, const Usual& usual, const Candidate& candidate)
      : whitener_(design.comparison.log.time_s, std::vector<bool>(static_cast<std::size_t>(design.comparison.log.rows()), true),
                  noise.at(design.comparison.groups[static_cast<std::size_t>(candidate.group)].stem), {}),
        own_(candidate.shapes) {
    const auto g = static_cast<std::size_t>(candidate.group);
    const auto& shapes = design.shapes[g];
    const auto count = static_cast<Index>(shapes.size());
    whitened_.resize(design.comparison.log.rows(), count);
    for (Index k = 0; k < count; ++k) whitened_.col(k) = whitener_.apply(shapes[static_cast<std::size_t>(k)].effect);
    discount_.emplace(whitened_.transpose() * whitened_, usual.group_variance[g]);
    inverse_ = MatrixXd(discount_->information()(own_, own_)).inverse();
  }

  [[nodiscard]] VectorXd operator()(const VectorXd& effect) const {
    const VectorXd score = discount_->score(whitened_.transpose() * whitener_.apply(effect)).col(0);
    return inverse_ * score(own_);
  }

 private:
  Whitener whitener_;
  std::vector<Index> own_;
  MatrixXd whitened_, inverse_;
  std::optional<Discount> discount_;
};

}  // namespace

CurvedValues curved_values(const Design& design, const NoiseModel& noise, const Usual& usual, const Cause& cause,
                           const Candidate& candidate, const VectorXd& sizes) {
  constexpr int kRounds = 8;
  constexpr double kStep = 0.02, kEnough = 1e-3;  // typical sizes
  const Form& form = design.forms[static_cast<std::size_t>(candidate.cause)][candidate.form];
  const SizesOf sizes_of(design, noise, usual, candidate);
  const Index n = sizes.size();
  const auto parameter = [&](Index k) -> const CauseParameter& {
    return cause.parameters[candidate.parameters[static_cast<std::size_t>(k)]];
  };
  const auto seen_at = [&](const VectorXd& values) {
    std::vector<double> all = form.at;
    for (Index k = 0; k < n; ++k) all[candidate.parameters[static_cast<std::size_t>(k)]] += values(k);
    return sizes_of(form.curved(design.model, design.comparison, design.base, all));
  };
  CurvedValues out;
  out.values.resize(n);
  out.per_size = MatrixXd::Zero(n, n);
  for (Index k = 0; k < n; ++k) out.per_size(k, k) = parameter(k).typical;
  for (Index k = 0; k < n; ++k) out.values(k) = std::clamp(sizes(k) * parameter(k).typical, parameter(k).low, parameter(k).high);
  for (int round = 0; round < kRounds; ++round) {
    const VectorXd seen = seen_at(out.values);
    MatrixXd slope(n, n);
    for (Index k = 0; k < n; ++k) {
      VectorXd moved = out.values;
      const double step = (moved(k) > 0.0 ? -kStep : kStep) * parameter(k).typical;
      moved(k) += step;
      slope.col(k) = (seen_at(moved) - seen) / step;
    }
    const MatrixXd per_size = slope.inverse();
    if (!per_size.allFinite()) break;  // nothing of it shows here: the straight sizes stay
    out.per_size = per_size;
    VectorXd next = out.values + out.per_size * (sizes - seen);
    double most = 0.0;
    for (Index k = 0; k < n; ++k) {
      next(k) = std::clamp(next(k), parameter(k).low, parameter(k).high);
      most = std::max(most, std::abs(next(k) - out.values(k)) / parameter(k).typical);
    }
    out.values = next;
    if (most < kEnough) break;
  }
  for (Index k = 0; k < n; ++k) out.inside_prior = out.inside_prior && is_inside_prior(parameter(k), out.values(k));
  return out;
}

}  // namespace voltlap::plant
