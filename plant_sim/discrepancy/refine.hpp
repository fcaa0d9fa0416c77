// SPDX-License-Identifier: Apache-2.0
// A set of causes on the true nonlinear model: Gauss-Newton on all its parameters in the whitened domain, with the
// usual discrepancy marginalised as in the linear stage, inside the priors.
#pragma once
#include <optional>
#include <vector>

#include "discrepancy/discount.hpp"
#include "discrepancy/evidence.hpp"

namespace voltlap::plant {

/// One cause of a refined set.
struct RefinedCause {
  std::size_t candidate = 0;
  std::vector<double> values;        ///< every parameter of the cause
  std::vector<double> sigma;         ///< of each; 0 where it was not estimated
  double distance = 0.0;             ///< d': its own effect over what the data leave uncertain
  bool inside_prior = true;
};

struct RefinedSet {
  std::vector<RefinedCause> causes;
  World world;                       ///< the model with them
  double gain = 0.0;                 ///< drop of the discounted energy
};

/// Its candidates.
[[nodiscard]] inline std::vector<std::size_t> members_of(const RefinedSet& set) {
  std::vector<std::size_t> out;
  for (const RefinedCause& cause : set.causes) out.push_back(cause.candidate);
  return out;
}

class Refinery {
 public:
  Refinery(const Design& design, const std::vector<Cause>& causes, const System& system, const NoiseModel& noise,
           const Usual& usual, const std::vector<bool>& use_rows);
  /// `members` of the system; local causes keep their linear estimate, bent where they bend.
  [[nodiscard]] RefinedSet refine(const std::vector<std::size_t>& members) const;

 private:
  struct Normal {
    Eigen::MatrixXd information;
    Eigen::VectorXd score;
    double energy = 0.0;
  };
  [[nodiscard]] std::vector<Eigen::VectorXd> whitened(const std::vector<Eigen::VectorXd>& channels) const;
  [[nodiscard]] Normal normal_of(const std::vector<std::vector<Eigen::VectorXd>>& jacobian,
                                 const std::vector<Eigen::VectorXd>& residual) const;

  const Design& design_;
  const std::vector<Cause>& causes_;
  const System& system_;
  const NoiseModel& noise_;
  const Usual& usual_;
  std::vector<Whitener> whiteners_;
  std::vector<double> weight_;              ///< [channel]
  Eigen::MatrixXd stacked_;                 ///< whitened columns of all channels, one under the other
  std::optional<Discount> discount_;        ///< by what is usual
  Eigen::VectorXd mean_effect_;             ///< stacked columns times the usual mean
};

}  // namespace voltlap::plant
