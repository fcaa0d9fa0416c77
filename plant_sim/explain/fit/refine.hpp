// SPDX-License-Identifier: Apache-2.0
// The nonlinear fit of a set: Gauss-Newton from its linear one, along the bends of its causes and of where the log
// began. A step that foresees worse than the best one before it is halved.
#pragma once
#include <functional>

#include "explain/fit/search.hpp"

namespace voltlap::explain {

/// A family where a set of its suspects has these values.
using AtValues = std::function<Family(const SetValues&)>;
[[nodiscard]] Set refined(const std::vector<plant::Cause>& causes, const Family& family, const Fit& nothing,
                          const Set& set, const AtValues& at_values);

}  // namespace voltlap::explain
