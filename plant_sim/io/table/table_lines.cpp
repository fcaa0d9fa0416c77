// SPDX-License-Identifier: Apache-2.0
#include "io/table/table_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/table/number_field.hpp"

namespace voltlap::plant {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // spreadsheets put it before UTF-8
constexpr std::size_t kLongestQuote = 20;                     // lines

void append_utf8(std::uint32_t code, std::string& out) {
  const auto put = [&](std::uint32_t byte) { out += static_cast<char>(static_cast<unsigned char>(byte)); };
  if (code < 0x80) return put(code);
  if (code < 0x800) {
    put(0xC0 | (code >> 6));
  } else if (code < 0x10000) {
    put(0xE0 | (code >> 12));
    put(0x80 | ((code >> 6) & 0x3F));
  } else {
    put(0xF0 | (code >> 18));
    put(0x80 | ((code >> 12) & 0x3F));
    put(0x80 | ((code >> 6) & 0x3F));
  }
  put(0x80 | (code & 0x3F));
}

/// The whole of a file that begins with the byte order mark of UTF-16; nothing for any other.
std::optional<std::string> utf16_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  char mark[2] = {};
  if (!in.read(mark, 2)) return std::nullopt;
  const bool little = mark[0] == '\xFF' && mark[1] == '\xFE', big = mark[0] == '\xFE' && mark[1] == '\xFF';
  if (!little && !big) return std::nullopt;
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const auto unit = [&](std::size_t at) {
    const auto low = static_cast<unsigned char>(bytes[little ? at : at + 1]);
    const auto high = static_cast<unsigned char>(bytes[little ? at + 1 : at]);
    return static_cast<std::uint32_t>(low | (high << 8));
  };
  std::string out;
  out.reserve(bytes.size() / 2);
  for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) {
    std::uint32_t code = unit(at);
    if (code >= 0xD800 && code < 0xDC00 && at + 3 < bytes.size()) {
      code = 0x10000 + ((code - 0xD800) << 10) + (unit(at + 2) - 0xDC00);
      at += 2;
    }
    append_utf8(code, out);
  }
  return out;
}

bool is_utf8(std::string_view text) {
  std::size_t following = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (following > 0) {
      if ((byte & 0xC0) != 0x80) return false;
      --following;
    } else if (byte >= 0x80) {
      following = byte >= 0xF0 ? 3 : byte >= 0xE0 ? 2 : 1;
      if (byte < 0xC2 || byte > 0xF4) return false;
    }
  }
  return following == 0;
}

/// A quotation mark at the beginning of a field that its line does not close.
bool is_quote_open(std::string_view text) {
  if (std::count(text.begin(), text.end(), '"') % 2 == 0) return false;
  for (std::size_t at = text.find('"'); at != std::string_view::npos; at = text.find('"', at + 1)) {
    const std::string_view before = trimmed(text.substr(0, at));
    if (before.empty() || std::string_view(",;|").find(before.back()) != std::string_view::npos ||
        text[at - 1] == '\t') {
      return true;
    }
  }
  return false;
}

}  // namespace

std::string utf8_of(std::string_view text) {
  if (is_utf8(text)) return std::string(text);
  std::string out;
  for (const char c : text) append_utf8(static_cast<unsigned char>(c), out);
  return out;
}

TableLines::TableLines(const std::string& path, const char* expected)
    : path_(path), lines_(path, expected), whole_(utf16_file(path)) {}

bool TableLines::next_line(std::string_view& text) {
  if (!whole_) {
    if (!lines_.next(text)) return false;
    number_ = lines_.number();
  } else {
    if (at_ >= whole_->size()) return false;
    const std::size_t end = std::min(whole_->find_first_of("\r\n", at_), whole_->size());
    text = std::string_view(*whole_).substr(at_, end - at_);
    at_ = end + (whole_->compare(end, 2, "\r\n") == 0 ? 2 : 1);
    ++number_;
  }
  if (number_ == 1 && text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  return true;
}

bool TableLines::next(std::string_view& text) {
  if (!next_line(text)) return false;
  line_ = number_;
  if (std::memchr(text.data(), '"', text.size()) == nullptr || !is_quote_open(text)) return true;
  joined_ = text;
  for (std::size_t k = 0; k < kLongestQuote; ++k) {
    if (!next_line(text)) break;
    joined_ += '\n';
    joined_ += text;
    if (std::count(joined_.begin(), joined_.end(), '"') % 2 == 0) {
      text = joined_;
      return true;
    }
  }
  throw InputError(fmt::format("{}:{}", path_, line_), "a quotation mark that is never closed",
                   "two around a field", "Close it or take it out");
}

void split_row(std::string_view text, char separator, std::vector<TableField>& fields,
               std::vector<std::string>& unescaped) {
  fields.clear();
  unescaped.clear();
  unescaped.reserve(text.size() / 2 + 1);  // fields point into it
  std::size_t at = 0;
  const auto is_separator = [&](char c) { return separator == ' ' ? c == ' ' || c == '\t' : c == separator; };
  const auto is_blank = [&](char c) { return c == ' ' || (c == '\t' && separator != '\t'); };
  for (;;) {
    while (at < text.size() && is_blank(text[at])) ++at;
    if (separator == ' ' && at == text.size()) return;
    if (at < text.size() && text[at] == '"') {
      std::size_t end = at + 1;
      bool escaped = false;
      while (end < text.size() && (text[end] != '"' || (end + 1 < text.size() && text[end + 1] == '"'))) {
        escaped |= text[end] == '"';
        end += text[end] == '"' ? 2 : 1;
      }
      end = std::min(end, text.size());
      std::string_view inside = text.substr(at + 1, end - at - 1);
      if (escaped) {
        std::string& mended = unescaped.emplace_back();
        for (std::size_t k = 0; k < inside.size(); ++k) {
          mended += inside[k];
          if (inside[k] == '"') ++k;
        }
        inside = mended;
      }
      fields.push_back({trimmed(inside), true});
      at = std::min(end + 1, text.size());
      while (at < text.size() && !is_separator(text[at])) ++at;
    } else {
      std::size_t end = at;
      while (end < text.size() && !is_separator(text[end])) ++end;
      fields.push_back({trimmed(text.substr(at, end - at)), false});
      at = end;
    }
    if (at >= text.size()) return;
    ++at;
  }
}

}  // namespace voltlap::plant
