// SPDX-License-Identifier: Apache-2.0
// Names in a sentence, no more of them than one reads.
#pragma once
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace voltlap::plant {

/// "a, b, c and 5 more".
[[nodiscard]] inline std::string first_of(const std::vector<std::string>& names, std::size_t shown) {
  const std::size_t count = std::min(shown, names.size());
  const std::vector<std::string> first(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count));
  const std::string more = names.size() > count ? fmt::format(" and {} more", names.size() - count) : "";
  return fmt::format("{}{}", fmt::join(first, ", "), more);
}

}  // namespace voltlap::plant
