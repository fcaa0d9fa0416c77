// SPDX-License-Identifier: Apache-2.0
// What an identification says of one recording once there is a model: its span, and how the model follows it.
#pragma once
#include "learn/identify/identify.hpp"
#include "learn/identify/preparation.hpp"

namespace voltlap::plant {

/// `error_v`: model less recorded, at every row of `whole`.
[[nodiscard]] FileFinding file_finding(const PreparedLog& prepared, const TestRun& whole,
                                       const Eigen::VectorXd& error_v);

}  // namespace voltlap::plant
