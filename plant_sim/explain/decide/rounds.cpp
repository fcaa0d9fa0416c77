// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/rounds.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "explain/decide/members.hpp"
#include "explain/decide/of_use.hpp"
#include "explain/fit/refine.hpp"
#include "explain/model/between_rows.hpp"
#include "explain/model/unstepped.hpp"
#include "explain/say/verdict.hpp"

namespace voltlap::explain {
namespace {

constexpr std::size_t kRounds = 3;  // in which causes are sought beside those that were found
constexpr double kLeft = 1.0;       // practical sizes of error that make another round worth while
constexpr double kBeyond = 2.0;     // of what references have, beside one practical size
constexpr double kPart = 0.1;       // of the error as it was: what less is left of is a size's own uncertainty
constexpr double kFarOff = 10.0;    // practical sizes
constexpr double kFarBeside = 3.0;  // the same beyond what sound logs leave, where there are such logs
constexpr double kBetweenRows = 3.0;  // of what is off for the rows that were not recorded, of an error without a name
constexpr double kOfApart = 1.5;      // of what it is for cells that were read between the rows

/// The channel, by name, that shows a suspect best.
std::string shown_in(const Family& family, const Suspect& suspect) {
  double most = -1.0;
  std::string out;
  for (std::size_t c = 0; c < family.channel.size(); ++c) {
    const ChannelGram& channel = family.problem.channels[c];
    double square = 0.0;
    for (std::size_t k = 0; k < channel.column.size(); ++k) {
      if (std::find(suspect.columns.begin(), suspect.columns.end(), channel.column[k]) != suspect.columns.end())
        square += channel.all[0].gram(static_cast<Index>(k), static_cast<Index>(k));
    }
    const double effect = square / (std::max(1.0, channel.all[0].count) * std::pow(family.practical[c], 2));
    if (effect > most) most = effect, out = family.channel[c];
  }
  return out;
}

std::vector<Sound> sounds_of(const std::vector<Held>& references, const std::vector<plant::Cause>& causes) {
  std::vector<Sound> out;
  for (const Held& reference : references) {
    out.push_back(sound([&](const Wanted& asked) { return global_family(reference.seen, causes, asked); }));
  }
  return out;
}

void answer_round(Round& round, const std::vector<Held>& references, const std::vector<plant::Cause>& causes,
                  const Wanted& wanted) {
  const Held& held = *round.held;
  round.family = global_family(held.seen, causes, wanted);
  Family& family = round.family;
  const std::vector<Sound> theirs = sounds_of(references, causes);
  bound_noise(family, theirs);
  family.asked = theirs.empty() ? asked_alone(held.seen) : asked_between_rows(held.seen);
  Search search(family, causes);
  const Fit& nothing = search.nothing();
  round.answer = answer_of(family, search, Asked(theirs), [&](const Family& of, const Set& set) {
    return refined(causes, of, nothing, set,
                   [&](const SetValues& at) { return at_values(held.seen, causes, of, at); });
  });
}

/// The channels of which the answer leaves an error of practical size.
std::set<std::string> left_much(const AnswerOf& answer) {
  std::set<std::string> out;
  const Fit& fit = answer.sets.front().fit;
  for (std::size_t c = 0; c < answer.family->channel.size(); ++c) {
    if (error_in(*answer.family, fit, fit, c) > kLeft) out.insert(answer.family->channel[c]);
  }
  return out;
}

AnswerOf nothing_of(const Family& family) {
  AnswerOf out;
  out.family = &family;
  out.nothing = fit_of(family.problem, {});
  return out;
}

/// RMS of an error beyond the white noise that most of its readings show: a median of differences does not see what
/// is large at times.
double beyond_white(const VectorXd& error) {
  constexpr double kOfNormal = 1.4826;
  const Index n = error.size();
  if (n < 3) return 0.0;
  std::vector<double> off;
  for (Index k = 1; k + 1 < n; ++k) off.push_back(std::abs(error(k) - 0.5 * (error(k - 1) + error(k + 1))));
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  const double white = kOfNormal * *middle / std::sqrt(1.5);
  return std::sqrt(std::max(0.0, error.squaredNorm() / static_cast<double>(n) - white * white));
}

/// What sound logs leave of a channel, in practical sizes; reckoned when it is first asked for.
class SoundLogs {
 public:
  explicit SoundLogs(const std::vector<Held>& references) : references_(references) {}
  [[nodiscard]] bool none() const { return references_.empty(); }

  /// RMS beyond white noise, of the worst.
  [[nodiscard]] double error(const std::string& channel) {
    double out = 0.0;
    for (std::size_t r = 0; r < references_.size(); ++r) {
      const std::vector<ReadChannel>& channels = references_[r].seen.channels;
      for (std::size_t c = 0; c < channels.size(); ++c) {
        if (channels[c].name == channel) out = std::max(out, beyond_white(left()[r][c]) / channels[c].practical);
      }
    }
    return out;
  }

  /// What smooth shapes take of it.
  [[nodiscard]] double shapes(const std::string& channel) {
    for (std::size_t r = shapes_.size(); r < references_.size(); ++r)
      shapes_.push_back(unnamed_in(references_[r].seen, left()[r], 0.0));
    double out = 0.0;
    for (const auto& reference : shapes_) {
      for (const Unnamed& same : reference) {
        if (same.channel == channel) out = std::max(out, same.practical);
      }
    }
    return out;
  }

 private:
  const std::vector<std::vector<VectorXd>>& left() {
    for (std::size_t r = left_.size(); r < references_.size(); ++r) {
      const Family starts = global_family(references_[r].seen, {}, all_suspects);
      left_.push_back(left_by(references_[r].seen, nothing_of(starts)));
    }
    return left_;
  }

  const std::vector<Held>& references_;
  std::vector<std::vector<VectorXd>> left_;
  std::vector<std::vector<Unnamed>> shapes_;
};

const ReadChannel* channel_named(const Observed& log, const std::string& name) {
  for (const ReadChannel& channel : log.channels) {
    if (channel.name == name) return &channel;
  }
  for (const Member& member : log.members) {
    if (member.channel.name == name) return &member.channel;
  }
  return nullptr;
}

/// Practical sizes of a channel that a drive has to be beyond for what is between its rows, whatever references have.
double least_between_rows(const Observed& log, const std::string& name) {
  const ReadChannel* channel = channel_named(log, name);
  return channel != nullptr ? std::max(kBetweenRows * channel->between_rows, kOfApart * channel->apart) : 0.0;
}

/// The same of one without references.
double least_alone(const Observed& log, const std::string& name) {
  const ReadChannel* channel = channel_named(log, name);
  return std::max({kAlone, least_between_rows(log, name), channel != nullptr ? channel->stepped : 0.0});
}

/// Shapes without a name that sound logs do not have.
std::optional<Unnamed> unnamed_of(const Held& held, const std::vector<VectorXd>& left, SoundLogs& sound_logs) {
  std::optional<Unnamed> out;
  for (const Unnamed& one : unnamed_in(held.seen, left, 1.0)) {
    // A drive differs from the next by how it is driven most of all.
    const double least = sound_logs.none() ? least_alone(held.seen, one.channel)
                         : std::max(one.balance == plant::Balance::kForce ? kAlone : 1.0,
                                    least_between_rows(held.seen, one.channel));
    if (!one.lead.decisive || one.practical < least || (out && one.practical < out->practical)) continue;
    if (sound_logs.none() && is_known_by_sound(held.seen, one.balance)) continue;
    if (one.practical > least + kBeyond * sound_logs.shapes(one.channel)) out = one;
  }
  return out;
}

/// Is there a set that takes from this channel what sound logs do not have, and was not said for its size alone?
bool takes_usually(const AnswerOf& answer, const std::string& channel) {
  return answer.sets.empty() && !answer.usual.empty() &&
         answer.family->channel[answer.usual.front().use.channel] == channel;
}

/// RMS of what an answer leaves of a channel beyond white noise, in practical sizes.
double remains(const AnswerOf& answer, std::size_t channel) {
  const Fit& fit = answer.sets.empty() ? answer.nothing : answer.sets.front().fit;
  return error_in(*answer.family, fit, fit, channel);
}

plant::Balance balance_of(const Observed& log, const std::string& name) {
  for (const ReadChannel& channel : log.channels) {
    if (channel.name == name) return channel.balance;
  }
  for (const Member& member : log.members) {
    if (member.channel.name == name) return member.channel.balance;
  }
  return plant::Balance::kVoltage;
}

/// RMS without the largest twentieth: a second of something else is no error of the whole log.
double usual_error(const VectorXd& error) {
  constexpr double kKept = 0.95;
  std::vector<double> squares;
  for (const double e : error) squares.push_back(e * e);
  std::sort(squares.begin(), squares.end());
  squares.resize(static_cast<std::size_t>(kKept * static_cast<double>(squares.size())));
  double sum = 0.0;
  for (const double s : squares) sum += s;
  return std::sqrt(sum / std::max<double>(1.0, static_cast<double>(squares.size())));
}

/// An error that is far beyond any that is worth a word, whatever its shape. How well tyres and brakes are known is
/// told by sound drives alone.
std::optional<Unnamed> far_off(const Held& held, const std::vector<VectorXd>& left, SoundLogs& sound_logs) {
  const bool in_laboratory = is_of_laboratory(held.seen.comparison.log);
  std::optional<Unnamed> out;
  for (std::size_t c = 0; c < left.size(); ++c) {
    const ReadChannel& channel = held.seen.channels[c];
    if (channel.balance == plant::Balance::kForce || channel.balance == plant::Balance::kPower) continue;
    const double error = std::min(beyond_white(left[c]), usual_error(left[c])) / channel.practical;
    const double between = in_laboratory ? 0.0 : least_between_rows(held.seen, channel.name);
    const double least = std::max(sound_logs.none() ? kFarOff : kFarBeside, between);
    if (error < least || (out && error < out->practical)) continue;
    if (error > least + kBeyond * sound_logs.error(channel.name))
      out = Unnamed{channel.name, channel.balance, error, {}};
  }
  return out;
}

}  // namespace

void put_rounds(const Held& log, const std::vector<Held>& references, const std::vector<plant::Cause>& causes,
                const Holding& how, std::deque<Round>& rounds) {
  plant::World world = log.world;
  std::set<std::string> taken;  // what three causes at once leave of a channel, more of them would follow by chance
  std::vector<Suspect> open;
  for (;;) {
    Round& round = rounds.emplace_back();
    if (rounds.size() > 1) round.own = std::make_unique<Held>(held_against(world, log.log(), how));
    round.held = round.own ? round.own.get() : &log;
    answer_round(round, references, causes, [&](const Suspect& suspect) {
      return rounds.size() == 1 ||
             std::any_of(open.begin(), open.end(), [&](const Suspect& s) { return is_same(s, suspect); });
    });
    if (round.answer.sets.empty() || rounds.size() == kRounds) return;
    world = world_with(std::move(world), round.answer);
    for (const std::size_t m : round.answer.sets.front().members)
      taken.insert(shown_in(round.family, round.family.suspects[m]));
    // Beside it are sought causes of the errors that it leaves in other channels.
    const std::set<std::string> much = left_much(round.answer);
    open.clear();
    for (const Suspect& suspect : round.family.suspects) {
      const std::string channel = shown_in(round.family, suspect);
      if (much.contains(channel) && !taken.contains(channel)) open.push_back(suspect);
    }
    // How full the battery was at first under load is told by the voltage, with what was found: what remains is told
    // from there.
    if (open.empty() && round.held->seen.comparison.facts.starts_at_rest) return;
  }
}

bool explains_more(const std::deque<Round>& better, const std::deque<Round>& worse,
                   const std::vector<Held>& references, const std::vector<plant::Cause>& causes) {
  if (better.front().answer.sets.empty()) return false;
  const auto last = [](const std::deque<Round>& of) -> const Fit& {
    const AnswerOf& answer = of.back().answer;
    return answer.sets.empty() ? answer.nothing : answer.sets.front().fit;
  };
  const Family& family = better.back().family;
  const Asked asked(sounds_of(references, causes));
  constexpr double kAnySize = 0.0;  // branches that are charged are no signature of the cause that they look like
  return lead_of(last(better), last(worse)).decisive &&
         !is_clearly_better(family, last(worse), last(better), kAnySize, asked);
}

std::optional<Unnamed> remainder_of(const AnswerOf& answer, const Observed& log,
                                    const std::vector<Sound>& references) {
  const std::size_t at = answer.sets.front().use.channel;
  const std::string& name = answer.family->channel[at];
  double usual = 0.0;
  for (const Sound& reference : references) {
    const Family& theirs = reference({});
    const AnswerOf nothing = nothing_of(theirs);
    for (std::size_t c = 0; c < theirs.channel.size(); ++c) {
      if (theirs.channel[c] == name) usual = std::max(usual, remains(nothing, c));
    }
  }
  const double left = remains(answer, at), before = error_of(answer, log).practical;
  const double least = references.empty() ? least_alone(log, name)
                                          : std::max(1.0 + kBeyond * usual, least_between_rows(log, name));
  if (left < std::max(least, kPart * before)) return std::nullopt;
  return Unnamed{name, balance_of(log, name), left, {}};
}

Unnamed error_of(const AnswerOf& answer, const Observed& log) {
  const std::size_t at = answer.sets.front().use.channel;
  const std::string& name = answer.family->channel[at];
  const double count = std::max(1.0, answer.family->problem.channels[at].all[0].count);
  const double rms = std::sqrt(answer.nothing.left.row(static_cast<Index>(at)).sum() / count);
  return {name, balance_of(log, name), rms / answer.family->practical[at], {}};
}

std::optional<Unnamed> unnamed_beside(std::deque<Round>& rounds, const std::vector<Held>& references) {
  Round& last = rounds.back();
  SoundLogs sound_logs(references);
  std::vector<VectorXd> left;
  const auto shapes = [&] {
    left = left_by(last.held->seen, last.answer);
    return unnamed_of(*last.held, left, sound_logs);
  };
  std::optional<Unnamed> out = shapes();
  if (out && takes_usually(last.answer, out->channel)) {
    say_usual(last.answer);
    out = shapes();
  }
  for (const Round& round : rounds) {
    if (!out || round.answer.sets.empty()) continue;
    const Unnamed whole = error_of(round.answer, round.held->seen);
    if (whole.channel == out->channel && out->practical < kPart * whole.practical) out.reset();
  }
  for (const Round& round : rounds) {
    if (out || round.answer.sets.empty()) continue;
    const std::size_t at = round.answer.sets.front().use.channel;
    const ReadChannel& channel = last.held->seen.channels[at];
    if (references.empty() && is_known_by_sound(last.held->seen, channel.balance)) continue;
    const double usual = sound_logs.error(channel.name);
    const double error = beyond_white(left[at]) / channel.practical;
    const double least =
        references.empty() ? least_alone(last.held->seen, channel.name) : 1.0 + kBeyond * usual;
    if (error > std::max(least, kPart * error_of(round.answer, round.held->seen).practical))
      out = Unnamed{channel.name, channel.balance, error, {}};
  }
  return out ? out : far_off(*last.held, left, sound_logs);
}

}  // namespace voltlap::explain
