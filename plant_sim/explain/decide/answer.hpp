// SPDX-License-Identifier: Apache-2.0
// Which sets are the answer of a family: of those that stand the smallest that the best does not beat decisively
// and that do the same job.
#pragma once
#include <vector>

#include "explain/decide/usual.hpp"

namespace voltlap::explain {

struct AnswerOf {
  const Family* family = nullptr;
  std::vector<Set> sets;   ///< the most probable first; empty: nothing is wrong here
  std::vector<Set> usual;  ///< then: sets that take something, and no more than sound logs may show of them
  std::vector<std::vector<std::size_t>>
      equivalent;           ///< by member of the first set: suspects that look the same here
  std::vector<Set> beaten;  ///< that lost, for the reader
  Fit nothing;
};

/// `refine`: a set where its causes' bends are followed; the linear one where there is nothing to follow.
using Refine = std::function<Set(const Family&, const Set&)>;
[[nodiscard]] AnswerOf answer_of(const Family& family, Search& search, const Asked& asked, const Refine& refine);

/// Says the sets that are usual by themselves after all: sound logs do not have the error that they take.
void say_usual(AnswerOf& answer);

/// Decisively, and by more of the plain error than what models miss anyway: a likelihood of exact models would decide
/// by errors that nobody can see, and one of rough models by those that sound logs have. `use`: what the better one
/// takes, in practical sizes.
[[nodiscard]] bool is_clearly_better(const Family& family, const Fit& best, const Fit& other, double use,
                                     const Asked& asked);

/// A world with the causes of an answer's first set; the world as it is where there is none.
[[nodiscard]] plant::World world_with(plant::World world, const AnswerOf& answer);

/// Cosine between what two sets take from the log, at the noise of the first, what nuisances take aside.
[[nodiscard]] double overlap(const Family& family, const Set& a, const Set& b);

}  // namespace voltlap::explain
