// SPDX-License-Identifier: Apache-2.0
// Given a measured log and a model: what the simulation gets wrong, by which cause, how large, and what that is
// worth on minutes the fit has not seen. See docs/explain.md.
#pragma once
#include "discrepancy/explain.hpp"

namespace voltlap::explain {

/// Throws what reading and simulating throw; every other outcome is a verdict.
[[nodiscard]] plant::Explanation explain(const plant::Model& model, const plant::Recording& log,
                                         const plant::ExplainOptions& options);

}  // namespace voltlap::explain
