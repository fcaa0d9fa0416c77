// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/gain.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>

#include "discrepancy/noise.hpp"
#include "discrepancy/score.hpp"
#include "discrepancy/set_effects.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

std::string unit_of(const Group& group) { return group.balance == Balance::kHeat ? "K" : "V"; }

/// Does a cause act on this member of a group by itself?
bool is_named(const Judged& j, const std::vector<RefinedCause>& causes, const std::string& member) {
  return std::any_of(causes.begin(), causes.end(), [&](const RefinedCause& fit) {
    const Candidate& c = j.system.candidates[fit.candidate];
    if (c.group < 0) return false;
    const auto& names = j.design.comparison.groups[static_cast<std::size_t>(c.group)].members;
    return std::any_of(c.members.begin(), c.members.end(),
                       [&](Index m) { return names[static_cast<std::size_t>(m)] == member; });
  });
}

/// Blocks on which gain is measured, and the causes as fitted without them.
struct Fold {
  std::vector<bool> keep;
  std::vector<RefinedCause> causes;
};

/// The refined causes with the linear parameters as another part of the log would have them.
std::vector<RefinedCause> as_fitted_by(const Judged& j, const RefinedSet& set, const System& part) {
  const std::vector<std::size_t> members = members_of(set);
  const VectorXd here = fit_set(part, members).coefficients, all = fit_set(j.system, members).coefficients;
  std::vector<RefinedCause> out = set.causes;
  Index at = 0;
  for (RefinedCause& fit : out) {
    const Candidate& c = j.system.candidates[fit.candidate];
    for (const std::size_t parameter : c.parameters) {
      if (c.cause >= 0) {
        const CauseParameter& p = cause_of(j, fit.candidate).parameters[parameter];
        const bool bends = c.group >= 0 && all(at) != 0.0;  // a member's value is in proportion to its size
        fit.values[parameter] = bends ? fit.values[parameter] * here(at) / all(at)
                                      : fit.values[parameter] + (here(at) - all(at)) * p.typical;
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
    const std::vector<System>& quarters = j.parts.quarters;
    System part = quarters[parity];
    part.information += quarters[parity + 2].information;
    part.score += quarters[parity + 2].score;
    std::vector<bool> keep;
    for (std::size_t b = 0; b < blocks; ++b) keep.push_back(b % 2 != parity);
    out.push_back({keep, as_fitted_by(j, set, part)});
  }
  return out;
}

/// Squares by block of time, before and after.
struct Sums {
  std::map<std::size_t, std::array<double, 3>> blocks;  ///< before, after, rows
  std::string unit;
  double floor = 0.0;
};

void add(Sums& to, const VectorXd& was, const VectorXd& is, const std::vector<std::size_t>& block,
         const std::vector<bool>& keep) {
  for (Index row = 0; row < was.size(); ++row) {
    const std::size_t b = block[static_cast<std::size_t>(row)];
    if (!std::isfinite(was(row)) || !std::isfinite(is(row)) || !keep[b]) continue;
    auto& sums = to.blocks[b];
    sums[0] += was(row) * was(row);
    sums[1] += is(row) * is(row);
    sums[2] += 1.0;
  }
}

/// Jackknife over the blocks.
ChannelGain gain_of(const Sums& sums) {
  std::array<double, 3> all{};
  for (const auto& [block, s] : sums.blocks) {
    for (std::size_t k = 0; k < all.size(); ++k) all[k] += s[k];
  }
  ChannelGain out{std::sqrt(all[0] / all[2]), std::sqrt(all[1] / all[2]), sums.floor, 0.0, 0.0, sums.unit};
  out.floor = std::min(out.floor, out.after);  // the slow part of the noise is known badly; what is left bounds it
  const auto n = static_cast<double>(sums.blocks.size());
  double sum = 0.0, square = 0.0;
  for (const auto& [block, s] : sums.blocks) {
    const double drop = 1.0 - std::sqrt((all[1] - s[1]) / std::max(all[0] - s[0], 1e-300));
    sum += drop;
    square += drop * drop;
  }
  const double spread = std::sqrt(std::max(0.0, square - sum * sum / n) * (n - 1.0) / n);
  const double drop = out.before > 0.0 ? 1.0 - out.after / out.before : 0.0;
  out.drop_low = n > 2.0 ? drop - 1.96 * spread : -1.0;
  out.drop_high = n > 2.0 ? std::min(1.0, drop + 1.96 * spread) : 1.0;
  return out;
}

/// Sums of every channel and of the members that a cause acts on.
void add_all(const Judged& j, const Comparison& on, const std::vector<VectorXd>& residual, const Effects& effects,
             const Fold& fold, std::map<std::string, Sums>& sums) {
  const auto block = block_of_rows(on.log.time_s);
  const auto put = [&](const std::string& name, const std::string& unit, const std::string& noise, const VectorXd& was,
                       const VectorXd& is) {
    Sums& to = sums[name];
    to.unit = unit;
    const auto known = j.noise.find(noise);
    if (known != j.noise.end()) to.floor = noise_rms(known->second);
    add(to, was, is, block, fold.keep);
  };
  for (std::size_t c = 0; c < on.channels.size(); ++c) {
    const BalanceChannel& channel = on.channels[c];
    put(channel.name, channel.unit, channel.name, residual[c], residual[c] - effects.channels[c]);
  }
  for (std::size_t g = 0; g < on.groups.size(); ++g) {
    const Group& group = on.groups[g];
    for (std::size_t m = 0; m < group.members.size(); ++m) {
      if (!is_named(j, fold.causes, group.members[m])) continue;
      put(group.members[m], unit_of(group), group.stem, group.deviation[m], group.deviation[m] - effects.members[g][m]);
    }
  }
}

/// Sizes of a set's columns with what is expected of them beforehand: shapes without a name are many and alike.
VectorXd expected_sizes(const System& system, const std::vector<std::size_t>& members) {
  std::vector<Index> rows;
  for (const std::size_t m : members) {
    rows.insert(rows.end(), system.candidates[m].rows.begin(), system.candidates[m].rows.end());
  }
  Eigen::MatrixXd a = system.information(rows, rows);
  a.diagonal() += system.prior_variance(rows).cwiseInverse();
  return a.ldlt().solve(VectorXd(system.score(rows)));
}

/// What references say that the model misses in a channel, or in a member of a group, of this log.
VectorXd usual_error(const Judged& j, std::size_t channel) {
  VectorXd out = VectorXd::Zero(j.design.comparison.log.rows());
  for (std::size_t k = 0; k < j.design.columns.size(); ++k) {
    const VectorXd& effect = j.design.columns[k].effect[channel];
    if (effect.size() > 0) out += j.usual.mean(static_cast<Index>(k)) * effect;
  }
  return out;
}

VectorXd usual_error(const Judged& j, std::size_t g, std::size_t member) {
  VectorXd out = VectorXd::Zero(j.design.comparison.log.rows());
  for (Index k = 0; k < j.usual.group_mean[g].rows(); ++k) {
    out += j.usual.group_mean[g](k, static_cast<Index>(member)) * j.design.shapes[g][static_cast<std::size_t>(k)].effect;
  }
  return out;
}

/// A channel that holds one sensor against another.
bool is_of_sensors(const BalanceChannel& channel, std::size_t number) {
  return number > 0 && (channel.name == "pack_voltage" || channel.name == "bus_voltage");
}

/// Share of the squares of each channel, and of the members that `named` act on, that causes explain together.
using Shares = std::map<std::string, double>;

Shares explained_by(const Judged& j, const std::vector<RefinedCause>& some, const std::vector<RefinedCause>& named) {
  const Effects effects = effects_of(j, some);
  Shares out;
  const auto put = [&](const std::string& name, const VectorXd& residual, const VectorXd& effect) {
    const double was = rms_of(residual), is = rms_of(residual - effect);
    if (was > 0.0) out[name] = 1.0 - is * is / (was * was);
  };
  const Comparison& on = j.design.comparison;
  for (std::size_t c = 0; c < on.channels.size(); ++c) put(on.channels[c].name, j.design.residual[c], effects.channels[c]);
  for (std::size_t g = 0; g < on.groups.size(); ++g) {
    for (std::size_t m = 0; m < on.groups[g].members.size(); ++m) {
      const std::string& member = on.groups[g].members[m];
      if (is_named(j, named, member)) put(member, on.groups[g].deviation[m], effects.members[g][m]);
    }
  }
  return out;
}

/// Of the orders in which `all` causes can be added, those in which one of them comes after `before` others.
double weight_of(int before, std::size_t all) {
  double out = 1.0 / static_cast<double>(all);
  for (int k = 0; k < before; ++k) out *= static_cast<double>(k + 1) / static_cast<double>(all - 1 - static_cast<std::size_t>(k));
  return out;
}

}  // namespace

double rms_of(const VectorXd& values) {
  double square = 0.0, count = 0.0;
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    square += v * v;
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(square / count) : 0.0;
}

double noise_rms(const Noise& noise) { return std::hypot(noise.white, noise.coloured); }

void measure_gain(const Judged& j, const RefinedSet& set, Explanation& out) {
  std::map<std::string, Sums> sums;
  if (j.holdout != nullptr) {
    const auto blocks = block_of_rows(j.holdout->log.time_s).back() + 1;
    const Fold whole{std::vector<bool>(blocks, true), set.causes};
    add_all(j, *j.holdout, residuals_of(*j.holdout, predict(j.design.model, *j.holdout)),
            effects_on(j, set.causes, *j.holdout), whole, sums);
  } else {
    const Comparison& on = j.design.comparison;
    for (const Fold& fold : folds_of(j, set, block_of_rows(on.log.time_s).back() + 1)) {
      add_all(j, on, j.design.residual, effects_of(j, fold.causes), fold, sums);
    }
  }
  for (const auto& [name, of] : sums) {
    if (!of.blocks.empty()) out.gain[name] = gain_of(of);
  }
}

Pays pays(const Judged& j, const std::vector<std::size_t>& members, const std::vector<std::size_t>& beside) {
  constexpr double kLeast = 0.05;  // of the RMS
  const Comparison& on = j.design.comparison;
  std::vector<std::size_t> all = beside;
  all.insert(all.end(), members.begin(), members.end());
  const VectorXd sizes = expected_sizes(j.system, all);
  Index first = 0;
  for (const std::size_t m : beside) first += static_cast<Index>(j.system.candidates[m].rows.size());
  const Effects others = linear_effects(j, beside, sizes.head(first)),
                whole = linear_effects(j, members, sizes.tail(sizes.size() - first));
  bool modelled = false;
  for (std::size_t c = 0; c < on.channels.size(); ++c) {
    modelled = modelled || (!is_of_sensors(on.channels[c], c) && rms_of(whole.channels[c]) > 0.0);
  }
  if (!modelled) return Pays::kPlainly;
  std::map<std::string, Sums> plain, corrected, whitened;
  const auto block = block_of_rows(on.log.time_s);
  std::vector<bool> keep(block.back() + 1, true);
  for (std::size_t b = 0; b < j.use.size(); ++b) keep[b] = !j.use[b];
  const auto put = [&](const std::string& name, const std::string& noise, const VectorXd& ohm, const VectorXd& was,
                       const VectorXd& usual, const VectorXd& effect) {
    if (rms_of(effect) == 0.0) return;
    const VectorXd unusual = was - usual;
    const Whitener filter(on.log.time_s, finite_rows(unusual), j.noise.at(noise), ohm);
    add(plain[name], was, was - effect, block, keep);
    add(corrected[name], unusual, unusual - effect, block, keep);
    add(whitened[name], filter.apply(unusual), filter.apply(unusual - effect), block, keep);
  };
  for (std::size_t c = 0; c < on.channels.size(); ++c) {
    const std::string& name = on.channels[c].name;
    put(name, name, ohm_of(j.design, c), j.design.residual[c] - others.channels[c], usual_error(j, c),
        whole.channels[c]);
  }
  for (std::size_t g = 0; g < on.groups.size(); ++g) {
    const Group& group = on.groups[g];
    for (std::size_t m = 0; m < group.members.size(); ++m) {
      put(group.members[m], group.stem, {}, group.deviation[m] - others.members[g][m], usual_error(j, g, m),
          whole.members[g][m]);
    }
  }
  const auto by = [&](const std::map<std::string, Sums>& errors, double least) {
    return std::any_of(errors.begin(), errors.end(), [&](const auto& channel) {
      if (channel.second.blocks.empty()) return false;
      const ChannelGain gain = gain_of(channel.second);
      return gain.after < (1.0 - least) * gain.before && gain.drop_low > 0.0;
    });
  };
  if (by(plain, kLeast) || by(corrected, kLeast)) return Pays::kPlainly;
  return by(whitened, 0.0) ? Pays::kInNoise : Pays::kNot;
}

std::vector<double> shares_of(const Judged& j, const std::vector<RefinedCause>& causes) {
  const std::size_t subsets = std::size_t{1} << causes.size();
  std::vector<Shares> of;
  for (std::size_t subset = 0; subset < subsets; ++subset) {
    std::vector<RefinedCause> some;
    for (std::size_t k = 0; k < causes.size(); ++k) {
      if ((subset >> k & 1U) != 0) some.push_back(causes[k]);
    }
    of.push_back(explained_by(j, some, causes));
  }
  std::vector<double> out(causes.size(), 0.0);
  for (std::size_t k = 0; k < causes.size(); ++k) {
    for (const auto& [channel, unused] : of.back()) {
      double share = 0.0;
      for (std::size_t subset = 0; subset < subsets; ++subset) {
        if ((subset >> k & 1U) != 0) continue;
        share += weight_of(std::popcount(subset), causes.size()) * (of[subset | std::size_t{1} << k].at(channel) - of[subset].at(channel));
      }
      out[k] = std::max(out[k], std::min(share, 1.0));
    }
  }
  return out;
}

double share_together(const Judged& j, const std::vector<RefinedCause>& causes) {
  double most = 0.0;
  for (const auto& [channel, share] : explained_by(j, causes, causes)) most = std::max(most, share);
  return most;
}

void keep_traces(const Judged& j, const RefinedSet& set, Explanation& out) {
  const Effects effects = effects_of(j, set.causes);
  const Comparison& on = j.design.comparison;
  const auto keep = [&](const std::string& name, const std::string& unit, const std::string& noise, bool member,
                        const VectorXd& was, const VectorXd& effect) {
    const VectorXd is = was - effect;
    out.traces.push_back({name, unit, std::min(noise_rms(j.noise.at(noise)), rms_of(is)), member, was, is});
  };
  for (std::size_t c = 0; c < on.channels.size(); ++c) {
    const BalanceChannel& channel = on.channels[c];
    keep(channel.name, channel.unit, channel.name, false, j.design.residual[c], effects.channels[c]);
  }
  for (std::size_t g = 0; g < on.groups.size(); ++g) {
    const Group& group = on.groups[g];
    for (std::size_t m = 0; m < group.members.size(); ++m) {
      keep(group.members[m], unit_of(group), group.stem, true, group.deviation[m], effects.members[g][m]);
    }
  }
  const BatteryResponse& battery = j.design.base.battery;
  const bool measured = on.facts.temperature_c.size() > 0;
  out.circumstances = {on.log.time_s, *on.log.find("current"), battery.soc,
                       measured ? on.facts.temperature_c : battery.temperature_c, {}};
  if (const VectorXd* speed = on.log.find("speed")) out.circumstances.speed_mps = *speed;
}

}  // namespace voltlap::plant
