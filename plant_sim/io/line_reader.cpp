// SPDX-License-Identifier: Apache-2.0
#include "io/line_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kBuffer = std::size_t{1} << 18;
constexpr std::size_t kLongestLine = std::size_t{1} << 20;

}  // namespace

LineReader::LineReader(const std::string& path, const char* expected, BrokenStream broken)
    : path_(path), source_(path, expected), broken_stream_(broken), buffer_(kBuffer) {}

std::string LineReader::place() const {
  return fmt::format("{}:{}", path_, number_);
}

bool LineReader::refill() {
  VOLTLAP_DEMAND(begin_ <= end_ && end_ <= buffer_.size());
  VOLTLAP_DEMAND(next_lf_ == end_ || at_end_);
  if (at_end_) return false;
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  next_lf_ = end_;
  if (end_ == buffer_.size()) {
    if (end_ >= kLongestLine) {
      throw InputError(fmt::format("{}:{}", path_, number_ + 1), "a line beyond 1 MB", "lines of text",
                       "Check that this is the recording you meant");
    }
    buffer_.resize(2 * buffer_.size());
  }
  const std::size_t got = source_.read({buffer_.data() + end_, buffer_.size() - end_});
  at_end_ = got == 0;
  end_ += got;
  if (at_end_ && !broken().empty() && broken_stream_ == BrokenStream::kRefuse) {
    throw InputError(fmt::format("{}:{}", path_, number_ + 1), broken(), "a whole file",
                     "Copy or compress the recording again; `voltlap log convert` keeps what can be read of it");
  }
  return !at_end_;
}

bool LineReader::give(std::size_t length, std::size_t end_of_line, std::string_view& line) {
  line = std::string_view(buffer_.data() + begin_, length);
  begin_ += length + end_of_line;
  ++number_;
  return true;
}

bool LineReader::next(std::string_view& line) {
  std::size_t searched = 0;  // no line end lies before it, counted from begin_
  for (;;) {
    const char* data = buffer_.data();
    next_lf_ = std::max(next_lf_, begin_);
    if (next_lf_ < end_ && data[next_lf_] != '\n') {
      const void* found = std::memchr(data + next_lf_, '\n', end_ - next_lf_);
      next_lf_ = found == nullptr ? end_ : static_cast<std::size_t>(static_cast<const char*>(found) - data);
    }
    const std::size_t from = begin_ + searched;
    const void* cr = std::memchr(data + from, '\r', next_lf_ - from);
    if (cr != nullptr) {
      const auto at = static_cast<std::size_t>(static_cast<const char*>(cr) - data);
      // Whether LF belongs to a CR at the end of what has been read is not known yet.
      if (at + 1 < end_ || at_end_) return give(at - begin_, at + 1 == next_lf_ && next_lf_ < end_ ? 2 : 1, line);
      searched = at - begin_;
    } else {
      if (next_lf_ < end_) return give(next_lf_ - begin_, 1, line);
      searched = end_ - begin_;
      // What a broken stream ends with is no whole line.
      if (at_end_ && begin_ < end_ && broken().empty()) return give(end_ - begin_, 0, line);
    }
    if (!refill() && (begin_ == end_ || !broken().empty())) return false;
  }
}

}  // namespace voltlap::plant
