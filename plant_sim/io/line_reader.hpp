// SPDX-License-Identifier: Apache-2.0
// Lines of a text file one after the other, plain or gzipped, without the whole of it in memory.
#pragma once
#include <zlib.h>

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace voltlap::plant {

class LineReader {
 public:
  /// `expected` says in the message what the file should have been. Throws InputError when it cannot be opened.
  explicit LineReader(const std::string& path, const char* expected = "a text file, plain or gzipped");

  /// The next line without its end (LF or CR LF) into `line`, valid until the next call; false at the end of the
  /// file. Throws InputError for a damaged gzip stream and for a line beyond 1 MB, which no text file has.
  bool next(std::string_view& line);
  /// Number of the line read last, from 1.
  [[nodiscard]] std::size_t number() const { return number_; }
  [[nodiscard]] const std::string& path() const { return path_; }
  /// "file:line" of the line read last.
  [[nodiscard]] std::string place() const;

 private:
  bool refill();

  std::string path_;
  std::unique_ptr<gzFile_s, int (*)(gzFile)> file_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0, number_ = 0;
  bool at_end_ = false;
};

}  // namespace voltlap::plant
