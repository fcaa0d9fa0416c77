// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/settle.hpp"

#include <cmath>
#include <memory>
#include <utility>

namespace voltlap::explain {
namespace {

constexpr double kNear_k = 0.5, kFar_k = 2.0, kFarthest_k = 24.0;  // of warmth that nobody measured
constexpr int kWarmings = 4;
constexpr double kBeside = 0.9;  // of the squares in the first minutes: where all is right, charge takes none

/// Another way to hold the log, and what was found so, in the place of the first.
void take(Held held, std::deque<Round> found, Held& log, std::deque<Round>& rounds) {
  rounds.clear();
  log = std::move(held);
  rounds = std::move(found);
  rounds.front().held = &log;
}

/// Is what was found in one way to hold a log of practical size against another in which nothing is wrong?
bool is_worth_it(const Round& found, const Round& nothing) {
  Set more = found.answer.sets.front();
  more.use = use_of(found.family, more.fit, nothing.answer.nothing);
  return is_of_use(found.family, more);
}

/// A cause may look like a drive before the log, most of all one that comes with the first charge that is drawn: where
/// it explains clearly more of the log, and nothing else is left to say, it is what is wrong.
void settle_at_rest(Held& log, const std::vector<Held>& references, const std::vector<plant::Cause>& causes,
                    Holding& how, std::deque<Round>& rounds) {
  Holding rest_how = how;
  rest_how.beginning = Beginning::kAtRest;
  Held rests = held_against(log.world, log.log(), rest_how);
  std::deque<Round> again;
  put_rounds(rests, references, causes, rest_how, again);
  if (again.front().answer.sets.empty() || unnamed_beside(again, references)) return;
  const bool sound = rounds.front().answer.sets.empty();
  if (sound && !is_worth_it(again.front(), rounds.front())) return;
  if (!explains_more(again, rounds, references, causes)) return;
  how = rest_how;
  take(std::move(rests), std::move(again), log, rounds);
}

/// By how much warmer it began, by a fit of where it began.
double warmer_by(const Held& log, const Fit& fit) {
  plant::World world = log.world;
  begin_at(world, log.seen, fit.plain_starts);
  return world.initial_warmth_k - log.world.initial_warmth_k;
}

Held held_warmer(const Held& log, double by_k, const Holding& how) {
  plant::World world = log.world;
  world.initial_warmth_k += by_k;
  return held_against(world, log.log(), how);
}

/// A log that is held as warm as is told of it, and what was found so.
struct Warmed {
  Held log;
  std::deque<Round> rounds;
};

/// How much it takes to say what is wrong.
std::size_t said_by(std::deque<Round>& rounds, const std::vector<Held>& references) {
  std::size_t out = unnamed_beside(rounds, references) ? 1 : 0;
  for (const Round& round : rounds) {
    if (!round.answer.sets.empty()) out += round.answer.sets.front().members.size();
  }
  return out;
}

/// As warm as a battery without any error would have been.
Held warm_if_sound(Held log, const Holding& how) {
  for (int k = 0; k < kWarmings; ++k) {
    const double by_k = warmer_by(log, fit_of(global_family(log.seen, {}, all_suspects).problem, {}));
    if (std::abs(by_k) < kNear_k || std::abs(log.world.initial_warmth_k + by_k) > kFarthest_k) break;
    log = held_warmer(log, by_k, how);
  }
  return log;
}

}  // namespace

/// A log of which nothing is wrong but perhaps how it begins.
Held held_sound(const plant::World& model, plant::Recording log, Holding how) {
  Held out = held_against(model, std::move(log), how);
  if (out.seen.begins_charged || out.seen.left_beside_charge > kBeside) return out;
  how.beginning = Beginning::kCharged;
  return held_against(model, out.log(), how);
}

/// Beside what was found, the first minutes may tell that the log begins in a drive, which they did not before; and a
/// drive before the log may be all that is wrong. With it nothing may be left that has no name.
void settle_beginning(Held& log, const std::vector<Held>& references, const std::vector<plant::Cause>& causes,
                      Holding& how, std::deque<Round>& rounds) {
  if (log.seen.begins_charged) return settle_at_rest(log, references, causes, how, rounds);
  const auto finds = [](const std::deque<Round>& of) { return !of.front().answer.sets.empty(); };
  const bool unnamed = unnamed_beside(rounds, references).has_value();  // which may find something after all
  const bool found = finds(rounds);
  if (!found && !unnamed) return;
  plant::World world = log.world;
  for (const Round& round : rounds) world = world_with(std::move(world), round.answer);
  const bool beside = held_against(world, log.log(), how).seen.left_beside_charge < kBeside;
  if (!unnamed && !beside && log.seen.left_beside_charge > kBeside) return;
  Holding charged_how = how;
  charged_how.beginning = Beginning::kCharged;
  Held charged = held_against(log.world, log.log(), charged_how);
  std::deque<Round> again;
  put_rounds(charged, references, causes, charged_how, again);
  if (unnamed_beside(again, references)) return;
  const bool sound = !finds(again);
  if (!sound && found && !unnamed && !beside) return;
  if (!unnamed && explains_more(rounds, again, references, causes)) return;
  how = charged_how;
  take(std::move(charged), std::move(again), log, rounds);
}

/// Where nobody says how warm the battery was, all begins again with what was told of it: a resistance is no straight
/// line over the temperature. From where a sound battery would be, too: what needs less to be said is believed.
void settle_warmth(Held& log, const std::vector<Held>& references, const std::vector<plant::Cause>& causes,
                   Holding how, std::deque<Round>& rounds) {
  if (log.seen.comparison.facts.temperature_known || said_by(rounds, references) == 0) return;
  const auto settled = [&](Held from) {
    auto out = std::make_unique<Warmed>();
    out->log = std::move(from);
    for (int k = 0;; ++k) {
      out->rounds.clear();
      put_rounds(out->log, references, causes, how, out->rounds);
      const AnswerOf& answer = out->rounds.front().answer;
      const double by_k = warmer_by(out->log, answer.sets.empty() ? answer.nothing : answer.sets.front().fit);
      if (std::abs(by_k) < kFar_k || k == kWarmings) return out;
      Held next = held_warmer(out->log, by_k, how);
      out->rounds.clear();
      out->log = std::move(next);
    }
  };
  std::unique_ptr<Warmed> best = settled(log), other = settled(warm_if_sound(log, how));
  if (said_by(other->rounds, references) < said_by(best->rounds, references)) best = std::move(other);
  take(std::move(best->log), std::move(best->rounds), log, rounds);
}

}  // namespace voltlap::explain
