// SPDX-License-Identifier: Apache-2.0
#include "io/temporary_folder.hpp"

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/errors.hpp"

namespace voltlap::plant {

TemporaryFolder::TemporaryFolder() {
  std::error_code error;
  const std::filesystem::path where = std::filesystem::temp_directory_path(error);
  path_ = (where / "voltlap-XXXXXX").string();
  if (error || ::mkdtemp(path_.data()) == nullptr) {
    throw OutputError(path_ + ": no folder can be made there: " + std::strerror(errno) + ". Name another in TMPDIR");
  }
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace voltlap::plant
