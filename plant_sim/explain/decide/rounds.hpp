// SPDX-License-Identifier: Apache-2.0
// What is wrong with the whole car: up to three causes at once, and beside them what else is, in channels whose
// error they were not found for.
#pragma once
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "explain/decide/answer.hpp"
#include "explain/decide/unknown.hpp"
#include "explain/model/held.hpp"

namespace voltlap::explain {

/// What is wrong with all, beside what earlier rounds found.
struct Round {
  std::unique_ptr<Held> own;  ///< the log against the model with what was found; the first has none
  const Held* held = nullptr;
  Family family;
  AnswerOf answer;
};

/// Appends rounds until one finds nothing, or nothing of practical size is left.
void put_rounds(const Held& log, const std::vector<Held>& references, const std::vector<plant::Cause>& causes,
                const Holding& how, std::deque<Round>& rounds);

/// Does what was found in one way to hold a log, with all that it takes, explain more of it than what was found in
/// another, and leave no more of any channel?
[[nodiscard]] bool explains_more(const std::deque<Round>& better, const std::deque<Round>& worse,
                                 const std::vector<Held>& references, const std::vector<plant::Cause>& causes);

/// What an answer about one member leaves of it, more than references have: the answer is a part.
[[nodiscard]] std::optional<Unnamed> remainder_of(const AnswerOf& answer, const Observed& log,
                                                  const std::vector<Sound>& references);
/// The error of that channel as if nothing were said of it.
[[nodiscard]] Unnamed error_of(const AnswerOf& answer, const Observed& log);
/// Smooth shapes that sound logs do not have, or else more than sound logs have in a channel that a cause was found
/// for: then it is a part. Where no cause is said and such shapes are there, usual sets that take as much are said
/// after all.
[[nodiscard]] std::optional<Unnamed> unnamed_beside(std::deque<Round>& rounds, const std::vector<Held>& references);

}  // namespace voltlap::explain
