// SPDX-License-Identifier: Apache-2.0
// Frames to samples: only frames that the rx monitor accepts change a sample; samples age by the timeouts of the DBC.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

void ingest(const Config& config, const Input& input, State& state);

}  // namespace voltlap::bms
