// SPDX-License-Identifier: Apache-2.0
#include "explain/say/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "explain/gate/rail.hpp"
#include "explain/model/held.hpp"
#include "explain/model/settled_temperature.hpp"
#include "explain/model/unstepped.hpp"
#include "explain/say/numbers.hpp"
#include "explain/say/words.hpp"

namespace voltlap::explain {
namespace {

using plant::Verdict;
constexpr double kCertain = 0.99;  // no probability is said to be higher

plant::World world_of(const Saying& s) {
  plant::World out = s.model.world;
  for (const AnswerOf* answer : s.global) out = world_with(std::move(out), *answer);
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

/// From what the first answer begins with to what the last one with a cause leaves.
void put_gain(const AnswerOf& answer, const AnswerOf& last, const std::vector<std::string>& units,
              plant::Explanation& out) {
  const Set* set = last.sets.empty() ? nullptr : &last.sets.front();
  for (std::size_t c = 0; c < answer.family->channel.size(); ++c) {
    const LeftOf before = left_in(*answer.family, answer.nothing, c, units[c]);
    out.gain[answer.family->channel[c]] =
        gain_of(before, set == nullptr ? before : left_in(*answer.family, set->fit, c, units[c]));
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

/// Whose answer it is.
const Member& member_of(const Observed& seen, const AnswerOf& answer) {
  return *std::find_if(seen.members.begin(), seen.members.end(),
                       [&](const Member& m) { return m.channel.name == answer.family->channel.front(); });
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
  nothing.family = s.global.front()->family;
  nothing.nothing = s.global.front()->nothing;
  const std::vector<VectorXd> before = left_by(rest, nothing);
  for (std::size_t c = 0; c < rest.channels.size(); ++c) {
    const ReadChannel& channel = rest.channels[c];
    out.traces.push_back({channel.name, channel.unit, plant::rms_of(s.left[c]), false,
                          at_times(times, channel.reader.time_s(), before[c]),
                          at_times(times, s.left_s[c], s.left[c])});
  }
  for (const AnswerOf& answer : s.members) {
    const ReadChannel& channel = member_of(seen, answer).channel;
    VectorXd after = channel.residual;
    const Set& set = answer.sets.front();
    for (std::size_t m = 0; m < set.members.size(); ++m) {
      const Suspect& c = answer.family->suspects[set.members[m]];
      after -= channel.reader.of(member_effect(c.form, seen, set.values[m]));
    }
    out.traces.push_back({channel.name, channel.unit, plant::rms_of(after), true,
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
  sentences.push_back((either.size() > 1 ? "either " : "") + listed(either, "or"));
}

std::string capitalised(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

/// Of a sound log those alone that could have been the answer; of others no more than one reads.
void put_runners_up(const AnswerOf& answer, plant::Explanation& out) {
  constexpr std::size_t kRead = 3;
  for (const Set& set : answer.beaten) {
    if (out.runners_up.size() == kRead) return;
    if (!set.stands && out.verdict == Verdict::kNoDiscrepancy) continue;
    const std::vector<std::string> names = names_of(answer, set);
    const bool is_answer = std::any_of(answer.sets.begin(), answer.sets.end(),
                                       [&](const Set& a) { return names_of(answer, a) == names; });
    const bool seen = std::any_of(out.runners_up.begin(), out.runners_up.end(),
                                  [&](const plant::RunnerUp& r) { return r.names == names; });
    const bool has_more = std::any_of(answer.sets.begin(), answer.sets.end(), [&](const Set& a) {
      const std::vector<std::string> said = names_of(answer, a);
      return std::all_of(said.begin(), said.end(), [&](const std::string& name) {
        return std::find(names.begin(), names.end(), name) != names.end();
      });
    });
    if (is_answer || seen || has_more) continue;
    const double best = answer.sets.empty() ? 0.0 : answer.sets.front().lead.ln;
    out.runners_up.push_back(
        {names, best - set.lead.ln,
         set.stands ? "explains unseen minutes worse"
                    : "a cause of it is impossible, without use beside the others, or undone by them"});
  }
}

void put_sentence(const Saying& s, const Observed& rest, const std::vector<std::string>& sentences,
                  plant::Explanation& out) {
  if (out.verdict == Verdict::kNoDiscrepancy) {
    out.sentence = "Nothing is wrong beyond the noise and what this model usually misses.";
    if (!s.with_references) out.sentence += left_untold(rest, out);
  } else if (out.verdict == Verdict::kUnknown) {
    out.sentence = fmt::format(
        "Something is wrong in the {} balance that none of the known causes explains: {:.1f} times what is worth a "
        "word in the {}.",
        plant::name_of(s.unnamed->balance), s.unnamed->practical, plant::channel_words(s.unnamed->channel));
    if (!sentences.empty()) out.sentence += " Besides, " + listed(sentences, "and") + ".";
  } else {
    const std::string gain = plant::gain_text(out);
    const std::string said = listed(sentences, "and") + (gain.empty() ? "." : "; " + gain + ".");
    const bool is_part = s.unnamed && out.causes.size() > s.gate.size();
    out.sentence = is_part ? "A part of it: " + said : capitalised(said);
    if (s.unnamed) {
      out.sentence += fmt::format(
          " What remains in the {} balance, {:.1f} times what is worth a word in the {}, none of the known causes "
          "explains.",
          plant::name_of(s.unnamed->balance), s.unnamed->practical, plant::channel_words(s.unnamed->channel));
    }
  }
}

/// Of a log whose thermistors hardly tell how warm the battery was: how little. Empty where one of them tells it.
std::string told_of_heat(const Observed& log) {
  const std::vector<std::string> roles = log.read.numbered("temperature_");
  const auto heat = std::find_if(log.channels.begin(), log.channels.end(),
                                 [](const ReadChannel& channel) { return channel.name == "temperature"; });
  if (roles.empty() || heat == log.channels.end()) return "";
  constexpr const char* kTest = "a longer or harder drive, or finer readings, tell it";
  if (heat->reader.size() == 0)
    return fmt::format("at no time do the thermistors tell together how warm the battery was: nothing of its heat is "
                       "judged; {}",
                       kTest);
  double step_k = std::numeric_limits<double>::infinity();
  for (const std::string& role : roles) {
    const double step = least_change(*log.read.find(role));
    if (step < kCoarse_k || log.read.passed_s.count(role) > 0) return "";
    step_k = std::min(step_k, step);
  }
  if (!std::isfinite(step_k))
    return fmt::format("the thermistors read the same from beginning to end, as in steps of 1 K they may: an error of "
                       "the battery's heat that would not have changed them is not seen; {}",
                       kTest);
  return fmt::format("the thermistors are read in steps of {:.2g} K and pass too few: an error of the battery's heat "
                     "of less than a step is not seen; {}",
                     step_k, kTest);
}

}  // namespace

std::vector<VectorXd> left_by(const Observed& log, const AnswerOf& answer) {
  std::vector<VectorXd> moved(log.channels.size());
  if (answer.sets.empty()) {  // as it was fitted: starts are straight lines
    take_straight_starts(log, -answer.nothing.plain_starts, moved);
  } else {
    plant::World world = world_with(log.model, answer);
    const VectorXd& starts = answer.sets.front().fit.plain_starts;
    const VectorXd bending = bending_starts(log, starts);
    begin_at(world, log, bending);
    moved = log.effect_of(plant::predict(world, log.comparison, facts_with(world, log)));
    take_straight_starts(log, bending - starts, moved);
  }
  std::vector<VectorXd> out;
  for (std::size_t c = 0; c < log.channels.size(); ++c) {
    out.push_back(log.channels[c].residual);
    if (moved[c].size() > 0) out[c] -= moved[c];
  }
  return out;
}

std::string left_untold(const Observed& log, const plant::Explanation& out) {
  constexpr double kWorthIt = 2.0;  // practical sizes; chosen
  std::vector<std::string> between, usual;
  for (const ReadChannel& channel : log.channels) {
    const auto gain = out.gain.find(channel.name);
    if (gain == out.gain.end() || channel.practical <= 0.0) continue;
    const double left = gain->second.after, noise = gain->second.floor;
    const double beyond = std::sqrt(std::max(0.0, left * left - noise * noise));
    if (beyond < kWorthIt * channel.practical) continue;
    const plant::ShownUnit shown = plant::shown_unit(channel.unit, left);
    (channel.between_rows >= 1.0 ? between : usual)
        .push_back(fmt::format("{} ({:.2g} {} RMS)", plant::channel_words(channel.name), left * shown.scale,
                               shown.unit));
  }
  std::string text;
  const VectorXd& time_s = log.comparison.log.time_s;
  const double row_s = (time_s(time_s.size() - 1) - time_s(0)) / static_cast<double>(time_s.size() - 1);
  if (!between.empty())
    text += fmt::format(" What is left of the {} may be what was between rows {:.2g} s apart: a finer log tells.",
                        listed(between, "and"), row_s);
  if (!usual.empty())
    text += fmt::format(" What is left of the {} a sound log of such a model may have: a known good log tells.",
                        listed(usual, "and"));
  return text;
}

std::string air_taken(const Observed& log, const AnswerOf& answer) {
  constexpr double kWorthIt_k = 1.5;  // of 3 K that are allowed; chosen
  const plant::LogFacts& facts = log.comparison.facts;
  if (facts.ambient_above_model_k.size() > 0 || facts.air_step_k > 0.0) return "";
  const VectorXd& starts =
      answer.sets.empty() ? answer.nothing.plain_starts : answer.sets.front().fit.plain_starts;
  const double given_c = log.model.car.environment.ambient_c;
  plant::World world = log.model;
  begin_at(world, log, starts);
  const double warmer_k = world.car.environment.ambient_c - given_c;
  if (std::abs(warmer_k) < kWorthIt_k) return "";
  return fmt::format(
      "the log does not say how warm the air was: it is taken as {:.1f} degC here, {:.1f} K {} than the model says, "
      "and may hide an error of the cooling or of what heats; --set environment.ambient_c=C, or a column of it, tells",
      given_c + warmer_k, std::abs(warmer_k), warmer_k > 0.0 ? "warmer" : "colder");
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
  if (!rest.comparison.facts.temperature_known) {
    out.notes.push_back(fmt::format(
        "no thermistor: how warm the battery began the voltage alone tells, {:.0f} degC give or take 8 K; --set "
        "battery.initial_temperature_c=C says it, and smaller errors of the resistances are found",
        s.model.world.car.battery.initial_temperature_c));
  }
  if (std::string heat = told_of_heat(rest); !heat.empty()) out.notes.push_back(std::move(heat));
  if (std::string air = air_taken(rest, *s.global.front()); !air.empty()) out.notes.push_back(std::move(air));
  std::vector<std::string> sentences, units;
  for (const ReadChannel& channel : rest.channels) units.push_back(channel.unit);
  for (const AnswerOf* answer : s.global) put_causes(s, *answer, sentences, out);
  for (const AnswerOf& answer : s.members) put_causes(s, answer, sentences, out);
  for (const plant::FoundCause& found : s.gate) {
    out.causes.push_back(found);
    sentences.push_back(found.says);
  }
  std::vector<const AnswerOf*> open;
  for (const AnswerOf* answer : s.global) {
    if (answer->sets.size() > 1) open.push_back(answer);
  }
  for (const AnswerOf& answer : s.members) {
    if (answer.sets.size() > 1) open.push_back(&answer);
  }
  for (const AnswerOf* answer : open) put_alternatives(*answer, out);
  // Of an error whose rest has no name a cause is a part.
  const bool is_part = s.unnamed && out.causes.size() > s.gate.size();
  out.verdict = !open.empty() || is_part ? Verdict::kAmbiguous
                : s.unnamed              ? Verdict::kUnknown
                : !out.causes.empty()    ? Verdict::kNamed
                                         : Verdict::kNoDiscrepancy;
  if (s.unnamed && out.verdict != Verdict::kNoDiscrepancy) out.unknown_in = s.unnamed->balance;
  const AnswerOf* last = s.global.front();
  for (const AnswerOf* answer : s.global) last = answer->sets.empty() ? last : answer;
  put_gain(*s.global.front(), *last, units, out);
  for (const AnswerOf& answer : s.members) put_gain(answer, answer, {member_of(seen, answer).channel.unit}, out);
  for (const auto& [channel, gain] : s.gain) {
    if (out.gain.contains(channel)) out.gain[channel] = gain;
  }
  put_runners_up(*s.global.front(), out);
  put_pictures(s, seen, rest, out);
  if (!open.empty()) {
    const Set& second = open.front()->sets[1];
    out.next_test =
        s.causes[static_cast<std::size_t>(open.front()->family->suspects[second.members.front()].cause)].test;
  } else if (s.unnamed) {
    out.next_test = "a known good log of a drive like this one";
  }
  if (std::any_of(out.causes.begin(), out.causes.end(),
                  [](const plant::FoundCause& c) { return c.name == "current_saturation"; })) {
    const plant::Recording& log = rest.comparison.log;
    if (const auto rail = plant::rail_of(*log.find("current"))) plant::mask_rail(*rail, log, out.masked);
  }
  put_sentence(s, rest, sentences, out);
  if (!last->sets.empty() || !s.members.empty()) out.world = world_of(s);
  return out;
}

}  // namespace voltlap::explain
