// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/members.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "explain/decide/rounds.hpp"
#include "explain/fit/refine.hpp"
#include "explain/model/between_rows.hpp"
#include "explain/model/unstepped.hpp"

namespace voltlap::explain {
namespace {

constexpr double kLeastUse = 0.7;     // practical sizes; less than Search asks for
constexpr std::size_t kOneByOne = 6;  // members that are wrong, each taken out before the next is judged

/// The same member in each reference.
std::vector<Sound> same_member(const std::vector<Held>& references, const std::string& role,
                               const std::vector<plant::Cause>& causes) {
  std::vector<Sound> out;
  for (const Held& reference : references) {
    for (const Member& member : reference.seen.members) {
      if (member.channel.name != role) continue;
      out.push_back(
          sound([&](const Wanted& wanted) { return member_family(reference.seen, member, causes, wanted); }));
    }
  }
  return out;
}

/// What a member leaves where only its starts are fitted, in practical sizes.
double error_of(const Family& family) {
  const Fit nothing = fit_of(family.problem, {});
  return error_in(family, nothing, nothing, 0);
}

/// Is it read in turn with so many others that what a drive does between two turns says how late a value is?
bool is_read_seldom(const plant::Recording& log, const std::string& role) {
  constexpr double kTurn_s = 0.15;
  return log.age_s.contains(role) && usual_interval_s(log, role) > kTurn_s;
}

}  // namespace

Sound sound(std::function<Family(const Wanted&)> family_of) {
  struct Known {
    std::vector<Suspect> asked;
    std::unique_ptr<Family> family;
  };
  auto known = std::make_shared<std::vector<Known>>();
  return [known, family_of = std::move(family_of)](const std::vector<Suspect>& asked) -> const Family& {
    const auto found = std::find_if(known->begin(), known->end(), [&](const Known& k) {
      return std::equal(k.asked.begin(), k.asked.end(), asked.begin(), asked.end(), is_same);
    });
    if (found != known->end()) return *found->family;
    const Wanted wanted = [&](const Suspect& s) {
      return std::any_of(asked.begin(), asked.end(), [&](const Suspect& a) { return is_same(s, a); });
    };
    known->push_back({asked, std::make_unique<Family>(family_of(wanted))});
    return *known->back().family;
  };
}

bool is_of(const std::vector<AnswerOf>& answers, const std::string& role) {
  return std::any_of(answers.begin(), answers.end(),
                     [&](const AnswerOf& answer) { return answer.family->channel.front() == role; });
}

std::vector<AnswerOf> member_answers(Held& held, const std::vector<Held>& references,
                                     const std::vector<plant::Cause>& causes,
                                     const std::function<bool(const std::string&)>& asked) {
  std::vector<AnswerOf> out;
  held.members.resize(held.seen.members.size());
  for (std::size_t k = 0; k < held.members.size(); ++k) {
    const Member& member = held.seen.members[k];
    if (!asked(member.channel.name) || most_of_member(held.seen, member, causes) < kLeastUse) continue;
    const auto alike = std::count_if(held.seen.members.begin(), held.seen.members.end(),
                                     [&](const Member& other) { return other.group == member.group; });
    held.members[k] = member_family(held.seen, member, causes, all_suspects);
    const std::vector<Sound> theirs = same_member(references, member.channel.name, causes);
    if (!theirs.empty()) bound_noise(held.members[k], theirs);  // how cells differ anyway is not known without
    Search search(held.members[k], causes);
    const Fit& nothing = search.nothing();
    const auto followed = [&](const Family& of, const Set& set) {
      const bool bends = std::any_of(set.members.begin(), set.members.end(),
                                     [&](std::size_t m) { return bool(of.suspects[m].form.curved); });
      if (!bends) return set;
      return refined(causes, of, nothing, set,
                     [&](const SetValues& at) { return member_at_values(held.seen, member, causes, of, at); });
    };
    AnswerOf answer = answer_of(held.members[k], search, Asked(theirs, static_cast<double>(alike)), followed);
    if (!answer.sets.empty()) out.push_back(std::move(answer));
  }
  return out;
}

std::vector<AnswerOf> worst_first(Held& held, const std::vector<Held>& references,
                                  const std::vector<plant::Cause>& causes, const Holding& how,
                                  std::deque<Held>& without) {
  std::vector<AnswerOf> out,
      open = member_answers(held, references, causes, [](const std::string&) { return true; });
  while (!open.empty()) {
    const auto worst = std::max_element(open.begin(), open.end(), [](const AnswerOf& a, const AnswerOf& b) {
      return a.sets.front().use.practical < b.sets.front().use.practical;
    });
    out.push_back(*worst);
    open.erase(worst);
    if (open.empty()) break;
    if (out.size() == kOneByOne) {
      out.insert(out.end(), open.begin(), open.end());  // what is left is said, beside one mean
      break;
    }
    without.push_back(held_against(held.world, corrected(held.log(), effects_of(held, out)), how));
    open = member_answers(without.back(), references, causes,
                          [&](const std::string& role) { return is_of(open, role); });
  }
  return out;
}

bool follows_from_cell(const Held& held, const AnswerOf& answer, const std::vector<AnswerOf>& answers) {
  const std::string& role = answer.family->channel.front();
  const auto thermistors = held.log().numbered("temperature_");
  if (!role.starts_with("temperature_") || thermistors.size() != held.log().numbered("cell_voltage_").size())
    return false;
  const std::string cell = "cell_voltage_" + role.substr(role.find_last_of('_') + 1);
  return std::any_of(answers.begin(), answers.end(), [&](const AnswerOf& other) {
    const Set& set = other.sets.front();
    return other.family->channel.front() == cell &&
           std::any_of(set.members.begin(), set.members.end(),
                       [&](std::size_t m) { return !other.family->suspects[m].form.of_sensor; });
  });
}

std::vector<MemberEffect> effects_of(const Held& held, const std::vector<AnswerOf>& answers) {
  std::vector<MemberEffect> out;
  for (const AnswerOf& answer : answers) {
    const Set& set = answer.sets.front();
    for (std::size_t m = 0; m < set.members.size(); ++m) {
      const Suspect& c = answer.family->suspects[set.members[m]];
      out.push_back({c.channel, c.form.of_sensor || c.channel.starts_with("temperature_"),
                     member_effect(c.form, held.seen, set.values[m])});
    }
  }
  return out;
}

std::optional<Unnamed> unnamed_member(const Held& held, const std::vector<Held>& references,
                                      const std::vector<plant::Cause>& causes, const std::vector<AnswerOf>& said) {
  // Behind coarse steps a drive of minutes passes few of them, and the straight line between two of another curve is
  // no error: 24 sound drives of 5 minutes, steps of 1 K, had 2.2 practical sizes at most.
  constexpr double kLeast = 2.0, kLeastInSteps = 3.0;  // practical sizes
  constexpr double kBeyond = 3.0;                      // of what references have
  constexpr double kOfApart = 1.5;                     // of what its time may make of it
  std::optional<Unnamed> out;
  for (const AnswerOf& answer : said) {
    const auto left =
        remainder_of(answer, held.seen, same_member(references, answer.family->channel.front(), causes));
    if (left && (!out || left->practical > out->practical)) out = left;
  }
  if (!said.empty()) return out;
  // Cells are read in turn: where the current is another in each row, a value that was held is of another current.
  // Beside references as well, where no voltage is of its time: one drive is switched more often than another.
  const bool beside_none = references.empty() || !held.seen.comparison.log.has_voltage_of_its_time();
  const bool of_another = beside_none && is_between_rows(held.seen.comparison);
  for (std::size_t k = 0; k < held.members.size(); ++k) {
    const ReadChannel& channel = held.seen.members[k].channel;
    const double count = std::max(1.0, static_cast<double>(channel.residual.size()));
    const bool in_steps = references.empty() && was_read_in_steps(held.seen.read, channel.name);
    const double least = std::max(in_steps ? kLeastInSteps : kLeast, kOfApart * channel.apart);
    if (std::sqrt(channel.residual.squaredNorm() / count) < least * channel.practical) continue;
    if (references.empty() && is_read_seldom(held.seen.read, channel.name)) continue;
    if (of_another && channel.name.starts_with("cell_voltage_")) continue;
    const double off = error_of(member_family(held.seen, held.seen.members[k], {}, all_suspects));
    if (off < least || (out && off < out->practical)) continue;
    double usual = 0.0;
    for (const Sound& reference : same_member(references, channel.name, causes))
      usual = std::max(usual, error_of(reference({})));
    if (off > kBeyond * usual) out = Unnamed{channel.name, channel.balance, off, {}};
  }
  return out;
}

}  // namespace voltlap::explain
