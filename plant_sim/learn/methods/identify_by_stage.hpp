// SPDX-License-Identifier: Apache-2.0
// Recordings to a model by one of the pulse or layered methods, and the start that the final full method takes.
#pragma once
#include "learn/identify/identify.hpp"
#include "learn/identify/preparation/prepared_log.hpp"

namespace voltlap::plant {

/// identify() for a method other than ffo, which `options.method` names. A run is identified by itself; several are
/// averaged. There are no intervals: sigma is NaN. Throws InputError for recordings that are no pulse tests.
[[nodiscard]] IdentifyResult identify_by_stage(const std::vector<CellLog>& logs, const IdentifyOptions& options);

/// The mean of the recordings' ipo models.
[[nodiscard]] CircuitModel initial_pulse_model(const std::vector<PreparedLog>& prepared);

}  // namespace voltlap::plant
