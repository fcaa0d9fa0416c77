// SPDX-License-Identifier: Apache-2.0
#include "core/input_files.hpp"

#include <filesystem>
#include <set>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

namespace fs = std::filesystem;

std::set<std::string>& read_files() {
  static std::set<std::string> files;
  return files;
}

/// The same for every spelling of a regular file; empty for what cannot be lost (a pipe, a device, nothing).
std::string identity(const std::string& path) {
  std::error_code unknown;
  return fs::is_regular_file(path, unknown) ? fs::canonical(path, unknown).string() : std::string();
}

}  // namespace

void note_input(const std::string& path) {
  const std::string file = identity(path);
  if (!file.empty()) read_files().insert(file);
}

void refuse_input_as_output(const std::string& path) {
  const std::string file = identity(path);
  if (file.empty() || !read_files().contains(file)) return;
  throw InputError(path, "a file that this run reads", "another one for the result", "Choose another name");
}

}  // namespace voltlap::plant
