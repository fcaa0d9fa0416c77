// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/gain.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "discrepancy/set_effects.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

double rms(const VectorXd& values, const std::vector<std::size_t>& block, const std::vector<bool>& keep) {
  double square = 0.0, count = 0.0;
  for (Index row = 0; row < values.size(); ++row) {
    if (!std::isfinite(values(row)) || !keep[block[static_cast<std::size_t>(row)]]) continue;
    square += values(row) * values(row);
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(square / count) : 0.0;
}

/// Blocks on which gain is measured, and the causes as fitted without them.
struct Fold {
  std::vector<bool> keep;
  std::vector<RefinedCause> causes;
};

/// The refined causes with the linear parameters as another part of the log would have them.
std::vector<RefinedCause> as_fitted_by(const Judged& j, const RefinedSet& set, const System& part) {
  std::vector<std::size_t> members;
  for (const RefinedCause& fit : set.causes) members.push_back(fit.candidate);
  const VectorXd here = fit_set(part, members).coefficients, all = fit_set(j.system, members).coefficients;
  std::vector<RefinedCause> out = set.causes;
  Index at = 0;
  for (RefinedCause& fit : out) {
    const Candidate& c = j.system.candidates[fit.candidate];
    for (const std::size_t parameter : c.parameters) {
      if (c.cause >= 0) {
        const CauseParameter& p = cause_of(j, fit.candidate).parameters[parameter];
        fit.values[parameter] += (here(at) - all(at)) * p.typical;
        if (c.group < 0) fit.values[parameter] = std::clamp(fit.values[parameter], p.low, p.high);
      }
      ++at;
    }
  }
  return out;
}

std::vector<Fold> folds_of(const Judged& j, const RefinedSet& set, std::size_t blocks) {
  std::vector<Fold> out;
  if (!j.use.empty()) {  // fitted on one half on purpose: the other half is the one that counts
    std::vector<bool> others;
    for (const bool used : j.use) others.push_back(!used);
    out.push_back({others, set.causes});
    return out;
  }
  for (std::size_t parity = 0; parity < 2; ++parity) {
    System part = j.quarters[parity];
    part.information += j.quarters[parity + 2].information;
    part.score += j.quarters[parity + 2].score;
    std::vector<bool> keep;
    for (std::size_t b = 0; b < blocks; ++b) keep.push_back(b % 2 != parity);
    out.push_back({keep, as_fitted_by(j, set, part)});
  }
  return out;
}

}  // namespace

void measure_gain(const Judged& j, const RefinedSet& set, Explanation& out) {
  const Comparison& on = j.design.comparison;
  const auto block = block_of_rows(on.log.time_s);
  const std::size_t blocks = block.back() + 1;
  std::map<std::string, double> before, after, count;
  const auto put = [&](const std::string& name, const std::string& unit, const VectorXd& was, const VectorXd& is,
                       const Noise& noise, const std::vector<bool>& keep) {
    ChannelGain& gain = out.gain[name];
    gain.unit = unit;
    gain.floor = std::hypot(noise.white, noise.coloured);
    before[name] += std::pow(rms(was, block, keep), 2);
    after[name] += std::pow(rms(is, block, keep), 2);
    count[name] += 1.0;
  };
  for (const Fold& fold : folds_of(j, set, blocks)) {
    const Effects effects = effects_of(j, fold.causes);
    for (std::size_t c = 0; c < on.channels.size(); ++c) {
      put(on.channels[c].name, on.channels[c].unit, j.design.residual[c], j.design.residual[c] - effects.channels[c],
          j.noise.at(on.channels[c].name), fold.keep);
    }
    for (const RefinedCause& fit : fold.causes) {
      const Candidate& c = j.system.candidates[fit.candidate];
      if (c.group < 0) continue;
      const auto g = static_cast<std::size_t>(c.group);
      for (const Index m : c.members) {
        const auto at = static_cast<std::size_t>(m);
        const Group& group = on.groups[g];
        put(group.members[at], group.balance == Balance::kHeat ? "K" : "V", group.deviation[at],
            group.deviation[at] - effects.members[g][at], j.noise.at(group.stem), fold.keep);
      }
    }
  }
  for (auto& [name, gain] : out.gain) {
    gain.before = std::sqrt(before[name] / count[name]);
    gain.after = std::sqrt(after[name] / count[name]);
  }
}

double share_of(const Judged& j, const RefinedCause& fit) {
  const Effects effects = effects_of(j, {fit});
  const auto block = block_of_rows(j.design.comparison.log.time_s);
  const std::vector<bool> all(block.back() + 1, true);
  double most = 0.0;
  const auto consider = [&](const VectorXd& residual, const VectorXd& effect) {
    if (effect.cwiseAbs().maxCoeff() <= 0.0) return;
    const double was = rms(residual, block, all), is = rms(residual - effect, block, all);
    if (was > 0.0) most = std::max(most, 1.0 - is * is / (was * was));
  };
  for (std::size_t c = 0; c < j.design.residual.size(); ++c) consider(j.design.residual[c], effects.channels[c]);
  const Candidate& candidate = j.system.candidates[fit.candidate];
  if (candidate.group >= 0) {
    const auto g = static_cast<std::size_t>(candidate.group);
    for (const Index m : candidate.members) {
      const auto at = static_cast<std::size_t>(m);
      consider(j.design.comparison.groups[g].deviation[at], effects.members[g][at]);
    }
  }
  return most;
}

void keep_traces(const Judged& j, const RefinedSet& set, Explanation& out) {
  const Effects effects = effects_of(j, set.causes);
  const Comparison& on = j.design.comparison;
  for (std::size_t c = 0; c < on.channels.size(); ++c) {
    out.traces.push_back({on.channels[c].name, on.channels[c].unit, on.log.time_s, j.design.residual[c],
                          j.design.residual[c] - effects.channels[c]});
  }
  for (const RefinedCause& fit : set.causes) {
    const Candidate& c = j.system.candidates[fit.candidate];
    if (c.group < 0) continue;
    const Group& group = on.groups[static_cast<std::size_t>(c.group)];
    for (const Index m : c.members) {
      const auto at = static_cast<std::size_t>(m);
      const auto g = static_cast<std::size_t>(c.group);
      out.traces.push_back({group.members[at], group.balance == Balance::kHeat ? "K" : "V", on.log.time_s,
                            group.deviation[at], group.deviation[at] - effects.members[g][at]});
    }
  }
}

}  // namespace voltlap::plant
