// SPDX-License-Identifier: Apache-2.0
// What is wrong with single cells and thermistors, each against the mean of the others.
#pragma once
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "explain/decide/answer.hpp"
#include "explain/decide/unknown.hpp"
#include "explain/model/corrected.hpp"
#include "explain/model/held.hpp"

namespace voltlap::explain {

/// The same suspects in a sound log; `family_of` makes what was not asked for before.
[[nodiscard]] Sound sound(std::function<Family(const Wanted&)> family_of);

/// Is one of them about this member?
[[nodiscard]] bool is_of(const std::vector<AnswerOf>& answers, const std::string& role);
/// What is wrong with each of the members that are asked for, where something is.
[[nodiscard]] std::vector<AnswerOf> member_answers(Held& held, const std::vector<Held>& references,
                                                   const std::vector<plant::Cause>& causes,
                                                   const std::function<bool(const std::string&)>& asked);
/// What is wrong with members, the worst first: each is taken out before the next is judged, for all others differ
/// from a mean that it is part of. `without`: the logs without them, which the answers' families live in.
[[nodiscard]] std::vector<AnswerOf> worst_first(Held& held, const std::vector<Held>& references,
                                                const std::vector<plant::Cause>& causes, const Holding& how,
                                                std::deque<Held>& without);
/// Does this answer say how warm a cell is that another answer names? A cell that is weak or leaks warms its
/// thermistor: where every cell has one, that of its number.
[[nodiscard]] bool follows_from_cell(const Held& held, const AnswerOf& answer,
                                     const std::vector<AnswerOf>& answers);
/// What the first set of each answer puts into its member's readings.
[[nodiscard]] std::vector<MemberEffect> effects_of(const Held& held, const std::vector<AnswerOf>& answers);
/// The member that is most off beyond what is said of members, more than in references.
[[nodiscard]] std::optional<Unnamed> unnamed_member(const Held& held, const std::vector<Held>& references,
                                                    const std::vector<plant::Cause>& causes,
                                                    const std::vector<AnswerOf>& said);

}  // namespace voltlap::explain
