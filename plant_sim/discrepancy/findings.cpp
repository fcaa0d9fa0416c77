// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/findings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "discrepancy/found_cause.hpp"
#include "discrepancy/gain.hpp"
#include "discrepancy/named_part.hpp"
#include "discrepancy/set_effects.hpp"
#include "discrepancy/trust.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kLeastGain = 0.5;     // of what blocks that were kept back could gain
constexpr double kStable = 4.5;        // standard errors between the halves of a log
constexpr double kCancelling = 2.5;    // effect of one cause over that of all together
constexpr double kMaterial = 0.1;      // of an RMS: a part that matters
constexpr double kLeastShare = 0.05;   // of the squares of an error, that an answer without a gain must explain
constexpr double kMostOfIt = 0.5;      // of what a shape without a name explains
/// Than any reference's: 9 of 234 sound logs of the bank; one of them has a null below the level.
constexpr double kLargerError = 2.0;
constexpr double kInNoiseOnly = 2.0 * kDecisive;  // evidence of what no plain error shows
constexpr double kCertain = 0.99;      // no probability is said to be higher

std::string gain_text(const Explanation& out) {
  std::string best;
  double most = 0.005;  // less is not seen in three digits
  for (const auto& [name, gain] : out.gain) {
    if (gain.before <= 0.0 || 1.0 - gain.after / gain.before <= most) continue;
    most = 1.0 - gain.after / gain.before;
    const bool milli = gain.unit == "V" && gain.before < 0.5;
    const double scale = milli ? 1e3 : 1.0;
    best = fmt::format("with it, {:.3g} become {:.3g} {} of {} error on blocks that it did not see",
                       scale * gain.before, scale * gain.after, milli ? "mV" : gain.unit, channel_words(name));
  }
  return best;
}

/// Why a set lost.
std::string why_it_lost(const Judged& j, const WeighedSet& rival, const SetFit& fit) {
  const std::vector<std::size_t>& answer = j.decision.members;
  const bool holds_answer = std::all_of(answer.begin(), answer.end(), [&](std::size_t m) {
    return std::count(rival.members.begin(), rival.members.end(), m) > 0;
  });
  if (holds_answer) return "the answer with something more that the log does not show";
  const double shared = overlap(j.system, answer, fit.coefficients, rival.members);
  return shared > kSameClass ? "nearly the same signature on this log"
                             : fmt::format("could explain {:.0f} % of what the answer explains", 100.0 * shared);
}

void put_runners_up(const Judged& j, Explanation& out) {
  const double best = j.sets.empty() ? 0.0 : j.sets.front().evidence;
  const SetFit fit = fit_set(j.system, j.decision.members);
  for (const WeighedSet& set : j.sets) {
    if (out.runners_up.size() >= 8) break;
    if (set.members == j.decision.members || set.members.size() > j.decision.members.size() + 1) continue;
    const std::vector<std::string> names = names_of(j, set.members);
    const bool seen = std::any_of(out.runners_up.begin(), out.runners_up.end(),
                                  [&](const RunnerUp& r) { return r.names == names; });
    if (!seen) out.runners_up.push_back({names, best - set.evidence, why_it_lost(j, set, fit)});
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

/// Do causes of the set undo each other? Then they follow a shape that none of them is, by their difference.
bool cancel_each_other(const Judged& j, const RefinedSet& set) {
  if (set.causes.size() < 2) return false;
  const Effects all = effects_of(j, set.causes);
  for (const RefinedCause& fit : set.causes) {
    const Effects one = effects_of(j, {fit});
    for (std::size_t c = 0; c < one.channels.size(); ++c) {
      const double floor = noise_rms(j.noise.at(j.design.comparison.channels[c].name));
      if (rms_of(one.channels[c]) > kCancelling * std::max(rms_of(all.channels[c]), floor)) return true;
    }
    for (std::size_t g = 0; g < one.members.size(); ++g) {
      for (std::size_t m = 0; m < one.members[g].size(); ++m) {
        const double floor = noise_rms(j.noise.at(j.design.comparison.groups[g].stem));
        if (rms_of(one.members[g][m]) > kCancelling * std::max(rms_of(all.members[g][m]), floor)) return true;
      }
    }
  }
  return false;
}

/// Why a set that weighs most is not named; empty when nothing speaks against it.
std::string objection(const Judged& j, const RefinedSet& set, const HeldOut& held) {
  for (const RefinedCause& fit : set.causes) {
    if (fit.distance < kSeparation) return "its effect is too small to be sure";
    if (!fit.inside_prior) return "its size is beyond what is physically likely";
    const std::vector<std::size_t>& sizes = j.system.candidates[fit.candidate].parameters;
    const bool one = sizes.size() == 1;  // of a curve with several nodes one may be nothing
    if (one && std::abs(fit.values[sizes[0]]) < 1.96 * fit.sigma[sizes[0]]) return "its size could as well be nothing";
  }
  if (cancel_each_other(j, set)) return "its causes undo each other";
  const bool each_has_to_pay = j.usual.references > 0 && set.causes.size() > 1;  // one alone has paid
  for (const RefinedCause& fit : set.causes) {
    std::vector<std::size_t> others = members_of(set);
    std::erase(others, fit.candidate);
    if (each_has_to_pay && pays(j, {fit.candidate}, others) == Pays::kNot) return "one of its causes makes no error smaller";
  }
  if (j.decision.margin < kDecisive) return "another cause explains the log nearly as well";
  if (!(held.share > kLeastGain) || !(held.low > 0.0)) return "it does not hold on blocks that it did not see";
  if (held.unstable > kStable) return "the two halves of the log disagree about its size";
  if (j.decision.next_gain > kLarger) return "something more is wrong that it does not explain";
  return "";
}

/// The refined world, with what is in single cells put into its car.
World world_with_cells(const Judged& j, const RefinedSet& set) {
  World out = set.world;
  for (const RefinedCause& fit : set.causes) {
    const Candidate& c = j.system.candidates[fit.candidate];
    if (c.cause < 0 || c.group < 0 || !cause_of(j, fit.candidate).extend) continue;
    const Group& group = j.design.comparison.groups[static_cast<std::size_t>(c.group)];
    for (const Index m : c.members) {
      const std::string number = group.members[static_cast<std::size_t>(m)].substr(group.stem.size());
      cause_of(j, fit.candidate).extend(out.car, std::stoul(number) - 1, fit.values);
    }
  }
  return out;
}

/// The candidates that could stand in a member's place, by the names of their causes.
std::vector<std::string> equivalents_of(const Judged& j, std::size_t k, const std::string& own) {
  std::vector<std::string> out;
  if (k >= j.decision.equivalents.size() || j.decision.anonymous) return out;
  for (const std::size_t other : j.decision.equivalents[k]) {
    const std::string name = cause_of(j, other).name;
    if (name != own && std::count(out.begin(), out.end(), name) == 0) out.push_back(name);
  }
  return out;
}

/// Strongest first.
std::vector<FoundCause> found_causes(const Judged& j, const RefinedSet& set, bool named) {
  std::vector<FoundCause> out;
  const std::vector<double> shares = shares_of(j, set.causes);
  for (std::size_t k = 0; k < set.causes.size(); ++k) {
    FoundCause found = found_cause(j, set.causes[k]);
    found.share_of_residual = shares[k];
    found.probability = std::min(kCertain, (1.0 - j.decision.null_probability) / (1.0 + std::exp(-j.decision.margin)));
    if (!named) found.probability = std::min(found.probability, 0.5);
    found.equivalent_to = equivalents_of(j, k, found.name);
    out.push_back(std::move(found));
  }
  std::stable_sort(out.begin(), out.end(), [](const FoundCause& a, const FoundCause& b) {
    return std::pair(a.share_of_residual, a.d_prime) > std::pair(b.share_of_residual, b.d_prime);
  });
  return out;
}

/// `share`: of the squares, by all of them together.
std::string sentence_of(const std::vector<FoundCause>& causes, double share, const std::string& gained) {
  std::vector<std::string> says;
  for (const FoundCause& cause : causes) says.push_back(cause.says);
  constexpr double kShown = 0.005;  // of the error
  std::string text = fmt::format("{}", fmt::join(says, ", and "));
  if (share >= kShown) text += fmt::format(": {:.0f} % of the error", 100.0 * share);
  if (!gained.empty()) text += "; " + gained;
  if (share < kShown && gained.empty()) text += "; the error as a whole is no smaller with it";
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text + ".";
}

void put_alternatives(const Judged& j, const std::vector<std::size_t>& members, Explanation& out) {
  out.alternatives.push_back(names_of(j, members));
  for (const std::size_t rival : j.decision.rivals) {
    const auto names = names_of(j, j.sets[rival].members);
    if (std::count(out.alternatives.begin(), out.alternatives.end(), names) == 0 && out.alternatives.size() < 4) {
      out.alternatives.push_back(names);
    }
  }
}

/// The test of the rival's cause that the answer does not share, else of the strongest.
std::string telling_test(const Judged& j, const std::vector<std::size_t>& members) {
  std::size_t telling = members.front();
  if (!j.decision.rivals.empty()) {
    for (const std::size_t m : j.sets[j.decision.rivals.front()].members) {
      if (std::count(members.begin(), members.end(), m) == 0 && j.system.candidates[m].cause >= 0) telling = m;
    }
  }
  return cause_of(j, telling).test;
}

/// Is a channel worse with the answer, where it was not fitted?
bool makes_worse(const Explanation& out) {
  return std::any_of(out.gain.begin(), out.gain.end(), [](const auto& channel) {
    return channel.second.after > (1.0 + kMaterial) * channel.second.before;
  });
}

/// Is a channel smaller by a part that matters, for sure?
bool makes_better(const Explanation& out) {
  return std::any_of(out.gain.begin(), out.gain.end(), [](const auto& channel) {
    const ChannelGain& gain = channel.second;
    return gain.after < (1.0 - kMaterial) * gain.before && gain.drop_low > 0.0;
  });
}

/// Is what remains of the channels that became smaller near their noise?
bool is_clean(const Explanation& out) {
  constexpr double kNear = 5.0;
  return std::none_of(out.gain.begin(), out.gain.end(), [](const auto& channel) {
    const ChannelGain& gain = channel.second;
    return gain.after < (1.0 - kMaterial) * gain.before && gain.after > kNear * gain.floor;
  });
}

void put_set(const RefinedSet& set, const Judged& j, Explanation& out) {
  out.gain.clear();
  out.traces.clear();
  measure_gain(j, set, out);
  keep_traces(j, set, out);
}

/// The set that weighs most, or the best with names only, and its share of the error. False when the error is larger
/// with it; references know what the model always misses, which an RMS does not.
bool put_named_set(const Judged& j, Explanation& out, double& share) {
  const std::vector<std::size_t> members =
      j.decision.anonymous ? j.sets[*j.decision.named_rival].members : j.decision.members;
  const RefinedSet set = j.refinery.refine(members);
  put_set(set, j, out);
  if (!out.with_references && makes_worse(out) && !makes_better(out)) return false;
  std::string why_not = j.decision.anonymous ? "a shape that no known cause has explains the log as well"
                                             : objection(j, set, held_out(j.parts, members));
  if (why_not.empty() && !out.with_references && !is_clean(out)) why_not = "what remains is far above the noise";
  out.verdict = why_not.empty() ? Verdict::kNamed : Verdict::kAmbiguous;
  out.causes = found_causes(j, set, why_not.empty());
  share = share_together(j, set.causes);
  out.sentence = sentence_of(out.causes, share, gain_text(out));
  out.world = world_with_cells(j, set);
  if (out.verdict == Verdict::kNamed) return true;
  out.sentence = fmt::format("Most likely: {} Not certain: {}.", out.sentence, why_not);
  put_alternatives(j, members, out);
  out.next_test = telling_test(j, members);
  return true;
}

/// The set of named causes that explains most in plain units, with its sizes; none when all are beyond their priors.
std::optional<RefinedSet> largest_named_part(const Judged& j, PlainView& view, const Refinery& refinery,
                                             Decision& decision) {
  constexpr int kTried = 8;
  for (int tried = 0; tried < kTried && !view.sets.empty() && view.sets[0].evidence > 0.0; ++tried) {
    decision = choose(view.system, view.sets, kDecisive);
    decision.null_probability = j.decision.null_probability;
    RefinedSet set = refinery.refine(decision.members);
    const bool possible = std::all_of(set.causes.begin(), set.causes.end(),
                                      [](const RefinedCause& fit) { return fit.inside_prior; });
    if (possible) {
      widen_by_minutes(view, j, set);
      return set;
    }
    std::erase_if(view.sets, [&](const WeighedSet& s) { return s.members == decision.members; });
  }
  return std::nullopt;
}

/// Share of what the answer without a name explains, noise and all, that these explain too. What is slow weighs little
/// there: an offset that only takes the mean of an error says little of it.
double shared_with_unknown(const Judged& j, const std::vector<std::size_t>& members) {
  return overlap(j.system, j.decision.members, fit_set(j.system, j.decision.members).coefficients, members);
}

/// Does it take nearly all of the squares of a channel of the balance that has no name?
bool is_nearly_all(const Judged& j, const Explanation& out, Balance balance) {
  constexpr double kNearly = 0.9;
  return std::any_of(out.gain.begin(), out.gain.end(), [&](const auto& channel) {
    const auto& [name, gain] = channel;
    const BalanceChannel* known = j.design.comparison.find(name);
    return known != nullptr && known->balance == balance && gain.drop_low > 0.0 &&
           gain.after * gain.after < (1.0 - kNearly) * gain.before * gain.before;
  });
}

/// Of an error that has no name as a whole, the part that named causes explain, if that holds where it was not fitted.
void put_named_part(const Judged& j, Explanation& out) {
  PlainView view = plain_view(j);
  const Refinery refinery = plain_refinery(j, view);
  Decision decision;
  const std::optional<RefinedSet> set = largest_named_part(j, view, refinery, decision);
  if (!set) return;
  const Judged plain{j.causes, j.design,  j.locals, view.system, j.noise,  view.usual,
                     j.use,    view.sets, decision, view.parts,  refinery, j.holdout};
  Explanation part;
  measure_gain(plain, *set, part);
  if (makes_worse(part) || !makes_better(part)) return;
  if (shared_with_unknown(j, decision.members) < kMostOfIt && !is_nearly_all(j, part, *out.unknown_in)) return;
  keep_traces(plain, *set, part);
  put_runners_up(plain, part);
  put_alternatives(plain, decision.members, part);
  out.verdict = Verdict::kAmbiguous;
  out.gain = part.gain;
  out.traces = part.traces;
  out.runners_up = part.runners_up;
  out.alternatives = part.alternatives;
  out.causes = found_causes(plain, *set, false);
  out.sentence = fmt::format("A part of it: {} What remains in the {} balance none of the known causes explains.",
                             sentence_of(out.causes, share_together(plain, set->causes), gain_text(out)),
                             name_of(*out.unknown_in));
  out.next_test = telling_test(plain, decision.members);
  out.world = world_with_cells(plain, *set);
}

/// What errors become by what was decided on, as it was weighed or as it was refined.
Pays decision_pays(const Judged& j) {
  const std::optional<std::size_t>& rival = j.decision.named_rival;
  const Pays own = pays(j, j.decision.members), theirs = rival ? pays(j, j.sets[*rival].members) : Pays::kNot;
  const Pays weighed = std::max(own, theirs);
  if (weighed == Pays::kPlainly || (j.decision.anonymous && !rival)) return weighed;
  Explanation trial;
  measure_gain(j, j.refinery.refine(rival ? j.sets[*rival].members : j.decision.members), trial);
  return makes_better(trial) ? Pays::kPlainly : weighed;
}

}  // namespace

void put_verdict(const Judged& j, const std::vector<Reference>& references, const std::vector<FoundCause>& gate,
                 Explanation& out) {
  // References tell what the model always misses only in part: evidence that no error becomes smaller by is theirs.
  const Pays paid = !out.with_references || j.decision.members.empty() ? Pays::kPlainly : decision_pays(j);
  const bool too_little = paid == Pays::kInNoise && j.sets.front().evidence < kInNoiseOnly;
  // In the balance of what stands out; an error elsewhere, however large, is not what it is.
  double times = 0.0;
  std::string larger;
  for (const std::size_t m : j.decision.members) {
    const auto [here, channel] = times_usual(j.design, references, j.system.candidates[m].balance);
    if (here > times) times = here, larger = channel;
  }
  const bool hidden = paid == Pays::kNot && times > kLargerError;
  if (j.decision.members.empty() || (paid == Pays::kNot && !hidden) || too_little) {
    put_set({{}, j.design.model, 0.0}, j, out);
    return put_no_discrepancy(gate, out);
  }
  const Explanation before = out;
  put_runners_up(j, out);
  // An error far above any reference's is there, even where the shapes that show it do not make it smaller.
  const bool unknown = hidden || (j.decision.anonymous && !j.decision.named_rival);
  double share = 0.0;
  const bool named = !unknown && put_named_set(j, out, share);
  // What no error shows, here or on other blocks, is said by the references alone.
  if (named && out.with_references && paid == Pays::kPlainly && gain_text(out).empty() && share < kLeastShare) {
    out = before;
    put_set({{}, j.design.model, 0.0}, j, out);
    return put_no_discrepancy(gate, out);
  }
  if (!named) {
    put_set({{}, j.design.model, 0.0}, j, out);
    name_unknown(j, out);
    if (hidden) out.sentence += fmt::format(" The {} error is {:.1f} times that of any reference.", channel_words(larger), times);
    put_named_part(j, out);
  }
  out.causes.insert(out.causes.end(), gate.begin(), gate.end());
}

void note_larger_than_references(const Design& design, const std::vector<Reference>& references, Explanation& out) {
  if (out.verdict != Verdict::kNoDiscrepancy || references.empty()) return;
  const auto mean_c = [](const Design& of) { return of.base.battery.temperature_c.mean(); };
  const auto [times, name] = times_usual(design, references);
  constexpr double kMuchLarger = 3.0;  // 2 of 168 sound logs of the bank reach it
  if (times <= kMuchLarger) return;
  double least = mean_c(*references.front().design), most = least;
  for (const Reference& reference : references) {
    least = std::min(least, mean_c(*reference.design));
    most = std::max(most, mean_c(*reference.design));
  }
  out.sentence = fmt::format("Nothing is certainly wrong, but the {} error is {:.1f} times that of any reference; they are of "
                             "{:.0f} to {:.0f} degC, the log of {:.0f}, and leave room for that.",
                             channel_words(name), times, least, most, mean_c(design));
  out.next_test = fmt::format("a known good log of a drive like this one, at {:.0f} degC", mean_c(design));
}

}  // namespace voltlap::plant
