// SPDX-License-Identifier: Apache-2.0
// The current sensor ends at a limit; what flowed beyond it is missing.
#include <algorithm>
#include <cmath>

#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {
namespace {

/// Largest reading, if at least 20 readings and one in 500 stand exactly there; else 0.
double rail_of(const Eigen::VectorXd& current) {
  double most = 0.0;
  for (const double i : current) most = std::max(most, std::isfinite(i) ? std::abs(i) : 0.0);
  Eigen::Index at = 0, near = 0;
  for (const double i : current) {
    at += std::abs(i) >= most * (1.0 - 1e-6) ? 1 : 0;
    near += std::abs(i) >= most * 0.98 ? 1 : 0;
  }
  return at >= 20 && at * 500 >= current.size() && at * 2 > near ? most : 0.0;
}

}  // namespace

Cause current_saturation() {
  return {.name = "current_saturation",
          .balance = Balance::kCharge,
          .says = "the current sensor ends at {}: what flowed beyond is missing",
          .test = "a pull beyond the limit with a second sensor",
          .parameters =
              {{"limit_a", "A", 1, 5000, 100, 1, "A"},
               {"beyond_a", "A", 0, 1000, 20, 1, "A"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            const double limit = rail_of(*c.log.find("current"));
            if (limit <= 0.0) return {};
            Form form = plain_form(2, [](World& w, Values v) {
              w.current_limit_a = v[0] * (1.0 - 1e-6);
              w.current_beyond_limit_a += v[1];
            });
            form.at[0] = limit;
            form.linear = form.refined = {1};
            return {form};
          },
          .reported = {{"limit_a", "A", 1, 5000, 100, 1, "A"}},
          .report = [](Values v) -> std::vector<double> { return {v[0]}; }};
}

}  // namespace voltlap::plant
