// SPDX-License-Identifier: Apache-2.0
// All sets of up to three candidates, weighed in closed form, and what the weight of the best one is worth when
// nothing is wrong.
//
//   ln evidence(S) = a_S' (A_SS + P^-1)^-1 a_S / 2 - ln det(I + A_SS P) / 2 + sum ln prior
//   P: the smaller of prior_variance and (20 standard errors)^2, the width of a prior that is log-uniform in size
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "discrepancy/candidates.hpp"

namespace voltlap::plant {

struct WeighedSet {
  std::vector<std::size_t> members;  ///< of System::candidates, increasing
  double evidence = 0.0;
  bool named = true;                 ///< holds no anonymous shape
};

/// Best first; at most `keep` sets, all singles included. The empty set has evidence 0.
[[nodiscard]] std::vector<WeighedSet> weigh_sets(const System& system, std::size_t keep);

/// Evidence of one set; nothing where a size would have an impossible sign or exceed what the residual has room for.
[[nodiscard]] std::optional<double> evidence_of_set(const System& system, const std::vector<std::size_t>& members);

/// The system as it counts when sets are weighed: signatures are known to a few percent only, so that no evidence,
/// however strong, tells causes apart whose signatures differ by less; nor is evidence believed that sound logs have too.
///   A, a times 1/(1 + rho L + E/ln 20),  rho: `signature_error`, L: the gain of the best set, E: the best evidence of
///   a sound log
[[nodiscard]] System tempered(const System& system, double usual_evidence, double signature_error);

/// The same log as if all of it were worth so much less.
[[nodiscard]] System scaled(System system, double factor);

/// Of sets of up to two, at least 0.
[[nodiscard]] double best_evidence(const System& system);

/// Rows of the system that a set's candidates have, in the order of its members.
[[nodiscard]] std::vector<Eigen::Index> rows_of(const System& system, const std::vector<std::size_t>& members);

struct SetFit {
  Eigen::VectorXd coefficients;  ///< by column of the set's candidates, typical sizes
  Eigen::MatrixXd covariance;
  double gain = 0.0;             ///< a' A^-1 a of the set
};
[[nodiscard]] SetFit fit_set(const System& system, const std::vector<std::size_t>& members);

/// Sizes of all columns when a set's have these and the others none.
[[nodiscard]] Eigen::VectorXd sizes_of_all(const System& system, const std::vector<std::size_t>& members,
                                           const Eigen::VectorXd& coefficients);

/// Chance that the best evidence of sets of up to two candidates reaches `evidence` when nothing is wrong, by up to
/// `draws` of the null (score N(0, A), its scale uncertain with `freedom` degrees). Where a `level` is given draws end at
/// the first look, one every 20, that is sure at 1 in 200 on which side of the level the chance lies: with 8000 draws
/// chances of 0.5 and 1.5 levels are decided wrongly in 0.2 % of 1500 trials, of 1.2 levels in 12 %.
[[nodiscard]] double null_probability(const System& system, double evidence, double freedom, int draws,
                                      std::uint64_t seed, double level = 0.0);

/// Share of what `of` explains that `by` could explain as well, 0..1.
[[nodiscard]] double overlap(const System& system, const std::vector<std::size_t>& of, const Eigen::VectorXd& coefficients,
                             const std::vector<std::size_t>& by);

}  // namespace voltlap::plant
