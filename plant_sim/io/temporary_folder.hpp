// SPDX-License-Identifier: Apache-2.0
// A folder for what a command makes on the way; gone with it.
#pragma once
#include <string>

namespace voltlap::plant {

class TemporaryFolder {
 public:
  /// In TMPDIR, else /tmp. Throws OutputError.
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace voltlap::plant
