// SPDX-License-Identifier: Apache-2.0
// The current sensor ends at a limit; what flowed beyond is missing. No signature has the shape of that:
// gate/rail.hpp finds the pile of its readings, and the voltage then says what flowed.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause current_saturation() {
  return {.name = "current_saturation",
          .balance = Balance::kCharge,
          .says = "the current sensor ends at {}: what flowed beyond is missing",
          .test = "a pull beyond the limit with a second sensor",
          .parameters = {{"limit_a", "A", 1, 5000, 100, 1, "A"}},
          .forms = [](const World&, const Comparison&) -> std::vector<Form> { return {}; }};
}

}  // namespace voltlap::plant
