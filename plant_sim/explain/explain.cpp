// SPDX-License-Identifier: Apache-2.0
#include "explain/explain.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>

#include "explain/balances/car_balances.hpp"
#include "explain/causes/list.hpp"
#include "explain/decide/members.hpp"
#include "explain/decide/rounds.hpp"
#include "explain/decide/settle.hpp"
#include "explain/gate/integrity.hpp"
#include "explain/say/verdict.hpp"

namespace voltlap::explain {
namespace {

/// What the gate found and sound logs do not have. Steps of a pedal, and steps that no reading is worse for, are no
/// finding.
std::vector<plant::FoundCause> unusual(const std::vector<plant::GateFinding>& findings,
                                       const std::vector<std::vector<plant::GateFinding>>& usual) {
  std::vector<plant::GateFinding> worth;
  std::copy_if(findings.begin(), findings.end(), std::back_inserter(worth),
               [](const plant::GateFinding& f) { return f.cause != "quantisation" || f.worth_telling; });
  return plant::unusual_findings(worth, usual);
}

Holding holding_of(const plant::Model& model, bool has_references) {
  Holding out;
  out.compared.soc_stated = model.kind != plant::ModelKind::kCell;
  out.compared.judge_soc = has_references;
  out.compared.temperature_stated = model.temperature_stated;
  return out;
}

void note_what_is_not_judged(const plant::World& model, plant::Recording& log) {
  if (!log.has_voltage_of_its_time() && !log.numbered("temperature_").empty()) {
    log.repairs.emplace_back(
        "no cause is sought of how warm the cells are on the mean: their voltages are of other times than the current, "
        "and say not what heats them. Log the pack's voltage beside its current");
  }
  const bool has_speed = log.find("speed") != nullptr || log.find("wheel_speed_1") != nullptr;
  if (!has_speed || plant::knows_cornering(model, log)) return;
  log.repairs.emplace_back(
      "forces on the car and what its tyres slip are not judged: corners hold the model's tyres back "
      "(tyres.cornering_stiffness_per_rad), and the log has no lateral acceleration. Log it, or set that to 0");
  const bool drives = log.find("motor_current") != nullptr || log.find("motor_torque") != nullptr;
  if (!drives || log.find("motor_speed") != nullptr) return;
  log.repairs.emplace_back(
      "power is judged no finer than the tyres slip: the motor's speed is reckoned from the car's. Log it, or name it "
      "with a map");
}

Minutes minutes_of(const std::string& fit_blocks) {
  return fit_blocks == "even" ? Minutes::kEven : fit_blocks == "odd" ? Minutes::kOdd : Minutes::kAll;
}

/// Who asks says how warm the air of the log's day was, of no other's.
Holding of_this_day(Holding how, const plant::Model& model, Minutes minutes) {
  how.compared.air_step_k = model.air_step_k;
  how.minutes = minutes;
  return how;
}
Holding of_another_day(Holding how) {
  how.compared.air_step_k = 0.0;
  how.minutes = Minutes::kAll;
  return how;
}

/// What is left of another log, or of the minutes that were not fitted, by the model as it was given and with what
/// was found: both begin as the latter says.
std::map<std::string, plant::ChannelGain> gain_on(const plant::World& model, const plant::Recording& log,
                                                  const Saying& saying, Holding how) {
  plant::World found = model;
  for (const AnswerOf* answer : saying.global) found = world_with(std::move(found), *answer);
  const Held other = held_against(model, log, how);
  const Held with = held_sound(found, corrected(other.log(), effects_of(other, saying.members)), how);
  how.beginning = with.seen.begins_charged ? Beginning::kCharged : Beginning::kAtRest;
  const bool alike = other.seen.begins_charged == with.seen.begins_charged;
  const std::map<std::string, LeftOf> before = left_of(alike ? other.seen : held_against(model, log, how).seen);
  std::map<std::string, plant::ChannelGain> out;
  for (const auto& [channel, after] : left_of(with.seen)) {
    if (!before.contains(channel)) continue;
    out[channel] = gain_of(before.at(channel), after);
  }
  return out;
}

std::vector<VectorXd> times_of(const Observed& log) {
  std::vector<VectorXd> out;
  for (const ReadChannel& channel : log.channels) out.push_back(channel.reader.time_s());
  return out;
}

/// Something is wrong, and it is not what was found.
void take_back(Saying& saying, std::deque<Round>& rounds, const Unnamed& error) {
  saying.unnamed = error;
  rounds.resize(1);
  rounds.front().answer.sets.clear();
  saying.global = {&rounds.front().answer};
  saying.members.clear();
  saying.left = left_by(rounds.front().held->seen, rounds.front().answer);
  saying.left_s = times_of(rounds.front().held->seen);
  for (auto& [name, of] : saying.gain) of.after = of.before, of.drop_low = of.drop_high = 0.0;
}

/// An answer with which another log, or the other minutes, are worse is none.
void take_back_if_worse(Saying& saying, std::deque<Round>& rounds) {
  constexpr double kWorse = 1.1;
  for (const Round& round : rounds) {
    if (round.answer.sets.empty()) continue;
    const std::string& channel = round.answer.family->channel[round.answer.sets.front().use.channel];
    const auto gain = saying.gain.find(channel);
    if (gain == saying.gain.end() || gain->second.after < kWorse * gain->second.before) continue;
    return take_back(saying, rounds, error_of(round.answer, round.held->seen));
  }
}

/// What takes less of an error than it leaves without a name is not what is wrong.
void take_back_if_least(Saying& saying, std::deque<Round>& rounds) {
  constexpr double kLeast = 0.5;  // of the squares
  const AnswerOf& answer = rounds.front().answer;
  if (!saying.unnamed || answer.sets.empty() || !saying.members.empty()) return;
  const Unnamed whole = error_of(answer, rounds.front().held->seen);
  const double share = std::pow(saying.unnamed->practical / whole.practical, 2);
  if (saying.unnamed->channel == whole.channel && share > kLeast) take_back(saying, rounds, whole);
}

}  // namespace

plant::Explanation explain(const plant::Model& model, plant::Recording raw, ExplainOptions options) {
  const auto progress = [&](const char* what, double fraction) {
    if (options.progress) options.progress(what, fraction);
  };
  Holding how = holding_of(model, !options.references.empty());
  std::vector<plant::Cause> causes = plant::catalogue(options.without);
  plant::size_for(model.world.car.cell, causes);
  plant::Gated gated = plant::integrity_gate(std::move(raw), model);
  std::vector<Held> references;
  std::vector<std::vector<plant::GateFinding>> usual_findings;
  for (plant::Recording& reference : options.references) {
    progress("reading references",
             0.1 + 0.4 * static_cast<double>(references.size()) / static_cast<double>(options.references.size()));
    plant::Gated theirs = plant::integrity_gate(std::move(reference), model);
    usual_findings.push_back(theirs.findings);
    references.push_back(held_sound(model.world, std::move(theirs.log), how));
    how.compared.hold = references.front().seen.comparison.facts.hold;  // one logger holds the current in one way
  }
  Saying saying{model, causes, {}, {}, {}, {}, {}, {}, {}, {}};
  saying.with_references = !references.empty();
  saying.gate = unusual(gated.findings, usual_findings);
  if (!gated.enough.empty()) return too_little(saying, gated);
  note_what_is_not_judged(model.world, gated.log);
  progress("comparing with the model", 0.5);
  how = of_this_day(how, model, minutes_of(options.fit_blocks));
  Held held = held_against(model.world, gated.log, how);
  how.compared.hold = held.seen.comparison.facts.hold;  // beside whatever is found
  std::deque<Held> without_worst;
  saying.members = worst_first(held, references, causes, how, without_worst);
  progress("weighing causes", 0.6);
  const std::vector<MemberEffect> found = effects_of(held, saying.members);
  Held without;
  if (!found.empty()) without = held_against(model.world, corrected(held.log(), found), how);
  Held& rest = found.empty() ? held : without;
  const std::vector<AnswerOf> all = saying.members;
  std::erase_if(saying.members, [&](const AnswerOf& answer) { return follows_from_cell(held, answer, all); });
  std::deque<Round> rounds;
  put_rounds(rest, references, causes, how, rounds);
  settle_beginning(rest, references, causes, how, rounds);
  settle_warmth(rest, references, causes, how, rounds);
  for (const Round& round : rounds) saying.global.push_back(&round.answer);
  progress("looking for what has no name", 0.85);
  if (!saying.members.empty() && !rounds.front().answer.sets.empty()) {
    // What is wrong with all, seen at one member's times, may look like an error of that one.
    plant::World world = model.world;
    for (const Round& round : rounds) world = world_with(std::move(world), round.answer);
    Held beside = held_against(world, held.log(), how);
    const std::vector<AnswerOf> still = member_answers(
        beside, references, causes, [&](const std::string& role) { return is_of(saying.members, role); });
    std::erase_if(saying.members, [&](const AnswerOf& a) { return !is_of(still, a.family->channel.front()); });
  }
  saying.unnamed = unnamed_beside(rounds, references);
  saying.left = left_by(rounds.back().held->seen, rounds.back().answer);
  saying.left_s = times_of(rounds.back().held->seen);
  take_back_if_least(saying, rounds);
  if (!saying.unnamed) saying.unnamed = unnamed_member(held, references, causes, saying.members);
  how.beginning = Beginning::kByItself;
  if (options.holdout) {
    how = of_another_day(how);
    plant::Gated theirs = plant::integrity_gate(std::move(*options.holdout), model);
    saying.gain = gain_on(model.world, theirs.log, saying, how);
  } else if (how.minutes != Minutes::kAll) {
    how.minutes = how.minutes == Minutes::kEven ? Minutes::kOdd : Minutes::kEven;
    saying.gain = gain_on(model.world, gated.log, saying, how);
  }
  take_back_if_worse(saying, rounds);
  return said(saying, gated, held.seen, rest.seen);
}

}  // namespace voltlap::explain
