// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "core/errors.hpp"
#include "core/parameter_file.hpp"
#include "core/parameter_table.hpp"

namespace voltlap::plant {
namespace {

namespace fs = std::filesystem;

const char* extension_of(const std::string& kind) { return kind == "tracks" ? ".csv" : ".toml"; }

/// A member of the folder, in words.
std::string word_for(const std::string& kind) {
  return kind == "bench" ? "bench plan" : kind.substr(0, kind.size() - 1);
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored) && !fs::is_directory(path, ignored);
}

}  // namespace

std::vector<std::string> DataFolder::names(const std::string& kind) const {
  std::error_code error;
  fs::directory_iterator entries(fs::path(root_) / kind, error);
  if (error) {
    throw InputError(root_ + "/" + kind, fmt::format("a folder that cannot be read ({})", error.message()),
                     "the project's data where the program was built",
                     "Run ./voltlap build again if the project has moved");
  }
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : entries) {
    if (entry.path().extension() == extension_of(kind)) names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string DataFolder::find(const std::string& kind, const std::string& name, const std::string& place,
                             const std::string& beside) const {
  const fs::path own = fs::path(root_) / kind / (name + extension_of(kind));
  if (name.find('/') == std::string::npos && is_file(own)) return own.string();
  if (!beside.empty() && is_file(fs::path(beside) / name)) return (fs::path(beside) / name).string();
  if (is_file(name)) return name;
  const std::vector<std::string> known = names(kind);
  const std::string one = word_for(kind), nearest = nearest_of(name, known, name.size() / 2);
  std::error_code ignored;
  throw InputError(
      fmt::format("{}: found \"{}\", {}; expected a {} ({}) or the path of a {} file. {}Correct the name or the path.",
                  place, name, fs::is_directory(name, ignored) ? "a folder" : "neither a known name nor a file", one,
                  fmt::join(known, ", "), extension_of(kind), nearest.empty() ? "" : "Did you mean " + nearest + "? "));
}

}  // namespace voltlap::plant
