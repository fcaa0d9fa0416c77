// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/findings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kLeastGain = 0.5;     // of what blocks that were kept back could gain
constexpr double kStable = 4.5;        // standard errors between the halves of a log
constexpr double kCertain = 0.99;      // no probability is said to be higher

const Cause& cause_of(const Judged& j, std::size_t member) {
  return j.causes[static_cast<std::size_t>(j.system.candidates[member].cause)];
}

std::string name_of_candidate(const Judged& j, std::size_t member) {
  const Candidate& c = j.system.candidates[member];
  if (c.cause >= 0) return cause_of(j, member).name;
  return fmt::format("a shape without a name ({})", j.design.columns[static_cast<std::size_t>(c.rows[0])].key.substr(10));
}

std::vector<std::string> names_of(const Judged& j, const std::vector<std::size_t>& members) {
  std::vector<std::string> out;
  for (const std::size_t m : members) out.push_back(name_of_candidate(j, m));
  return out;
}

std::string number_text(const CauseParameter& p, double value, double half) {
  const double v = value * p.shown_scale, h = half * p.shown_scale;
  const int digits = h > 0.0 ? std::clamp(static_cast<int>(std::ceil(1.0 - std::log10(h))), 0, 4) : 2;
  return h > 0.0 ? fmt::format("{:+.{}f} ± {:.{}f} {}", v, digits, h, digits, p.shown_unit)
                 : fmt::format("{:.{}f} {}", v, std::abs(v) >= 100.0 ? 0 : 2, p.shown_unit);
}

std::string channel_words(const std::string& channel) {
  if (channel.starts_with("cell_voltage_")) return "cell " + channel.substr(13);
  if (channel.starts_with("temperature_")) return "thermistor " + channel.substr(12);
  return channel;
}

/// The pattern of the cause's sentence with its numbers.
std::string said(const Cause& cause, const std::string& channel, const std::vector<std::string>& numbers) {
  std::string out = cause.says;
  if (const auto at = out.find("{channel}"); at != std::string::npos) out.replace(at, 9, channel_words(channel));
  for (const std::string& number : numbers) {
    if (const auto at = out.find("{}"); at != std::string::npos) out.replace(at, 2, number);
  }
  return out;
}

/// Interval of a capacity-like ratio needs no more than the linear sigma; reported numbers by differences.
double reported_sigma(const Cause& cause, const RefinedCause& fit, std::size_t k) {
  double square = 0.0;
  for (std::size_t i = 0; i < fit.values.size(); ++i) {
    if (fit.sigma[i] <= 0.0) continue;
    std::vector<double> moved = fit.values;
    moved[i] += fit.sigma[i];
    const double by = cause.report(moved)[k] - cause.report(fit.values)[k];
    square += by * by;
  }
  return std::sqrt(square);
}

FoundCause found_cause(const Judged& j, const RefinedCause& fit) {
  const Candidate& c = j.system.candidates[fit.candidate];
  const Cause& cause = cause_of(j, fit.candidate);
  FoundCause out;
  out.name = cause.name;
  out.d_prime = fit.distance;
  std::vector<std::string> numbers;
  if (c.group >= 0 && c.channel.starts_with("cell_voltage_") && cause.says[1] == 'c') {
    const double cell = std::stod(c.channel.substr(13));
    out.parameters.push_back({"cell", "index", cell, cell, cell, ""});
  }
  if (!c.channel.empty()) out.parameters.push_back({"channel", "name", 0.0, 0.0, 0.0, c.channel});
  const auto add = [&](const CauseParameter& p, double value, double sigma) {
    const double half = 1.96 * sigma;
    out.parameters.push_back({p.name, p.unit, value, value - half, value + half, ""});
    numbers.push_back(number_text(p, value, half));
  };
  if (cause.report) {
    const std::vector<double> values = cause.report(fit.values);
    for (std::size_t k = 0; k < values.size(); ++k) add(cause.reported[k], values[k], reported_sigma(cause, fit, k));
  } else {
    for (std::size_t k = 0; k < cause.parameters.size(); ++k) {
      const bool estimated = fit.sigma[k] > 0.0 || std::string_view(cause.parameters[k].name) == "tau_s";
      if (estimated) {
        add(cause.parameters[k], fit.values[k], fit.sigma[k]);
      } else {
        numbers.push_back("as the others'");
      }
    }
  }
  out.says = said(cause, c.channel, numbers);
  return out;
}

/// Effect of a refined set on channel `c`, in the channel's unit: model with it minus model without.
struct Effects {
  std::vector<VectorXd> channels;
  std::vector<std::vector<VectorXd>> members;  ///< [group][member]
};

Effects effects_of(const Judged& j, const std::vector<RefinedCause>& causes) {
  Effects out;
  World world = j.design.model;
  for (const VectorXd& base : j.design.base.channels) out.channels.push_back(VectorXd::Zero(base.size()));
  for (const Group& group : j.design.comparison.groups) {
    out.members.emplace_back(group.members.size(), VectorXd::Zero(j.design.comparison.log.rows()));
  }
  bool global = false;
  for (const RefinedCause& fit : causes) {
    const Candidate& c = j.system.candidates[fit.candidate];
    if (c.cause < 0) continue;
    const Form& form = j.design.forms[static_cast<std::size_t>(c.cause)][c.form];
    if (form.apply) {
      form.apply(world, fit.values);
      global = true;
      continue;
    }
    const auto g = static_cast<std::size_t>(c.group);
    for (std::size_t k = 0; k < c.shapes.size(); ++k) {
      const double size = fit.values[c.parameters[k]] / cause_of(j, fit.candidate).parameters[c.parameters[k]].typical;
      const VectorXd shape = size * j.design.shapes[g][static_cast<std::size_t>(c.shapes[k])].effect;
      const double share = static_cast<double>(c.members.size()) / static_cast<double>(out.members[g].size());
      for (std::size_t m = 0; m < out.members[g].size(); ++m) {
        const bool own = std::count(c.members.begin(), c.members.end(), static_cast<Index>(m)) > 0;
        out.members[g][m] += shape * ((own ? 1.0 : 0.0) - share);
      }
      const Column& column = j.design.columns[static_cast<std::size_t>(c.rows[k])];
      for (std::size_t n = 0; n < column.effect.size(); ++n) {
        if (column.effect[n].size() > 0) out.channels[n] += size * column.effect[n];
      }
    }
  }
  if (global) {
    const Prediction prediction = predict(world, j.design.comparison);
    for (std::size_t c = 0; c < out.channels.size(); ++c) {
      out.channels[c] += prediction.channels[c] - j.design.base.channels[c];
    }
  }
  return out;
}

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

/// Largest share of a channel's error that one cause takes away.
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

std::string gain_text(const Explanation& out) {
  std::string best;
  double most = 0.0;
  for (const auto& [name, gain] : out.gain) {
    if (gain.before <= 0.0 || 1.0 - gain.after / gain.before <= most) continue;
    most = 1.0 - gain.after / gain.before;
    const bool milli = gain.unit == "V" && gain.before < 0.5;
    const double scale = milli ? 1e3 : 1.0;
    best = fmt::format("with it, {:.3g} become {:.3g} {} of {} error on blocks that it did not see", scale * gain.before,
                       scale * gain.after, milli ? "mV" : gain.unit, channel_words(name));
  }
  return best;
}

void put_runners_up(const Judged& j, Explanation& out) {
  const double best = j.sets.empty() ? 0.0 : j.sets.front().evidence;
  const SetFit fit = fit_set(j.system, j.decision.members);
  for (const WeighedSet& set : j.sets) {
    if (out.runners_up.size() >= 8) break;
    if (set.members == j.decision.members || set.members.size() > j.decision.members.size() + 1) continue;
    RunnerUp rival{names_of(j, set.members), best - set.evidence, ""};
    const bool seen = std::any_of(out.runners_up.begin(), out.runners_up.end(),
                                  [&](const RunnerUp& r) { return r.names == rival.names; });
    if (seen) continue;
    const double shared = overlap(j.system, j.decision.members, fit.coefficients, set.members);
    rival.why = shared > kSameClass ? "the same signature on this log"
                                    : fmt::format("explains {:.0f} % of what the answer explains", 100.0 * shared);
    out.runners_up.push_back(std::move(rival));
  }
}

void name_unknown(const Judged& j, Explanation& out) {
  out.verdict = Verdict::kUnknown;
  double most = -1.0;
  const SetFit fit = fit_set(j.system, j.decision.members);
  Index at = 0;
  for (const std::size_t m : j.decision.members) {
    const Candidate& c = j.system.candidates[m];
    const auto n = static_cast<Index>(c.rows.size());
    const VectorXd own = fit.coefficients.segment(at, n);
    at += n;
    const double weight = own.dot(fit.covariance.block(at - n, at - n, n, n).ldlt().solve(own));
    if (weight > most) {
      most = weight;
      out.unknown_in = c.balance;
    }
  }
  out.sentence = fmt::format("Something is wrong in the {} balance that none of the known causes explains.",
                             name_of(out.unknown_in.value_or(Balance::kVoltage)));
}

void put_no_discrepancy(const std::vector<FoundCause>& gate, Explanation& out) {
  out.causes = gate;
  out.verdict = gate.empty() ? Verdict::kNoDiscrepancy : Verdict::kNamed;
  out.sentence = gate.empty() ? "Nothing is wrong beyond the noise and what this model usually misses."
                              : gate.front().says + ".";
}

/// Why a set that weighs most is not named; empty when nothing speaks against it.
std::string objection(const Judged& j, const RefinedSet& set, const HeldOut& held) {
  for (const RefinedCause& fit : set.causes) {
    if (fit.distance < kSeparation) return "its effect is too small to be sure";
    if (!fit.inside_prior) return "its size is beyond what is physically likely";
  }
  if (j.decision.margin < kDecisive) return "another cause explains the log nearly as well";
  if (!(held.share > kLeastGain) || !(held.low > 0.0)) return "it does not hold on blocks that it did not see";
  if (held.unstable > kStable) return "the two halves of the log disagree about its size";
  if (j.decision.next_gain > kDecisive) return "something more is wrong that it does not explain";
  return "";
}

}  // namespace

void put_verdict(const Judged& j, const std::vector<FoundCause>& gate, Explanation& out) {
  if (j.decision.members.empty()) {
    const RefinedSet none{{}, j.design.model, 0.0};
    measure_gain(j, none, out);
    keep_traces(j, none, out);
    put_no_discrepancy(gate, out);
    return;
  }
  std::vector<std::size_t> members = j.decision.members;
  const bool unknown = j.decision.anonymous && !j.decision.named_rival;
  if (j.decision.anonymous && j.decision.named_rival) members = j.sets[*j.decision.named_rival].members;
  const RefinedSet set = unknown ? RefinedSet{{}, j.design.model, 0.0} : j.refinery.refine(members);
  measure_gain(j, set, out);
  keep_traces(j, set, out);
  put_runners_up(j, out);
  if (unknown) {
    name_unknown(j, out);
    out.causes.insert(out.causes.end(), gate.begin(), gate.end());
    return;
  }
  const HeldOut held = held_out(j.quarters, j.halves, members);
  const std::string why_not =
      j.decision.anonymous ? "a shape that no known cause has explains the log as well" : objection(j, set, held);
  out.verdict = why_not.empty() ? Verdict::kNamed : Verdict::kAmbiguous;
  std::vector<std::pair<double, FoundCause>> causes;
  for (std::size_t k = 0; k < set.causes.size(); ++k) {
    FoundCause found = found_cause(j, set.causes[k]);
    found.share_of_residual = std::clamp(share_of(j, set.causes[k]), 0.0, 1.0);
    found.probability = std::min(kCertain, (1.0 - j.decision.null_probability) / (1.0 + std::exp(-j.decision.margin)));
    if (!why_not.empty()) found.probability = std::min(found.probability, 0.5);
    if (k < j.decision.equivalents.size() && !j.decision.anonymous) {
      for (const std::size_t other : j.decision.equivalents[k]) {
        const std::string name = cause_of(j, other).name;
        if (name != found.name && std::count(found.equivalent_to.begin(), found.equivalent_to.end(), name) == 0) {
          found.equivalent_to.push_back(name);
        }
      }
    }
    causes.emplace_back(found.d_prime, std::move(found));
  }
  std::stable_sort(causes.begin(), causes.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> sentences;
  for (auto& [d, found] : causes) {
    sentences.push_back(found.says);
    out.causes.push_back(std::move(found));
  }
  out.causes.insert(out.causes.end(), gate.begin(), gate.end());
  out.world = set.world;
  std::string text = fmt::format("{}: {:.0f} % of the error", fmt::join(sentences, ", and "),
                                 100.0 * out.causes.front().share_of_residual);
  if (const std::string gained = gain_text(out); !gained.empty()) text += "; " + gained;
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  out.sentence = text + ".";
  if (out.verdict == Verdict::kNamed) return;
  out.sentence = fmt::format("Most likely: {} Not certain: {}.", out.sentence, why_not);
  out.alternatives.push_back(names_of(j, members));
  for (const std::size_t rival : j.decision.rivals) {
    const auto names = names_of(j, j.sets[rival].members);
    if (std::count(out.alternatives.begin(), out.alternatives.end(), names) == 0 && out.alternatives.size() < 4) {
      out.alternatives.push_back(names);
    }
  }
  // The test of the rival's cause that the answer does not share, else of the strongest.
  std::size_t telling = members.front();
  if (!j.decision.rivals.empty()) {
    for (const std::size_t m : j.sets[j.decision.rivals.front()].members) {
      if (std::count(members.begin(), members.end(), m) == 0 && j.system.candidates[m].cause >= 0) telling = m;
    }
  }
  out.next_test = cause_of(j, telling).test;
}

}  // namespace voltlap::plant
