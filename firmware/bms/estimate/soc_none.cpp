// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/soc_none.hpp"

namespace voltlap::bms {

/// Field by field: a whole SocEstimate in passing is 16 kB of stack with 144 cells. Nobody reads the filter of an
/// estimate that is not valid.
void soc_none(SocEstimate& state) {
  state.value = Soc{};
  state.valid = false;
  state.charge = 0;
  state.last_current = Sample<Current>{};
}

}  // namespace voltlap::bms
