// SPDX-License-Identifier: Apache-2.0
// The answer as the contract has it: verdict, sentence, causes, gain, pictures.
#pragma once
#include <optional>
#include <vector>

#include "discrepancy/integrity.hpp"
#include "explain/decide/answer.hpp"
#include "explain/decide/unknown.hpp"

namespace voltlap::explain {

struct Saying {
  const plant::Model& model;
  const std::vector<plant::Cause>& causes;
  std::vector<plant::FoundCause> gate;
  std::vector<AnswerOf> members;
  AnswerOf global;
  std::vector<VectorXd> left;  ///< by channel, beyond the answer
  std::optional<Unnamed> unnamed;
  bool with_references = false;
};

[[nodiscard]] plant::Explanation said(const Saying& saying, const plant::Gated& gated, const Observed& seen,
                                      const Observed& without_members);
[[nodiscard]] plant::Explanation too_little(const Saying& saying, const plant::Gated& gated);

/// Residuals as they are, and beyond the first set of an answer with where its log began.
[[nodiscard]] std::vector<VectorXd> residuals_of(const Observed& log);
[[nodiscard]] std::vector<VectorXd> left_by(const Observed& log, const AnswerOf& answer,
                                            const std::vector<plant::Cause>& causes);

}  // namespace voltlap::explain
