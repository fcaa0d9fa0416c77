// SPDX-License-Identifier: Apache-2.0
// Lines of a text file one after the other, plain, gzip or zstd, without the whole of it in memory.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "io/byte_source.hpp"

namespace voltlap::plant {

/// What is done with a file whose compressed stream breaks off or is damaged.
enum class BrokenStream {
  kRefuse,  ///< InputError where it breaks off
  kKeep,    ///< the whole lines before it are given; LineReader::broken says why there are no more
};

class LineReader {
 public:
  /// `expected` says in the message what the file should have been. Throws InputError when it cannot be opened.
  explicit LineReader(const std::string& path, const char* expected = "a text file, plain or compressed",
                      BrokenStream broken = BrokenStream::kRefuse);

  /// The next line without its end (LF, CR LF or CR) into `line`, valid until the next call; false at the end of
  /// the file. Throws InputError for a broken stream and for a line beyond 1 MB, which no text file has.
  bool next(std::string_view& line);
  /// Number of the line read last, from 1.
  [[nodiscard]] std::size_t number() const { return number_; }
  [[nodiscard]] const std::string& path() const { return path_; }
  /// "file:line" of the line read last.
  [[nodiscard]] std::string place() const;
  /// Why the stream ended before its end; empty when it did not.
  [[nodiscard]] const std::string& broken() const { return source_.broken(); }

 private:
  bool refill();
  bool give(std::size_t length, std::size_t end_of_line, std::string_view& line);

  std::string path_;
  ByteSource source_;
  BrokenStream broken_stream_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0, number_ = 0;
  std::size_t next_lf_ = 0;  ///< no LF lies in [begin_, next_lf_); one at next_lf_, or that is end_
  bool at_end_ = false;
};

}  // namespace voltlap::plant
