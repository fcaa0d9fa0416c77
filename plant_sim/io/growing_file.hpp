// SPDX-License-Identifier: Apache-2.0
// A recording that others read while it grows, and that outlives whoever writes it: under its own name from the
// beginning, whole lines only.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace voltlap::plant {

class GrowingFile {
 public:
  /// Begins the file anew. Throws InputError for what cannot be read while it grows (a pipe, a compressed name) or is
  /// an input, OutputError where it cannot be written.
  explicit GrowingFile(std::string path);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  /// Whole lines, with their ends, handed to the system at once. Throws OutputError when not all of them can be
  /// written; the file then ends behind those of the write before.
  void write(std::string_view lines);
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
  int file_ = -1;
  std::int64_t size_ = 0;
};

}  // namespace voltlap::plant
