// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/trust.hpp"

#include <algorithm>
#include <cmath>

#include "discrepancy/evidence.hpp"
#include "discrepancy/gain.hpp"
#include "discrepancy/verdict.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSlack = 1.2;  // no reference is just like the log

}  // namespace

double usual_rms(const std::vector<Reference>& references, const std::string& channel) {
  double out = 0.0;
  for (const Reference& reference : references) {
    const auto& theirs = reference.design->comparison.channels;
    for (std::size_t c = 0; c < theirs.size(); ++c) {
      if (theirs[c].name == channel) out = std::max(out, rms_of(reference.design->residual[c]));
    }
  }
  return out;
}

std::pair<double, std::string> times_usual(const Design& design, const std::vector<Reference>& references,
                                           std::optional<Balance> of) {
  std::pair<double, std::string> out{0.0, ""};
  for (std::size_t c = 0; c < design.residual.size(); ++c) {
    const std::string& channel = design.comparison.channels[c].name;
    if (of && design.comparison.channels[c].balance != *of) continue;
    const double usual = usual_rms(references, channel), here = rms_of(design.residual[c]);
    if (usual > 0.0 && here > out.first * usual) out = {here / usual, channel};
  }
  return out;
}

std::vector<Bound> bounds_of(const std::vector<BlockSum>& channels, const Knowledge& knowledge, int without) {
  std::vector<Bound> out;
  for (std::size_t c = 0; c < channels.size() && !knowledge.said.empty(); ++c) {
    double usual = 0.0;
    for (std::size_t k = 0; k < knowledge.said.size(); ++k) {
      const BlockSum& theirs = knowledge.said[k][c];
      if (static_cast<int>(k) == without || theirs.rows <= 0.0) continue;
      usual = std::max(usual, std::sqrt(theirs.energy / theirs.rows));
    }
    const double length = kSlack * (std::sqrt(channels[c].energy) + usual * std::sqrt(channels[c].rows));
    out.push_back({channels[c].gram, length * length});
  }
  return out;
}

bool has_room(const Design& design, const std::vector<Reference>& references, const NoiseModel& noise,
              const World& refined) {
  if (references.empty()) return true;
  const Comparison& on = design.comparison;
  const std::vector<VectorXd> left = residuals_of(on, predict(refined, on));
  for (std::size_t c = 0; c < left.size(); ++c) {
    const std::string& name = on.channels[c].name;
    const double most = kSlack * (rms_of(design.residual[c]) + usual_rms(references, name)) + noise_rms(noise.at(name));
    if (rms_of(design.residual[c] - left[c]) > most) return false;
  }
  return true;
}

double evidence_of_references(const TrustProblem& problem, const Usual& usual, const std::vector<double>& inflation,
                              int channel, Asked asked) {
  double most = 0.0;
  for (std::size_t k = 0; k < problem.knowledge.said.size(); ++k) {
    const Remaining sound = reference_by_the_others(problem.design, problem.knowledge, k, inflation, channel);
    BlockSum sum = empty_sum(sound.score.size());
    sum.gram = sound.information;
    sum.score = sound.score;
    Usual seen;
    seen.mean = VectorXd::Zero(sum.score.size());
    seen.variance = usual.seen.asDiagonal();
    Remaining left = remaining(sum, seen);
    System system{problem.system.candidates, std::move(left.information), std::move(left.score),
                  problem.system.prior_variance,
                  bounds_of(problem.knowledge.said[k], problem.knowledge, static_cast<int>(k))};
    std::erase_if(system.candidates, [&](const Candidate& candidate) {
      if (asked == Asked::kNotOfAllCells && candidate.of_all_cells) return true;
      return std::all_of(candidate.rows.begin(), candidate.rows.end(),
                         [&](Index row) { return system.information(row, row) <= 0.0; });
    });
    most = std::max(most, best_evidence(system));
  }
  return most;
}

std::vector<double> inflation_by_references(const TrustProblem& problem, const Usual& usual) {
  const std::vector<double> none(problem.said.size(), 1.0);
  std::vector<double> out = none;
  for (std::size_t c = 0; c < out.size(); ++c) {
    out[c] += evidence_of_references(problem, usual, none, static_cast<int>(c)) / kDecisive;
  }
  return out;
}

}  // namespace voltlap::plant
