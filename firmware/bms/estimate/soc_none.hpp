// SPDX-License-Identifier: Apache-2.0
// No state of charge: always "not known".
#pragma once
#include "bms/estimate/soc_estimator.hpp"

namespace voltlap::bms {

void soc_none(SocEstimate& state);

}  // namespace voltlap::bms
