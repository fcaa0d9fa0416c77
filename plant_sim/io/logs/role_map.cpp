// SPDX-License-Identifier: Apache-2.0
#include "io/logs/role_map.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <string_view>

#include "core/errors.hpp"

namespace voltlap::plant {

const RoleSource* RoleMap::find(const std::string& role) const {
  const auto found = roles.find(role);
  return found == roles.end() ? nullptr : &found->second;
}

std::string path_in_map(const RoleMap& map, const std::string& text) {
  constexpr std::string_view kVariable = "$VOLTLAP_DATA";
  if (!text.starts_with(kVariable)) {
    // An absolute path replaces what stands before it.
    return (std::filesystem::path(map.source).parent_path() / text).lexically_normal().string();
  }
  const char* folder = std::getenv("VOLTLAP_DATA");
  if (folder == nullptr || *folder == '\0') {
    throw InputError(map.source, fmt::format("\"{}\" while VOLTLAP_DATA is not set", text),
                     "the folder of measured data in VOLTLAP_DATA",
                     "Set it, or copy the map and give the path there");
  }
  return folder + text.substr(kVariable.size());
}

}  // namespace voltlap::plant
