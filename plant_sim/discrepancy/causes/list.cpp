// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/causes/list.hpp"

#include <algorithm>

#include "core/errors.hpp"

namespace voltlap::plant {

std::vector<Cause> catalogue(const std::vector<std::string>& without) {
  std::vector<Cause> all;
#define VOLTLAP_ADD(name) all.push_back(name());
  VOLTLAP_CAUSES(VOLTLAP_ADD)
#undef VOLTLAP_ADD
  for (const std::string& name : without) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const Cause& cause) { return cause.name == name; });
    if (found == all.end()) {
      throw InputError("--set explain.without", "\"" + name + "\"", "the name of a cause that regression can find",
                       "docs/explain.md lists them");
    }
    all.erase(found);
  }
  return all;
}

}  // namespace voltlap::plant
