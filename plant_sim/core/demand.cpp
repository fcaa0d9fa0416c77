// SPDX-License-Identifier: Apache-2.0
#include "core/demand.hpp"

#include <stdexcept>
#include <string>

namespace voltlap::plant {

void demand_failed(const char* condition, const char* file, int line) {
  const std::string path = file;
  const std::size_t slash = path.find_last_of('/');
  const std::string name = slash == std::string::npos ? path : path.substr(slash + 1);
  throw std::logic_error(name + ":" + std::to_string(line) + ": not so: " + condition);
}

}  // namespace voltlap::plant
