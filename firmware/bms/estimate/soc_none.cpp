// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/soc_none.hpp"

namespace voltlap::bms {

void soc_none(SocEstimate& state) { state = SocEstimate{}; }

}  // namespace voltlap::bms
