// SPDX-License-Identifier: Apache-2.0
// The current sensor reads a constant too much: drift.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause current_offset() {
  return {.name = "current_offset",
          .balance = Balance::kCharge,
          .says = "the current sensor reads {} too much all the time",
          .test = "half a minute with open contactors: the sensor must read zero",
          .parameters = {{"current_a", "A", -10, 10, 0.5, 1, "A"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            return with_counted_soc(plain_form(1, [](World& w, Values v) { w.current.offset += v[0]; }), c);
          }};
}

}  // namespace voltlap::plant
