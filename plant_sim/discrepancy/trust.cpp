// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/trust.hpp"

#include <algorithm>
#include <cmath>

#include "discrepancy/anonymous_shapes.hpp"
#include "discrepancy/evidence.hpp"
#include "discrepancy/gain.hpp"
#include "discrepancy/verdict.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSlack = 1.2;  // no reference is just like the log

/// The voltage of the cells has shapes that follow the current at once and shapes that do not.
bool is_of_the_cells(const Design& design, std::size_t channel) {
  return channel == 0 && design.comparison.channels[channel].balance == Balance::kVoltage;
}

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

std::pair<double, std::string> times_usual(const Design& design, const std::vector<Reference>& references) {
  std::pair<double, std::string> out{0.0, ""};
  for (std::size_t c = 0; c < design.residual.size(); ++c) {
    const std::string& channel = design.comparison.channels[c].name;
    const double usual = usual_rms(references, channel), here = rms_of(design.residual[c]);
    if (usual > 0.0 && here > out.first * usual) out = {here / usual, channel};
  }
  return out;
}

Trust full_trust(std::size_t channels) {
  const std::vector<double> kins(kKins, 1.0);
  return {std::vector<double>(channels, 1.0), std::vector<std::vector<double>>(channels, kins)};
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

double evidence_of_references(const TrustProblem& problem, const Usual& usual, const Trust& trust, int channel) {
  double most = 0.0;
  for (std::size_t k = 0; k < problem.knowledge.said.size(); ++k) {
    const Remaining sound = reference_by_the_others(problem.design, problem.knowledge, k, trust, channel);
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
      return std::all_of(candidate.rows.begin(), candidate.rows.end(),
                         [&](Index row) { return system.information(row, row) <= 0.0; });
    });
    most = std::max(most, best_evidence(system));
  }
  return most;
}

std::vector<std::vector<double>> widening_by_references(const TrustProblem& problem) {
  std::vector<std::vector<double>> out = full_trust(problem.said.size()).widening;
  for (std::size_t c = 0; c < out.size(); ++c) {
    if (!is_of_the_cells(problem.design, c)) continue;
    for (std::size_t kin = 0; kin < kKins; ++kin) out[c][kin] = is_late_kind(kin) ? 30.0 : 100.0;
  }
  return out;
}

std::vector<double> inflation_by_references(const TrustProblem& problem, const Usual& usual, const Trust& trust) {
  std::vector<double> out(trust.inflation.size(), 1.0);
  for (std::size_t c = 0; c < out.size(); ++c) {
    out[c] += evidence_of_references(problem, usual, trust, static_cast<int>(c)) / kDecisive;
  }
  return out;
}

}  // namespace voltlap::plant
