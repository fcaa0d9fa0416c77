// SPDX-License-Identifier: Apache-2.0
// Rows of a table's text: UTF-16 brought to UTF-8, a quoted field's line breaks kept within its row.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/line_reader.hpp"

namespace voltlap::plant {

/// As UTF-8: text that is none is taken for Latin-1, as programs write degrees and micro in it.
[[nodiscard]] std::string utf8_of(std::string_view text);

class TableLines {
 public:
  TableLines(const std::string& path, const char* expected);

  /// The next row's text, valid until the next call; false at the end. Throws InputError for a quotation mark that is
  /// never closed.
  bool next(std::string_view& text);
  /// Line in the file at which the row read last begins, from 1.
  [[nodiscard]] std::size_t line() const { return line_; }
  [[nodiscard]] bool was_utf16() const { return whole_.has_value(); }

 private:
  bool next_line(std::string_view& text);

  std::string path_;
  LineReader lines_;
  std::optional<std::string> whole_;  ///< of a UTF-16 file, as UTF-8
  std::size_t at_ = 0, number_ = 0, line_ = 0;
  std::string joined_;
};

/// A field of a row, without blanks and quotation marks around it.
struct TableField {
  std::string_view text;
  bool quoted = false;
};

/// `separator` ' ' stands for runs of blanks. `unescaped` keeps what "" within quotes was mended to.
void split_row(std::string_view text, char separator, std::vector<TableField>& fields,
               std::vector<std::string>& unescaped);

}  // namespace voltlap::plant
