// SPDX-License-Identifier: Apache-2.0
// The answer as the contract has it: verdict, sentence, causes, gain, pictures.
#pragma once
#include <map>
#include <optional>
#include <vector>

#include "explain/decide/answer.hpp"
#include "explain/decide/unknown.hpp"
#include "explain/gate/integrity.hpp"

namespace voltlap::explain {

struct Saying {
  const plant::Model& model;
  const std::vector<plant::Cause>& causes;
  std::vector<plant::FoundCause> gate;
  std::vector<AnswerOf> members;
  std::vector<const AnswerOf*> global;  ///< one after the other, each beside those before
  std::vector<VectorXd> left, left_s;   ///< by channel, beyond the answer, and at which times
  std::optional<Unnamed> unnamed;
  std::map<std::string, plant::ChannelGain> gain;  ///< where it was measured on what no fit saw at all
  bool with_references = false;
};

[[nodiscard]] plant::Explanation said(const Saying& saying, const plant::Gated& gated, const Observed& seen,
                                      const Observed& without_members);
[[nodiscard]] plant::Explanation too_little(const Saying& saying, const plant::Gated& gated);

/// Residuals by channel beyond the first set of an answer (or nothing) with where its log began.
[[nodiscard]] std::vector<VectorXd> left_by(const Observed& log, const AnswerOf& answer);

/// What is worth a word twice, beyond the noise, of a log of which nothing is told without references: it may be what
/// was between the rows, or what a sound model misses as well. Empty where nothing is.
[[nodiscard]] std::string left_untold(const Observed& log, const plant::Explanation& out);

/// Of a log that does not say how warm the air was: how warm it had to be for what is said. Empty where that is as the
/// model says.
[[nodiscard]] std::string air_taken(const Observed& log, const AnswerOf& answer);

}  // namespace voltlap::explain
