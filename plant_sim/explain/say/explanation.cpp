// SPDX-License-Identifier: Apache-2.0
#include "explain/say/explanation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "discrepancy/found_cause.hpp"
#include "explain/say/words.hpp"

namespace voltlap::explain {
namespace {

using plant::Verdict;
constexpr double kCertain = 0.99;  // no probability is said to be higher

plant::World world_of(const Saying& s) {
  plant::World out = s.model.world;
  if (!s.global.sets.empty()) {
    const Set& set = s.global.sets.front();
    for (std::size_t k = 0; k < set.members.size(); ++k)
      s.global.family->suspects[set.members[k]].form.apply(out, set.values[k]);
  }
  for (const AnswerOf& answer : s.members) {
    const Set& set = answer.sets.front();
    for (std::size_t k = 0; k < set.members.size(); ++k) {
      const Suspect& c = answer.family->suspects[set.members[k]];
      const auto& extend = s.causes[static_cast<std::size_t>(c.cause)].extend;
      if (extend) extend(out.car, std::stoul(c.channel.substr(c.channel.find_last_of('_') + 1)) - 1, set.values[k]);
    }
  }
  return out;
}

double rms(const VectorXd& v) {
  return v.size() > 0 ? std::sqrt(v.squaredNorm() / static_cast<double>(v.size())) : 0.0;
}

void put_gain(const AnswerOf& answer, const std::vector<std::string>& units, plant::Explanation& out) {
  const Set* set = answer.sets.empty() ? nullptr : &answer.sets.front();
  for (std::size_t c = 0; c < answer.family->channel.size(); ++c) {
    const auto row = static_cast<Index>(c);
    const double count = std::max(1.0, answer.family->problem.channels[c].all[0].count);
    plant::ChannelGain gain;
    gain.before = std::sqrt(std::max(0.0, answer.nothing.left.row(row).sum()) / count);
    gain.after = set == nullptr ? gain.before : std::sqrt(std::max(0.0, set->fit.left.row(row).sum()) / count);
    gain.floor = std::sqrt((set == nullptr ? answer.nothing : set->fit).variance(row));
    gain.unit = units[c];
    out.gain[answer.family->channel[c]] = gain;
  }
}

/// Values of a channel's bins at other times, the latest of each.
VectorXd at_times(const VectorXd& times, const VectorXd& own, const VectorXd& values) {
  VectorXd out = VectorXd::Constant(times.size(), std::numeric_limits<double>::quiet_NaN());
  Index at = -1;
  for (Index k = 0; k < times.size(); ++k) {
    Index next = at;
    while (next + 1 < own.size() && own(next + 1) <= times(k) + 1e-6) ++next;
    if (next >= 0 && next > at) out(k) = values(next);
    at = next;
  }
  return out;
}

void put_pictures(const Saying& s, const Observed& seen, const Observed& rest, plant::Explanation& out) {
  const VectorXd& times = seen.channels[0].reader.time_s();
  const auto by_row = [&](const VectorXd& values) { return seen.channels[0].reader.of(values); };
  out.circumstances = {
      times,
      by_row(seen.base.battery.current_a * static_cast<double>(seen.model.car.battery.cells_in_parallel)),
      by_row(seen.base.battery.soc),
      by_row(seen.comparison.facts.temperature_c.size() > 0 ? seen.comparison.facts.temperature_c
                                                            : seen.base.battery.temperature_c),
      {}};
  if (const VectorXd* speed = seen.comparison.log.find("speed")) {
    out.circumstances.speed_mps = by_row(speed->array().isFinite().select(*speed, 0.0));
  }
  AnswerOf nothing;
  nothing.family = s.global.family;
  nothing.nothing = s.global.nothing;
  const std::vector<VectorXd> before = left_by(rest, nothing, s.causes);
  for (std::size_t c = 0; c < rest.channels.size(); ++c) {
    const ReadChannel& channel = rest.channels[c];
    out.traces.push_back({channel.name, channel.unit, rms(s.left[c]), false,
                          at_times(times, channel.reader.time_s(), before[c]),
                          at_times(times, channel.reader.time_s(), s.left[c])});
  }
  for (const AnswerOf& answer : s.members) {
    const auto member = std::find_if(seen.members.begin(), seen.members.end(), [&](const Member& m) {
      return m.channel.name == answer.family->channel.front();
    });
    const ReadChannel& channel = member->channel;
    VectorXd after = channel.residual;
    const Set& set = answer.sets.front();
    for (std::size_t m = 0; m < set.members.size(); ++m) {
      const Suspect& c = answer.family->suspects[set.members[m]];
      const std::vector<VectorXd> shapes = c.form.shapes(seen.model, seen.comparison, seen.base);
      for (std::size_t k = 0; k < shapes.size(); ++k) {
        after -= set.values[m][c.form.linear[k]] *
                 channel.reader.of(shapes[k].array().isFinite().select(shapes[k], 0.0));
      }
    }
    out.traces.push_back({channel.name, channel.unit, rms(after), true,
                          at_times(times, channel.reader.time_s(), channel.residual),
                          at_times(times, channel.reader.time_s(), after)});
  }
}

/// Names of the sets that could stand in the place of the first.
void put_alternatives(const AnswerOf& answer, plant::Explanation& out) {
  for (const Set& set : answer.sets) out.alternatives.push_back(names_of(answer, set));
}

/// What the first set takes of the squares of the channel where it takes most.
double share_of(const AnswerOf& answer, const Set& set) {
  const auto row = static_cast<Index>(set.use.channel);
  const double before = answer.nothing.left.row(row).sum();
  return before > 0.0 ? std::clamp(1.0 - set.fit.left.row(row).sum() / before, 0.0, 1.0) : 0.0;
}

double probability_of(const AnswerOf& answer) {
  double sum = 0.0;
  for (const Set& set : answer.sets) sum += std::exp(std::max(-50.0, set.lead.ln - answer.sets.front().lead.ln));
  return std::min(kCertain, 1.0 / std::max(1.0, sum));
}

void put_causes(const Saying& s, const AnswerOf& answer, std::vector<std::string>& sentences,
                plant::Explanation& out) {
  if (answer.sets.empty()) return;
  const Set& set = answer.sets.front();
  std::vector<std::string> either;
  for (const Set& one : answer.sets) {
    std::vector<std::string> both;
    for (const plant::FoundCause& cause : found_causes(answer, one, s.causes)) both.push_back(cause.says);
    either.push_back(listed(both, "and"));
  }
  for (plant::FoundCause& cause : found_causes(answer, set, s.causes)) {
    cause.probability = probability_of(answer);
    cause.share_of_residual = share_of(answer, set);
    out.causes.push_back(std::move(cause));
  }
  sentences.push_back(listed(either, "or"));
}

std::string gain_text(const plant::Explanation& out) {
  std::string best;
  double most = 0.005;  // less is not seen in three digits
  for (const auto& [name, gain] : out.gain) {
    if (gain.before <= 0.0 || 1.0 - gain.after / gain.before <= most) continue;
    most = 1.0 - gain.after / gain.before;
    const bool milli = gain.unit == "V" && gain.before < 0.5;
    best = fmt::format(" With it, {:.3g} become {:.3g} {} of {} error on minutes that it did not see.",
                       (milli ? 1e3 : 1.0) * gain.before, (milli ? 1e3 : 1.0) * gain.after,
                       milli ? "mV" : gain.unit, plant::channel_words(name));
  }
  return best;
}

std::string capitalised(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

void put_runners_up(const AnswerOf& answer, plant::Explanation& out) {
  for (const Set& set : answer.beaten) {
    const std::vector<std::string> names = names_of(answer, set);
    const bool is_answer = std::any_of(answer.sets.begin(), answer.sets.end(),
                                       [&](const Set& a) { return names_of(answer, a) == names; });
    const bool seen = std::any_of(out.runners_up.begin(), out.runners_up.end(),
                                  [&](const plant::RunnerUp& r) { return r.names == names; });
    if (is_answer || seen) continue;
    const double best = answer.sets.empty() ? 0.0 : answer.sets.front().lead.ln;
    out.runners_up.push_back(
        {names, best - set.lead.ln,
         set.stands ? "explains unseen minutes worse" : "not decisive, or without practical use"});
  }
}

void put_sentence(const Saying& s, const std::vector<std::string>& sentences, plant::Explanation& out) {
  const bool several = !out.alternatives.empty();
  if (out.verdict == Verdict::kNoDiscrepancy) {
    out.sentence = "Nothing is wrong beyond the noise and what this model usually misses.";
  } else if (out.verdict == Verdict::kUnknown) {
    out.sentence = fmt::format(
        "Something is wrong in the {} balance that none of the known causes explains: {:.1f} times what is worth a "
        "word in the {}.",
        plant::name_of(s.unnamed->balance), s.unnamed->practical, plant::channel_words(s.unnamed->channel));
  } else {
    out.sentence =
        capitalised(fmt::format("{}{}.{}", several ? "either " : "", listed(sentences, "and"), gain_text(out)));
    if (s.unnamed) {
      out.sentence += fmt::format(" What remains in the {} balance none of the known causes explains.",
                                  plant::name_of(s.unnamed->balance));
    }
  }
}

}  // namespace

std::vector<VectorXd> residuals_of(const Observed& log) {
  std::vector<VectorXd> out;
  for (const ReadChannel& channel : log.channels) out.push_back(channel.residual);
  return out;
}

std::vector<VectorXd> left_by(const Observed& log, const AnswerOf& answer,
                              const std::vector<plant::Cause>& causes) {
  static_cast<void>(causes);
  plant::World world = log.model;
  const Fit& fit = answer.sets.empty() ? answer.nothing : answer.sets.front().fit;
  if (!answer.sets.empty()) {
    const Set& set = answer.sets.front();
    for (std::size_t k = 0; k < set.members.size(); ++k)
      answer.family->suspects[set.members[k]].form.apply(world, set.values[k]);
  }
  world.initial_soc_change += fit.plain_starts(0);
  if (answer.family->problem.nuisances.size() > 1) world.initial_warmth_k += fit.plain_starts(1);
  const std::vector<VectorXd> moved = log.effect_of(plant::predict(world, log.comparison));
  std::vector<VectorXd> out = residuals_of(log);
  for (std::size_t c = 0; c < out.size(); ++c) {
    if (moved[c].size() > 0) out[c] -= moved[c];
  }
  return out;
}

plant::Explanation too_little(const Saying& saying, const plant::Gated& gated) {
  plant::Explanation out;
  out.with_references = saying.with_references;
  out.masked = gated.log.masked;
  out.notes = gated.log.repairs;
  out.verdict = Verdict::kBadData;
  out.causes = saying.gate;
  out.sentence = gated.enough;
  out.next_test = gated.drive;
  return out;
}

plant::Explanation said(const Saying& s, const plant::Gated& gated, const Observed& seen, const Observed& rest) {
  plant::Explanation out;
  out.with_references = s.with_references;
  out.masked = gated.log.masked;
  out.notes = gated.log.repairs;
  std::vector<std::string> sentences, units;
  for (const ReadChannel& channel : rest.channels) units.push_back(channel.unit);
  put_causes(s, s.global, sentences, out);
  for (const AnswerOf& answer : s.members) put_causes(s, answer, sentences, out);
  for (const plant::FoundCause& found : s.gate) {
    out.causes.push_back(found);
    sentences.push_back(found.says);
  }
  std::vector<const AnswerOf*> open;
  if (s.global.sets.size() > 1) open.push_back(&s.global);
  for (const AnswerOf& answer : s.members) {
    if (answer.sets.size() > 1) open.push_back(&answer);
  }
  for (const AnswerOf* answer : open) put_alternatives(*answer, out);
  out.verdict = !open.empty()         ? Verdict::kAmbiguous
                : !out.causes.empty() ? Verdict::kNamed
                : s.unnamed           ? Verdict::kUnknown
                                      : Verdict::kNoDiscrepancy;
  if (s.unnamed && out.verdict != Verdict::kNoDiscrepancy) out.unknown_in = s.unnamed->balance;
  put_gain(s.global, units, out);
  for (const AnswerOf& answer : s.members) put_gain(answer, {seen.channels[0].unit}, out);
  put_runners_up(s.global, out);
  put_pictures(s, seen, rest, out);
  if (!open.empty()) {
    const Set& second = open.front()->sets[1];
    out.next_test =
        s.causes[static_cast<std::size_t>(open.front()->family->suspects[second.members.front()].cause)].test;
  } else if (s.unnamed) {
    out.next_test = "a known good log of a drive like this one";
  }
  put_sentence(s, sentences, out);
  if (!s.global.sets.empty() || !s.members.empty()) out.world = world_of(s);
  return out;
}

}  // namespace voltlap::explain
