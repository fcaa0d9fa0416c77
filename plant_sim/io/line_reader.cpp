// SPDX-License-Identifier: Apache-2.0
#include "io/line_reader.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/input_files.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kBuffer = std::size_t{1} << 18;
constexpr std::size_t kLongestLine = std::size_t{1} << 20;

}  // namespace

LineReader::LineReader(const std::string& path, const char* expected)
    : path_(path), file_(gzopen(path.c_str(), "rb"), gzclose), buffer_(kBuffer) {
  const int cause = errno;
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(path, ignored);
  if (!file_ || folder) {
    throw InputError(path, folder ? "a folder" : std::string("no file that can be opened: ") + std::strerror(cause),
                     expected, "Check the path and that you may read it");
  }
  note_input(path);
  gzbuffer(file_.get(), kBuffer);
}

std::string LineReader::place() const {
  return fmt::format("{}:{}", path_, number_);
}

bool LineReader::refill() {
  VOLTLAP_DEMAND(begin_ <= end_ && end_ <= buffer_.size());
  if (at_end_) return false;
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  if (end_ == buffer_.size()) {
    if (end_ >= kLongestLine) {
      throw InputError(fmt::format("{}:{}", path_, number_ + 1), "a line beyond 1 MB", "lines of text",
                       "Check that this is the recording you meant");
    }
    buffer_.resize(2 * buffer_.size());
  }
  const int got = gzread(file_.get(), buffer_.data() + end_, static_cast<unsigned>(buffer_.size() - end_));
  if (got < 0) {
    throw InputError(path_, "a gzip stream that breaks off or is damaged, or no file", "a whole file",
                     "Copy or compress the recording again");
  }
  at_end_ = got == 0;
  end_ += static_cast<std::size_t>(got);
  return !at_end_;
}

bool LineReader::next(std::string_view& line) {
  std::size_t searched = 0;
  for (;;) {
    const char* from = buffer_.data() + begin_;
    const auto* found = static_cast<const char*>(std::memchr(from + searched, '\n', end_ - begin_ - searched));
    if (found != nullptr || (at_end_ && begin_ < end_)) {
      const std::size_t length = found != nullptr ? static_cast<std::size_t>(found - from) : end_ - begin_;
      line = std::string_view(from, length);
      if (line.ends_with('\r')) line.remove_suffix(1);
      begin_ += length + (found != nullptr ? 1 : 0);
      ++number_;
      return true;
    }
    searched = end_ - begin_;
    if (!refill() && begin_ == end_) return false;
  }
}

}  // namespace voltlap::plant
