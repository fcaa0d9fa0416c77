// SPDX-License-Identifier: Apache-2.0
// What an identification says of one recording once there is a model: its span, and how the model follows it.
#pragma once
#include "learn/identify/identify.hpp"
#include "learn/identify/preparation/prepared_log.hpp"

namespace voltlap::plant {

/// `error_v`: model less recorded, at every row of `whole`.
[[nodiscard]] RecordingResult recording_result(const PreparedLog& prepared, const MeasuredRun& whole,
                                       const Eigen::VectorXd& error_v);

}  // namespace voltlap::plant
