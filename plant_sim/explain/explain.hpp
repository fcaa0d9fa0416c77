// SPDX-License-Identifier: Apache-2.0
// Given a measured log and a model: what the simulation gets wrong, by which cause, how large, and what that is
// worth on minutes the fit has not seen. See docs/explain.md.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "explain/balances/model.hpp"
#include "explain/explanation.hpp"

namespace voltlap::explain {

struct ExplainOptions {
  std::vector<plant::Recording> references;
  std::optional<plant::Recording> holdout;                   ///< the gain is measured on it
  std::vector<std::string> without;                          ///< causes that are left out of the catalogue
  std::string fit_blocks = "all";                            ///< of 60 s: all, even or odd
  std::function<void(const std::string&, double)> progress;  ///< what, fraction; may be empty
};

/// Throws what reading and simulating throw; every other outcome is a verdict.
[[nodiscard]] plant::Explanation explain(const plant::Model& model, plant::Recording log, ExplainOptions options);

}  // namespace voltlap::explain
