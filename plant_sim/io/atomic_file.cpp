// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>
#include <utility>

#include "core/demand.hpp"
#include "core/input_files.hpp"

namespace voltlap::plant {
namespace {

namespace fs = std::filesystem;

/// The targets of all results that are being written, whatever their spelling.
std::set<std::string>& open_targets() {
  static std::set<std::string> targets;
  return targets;
}

std::string identity(const std::string& path) {
  std::error_code unknown;
  const std::string target = fs::weakly_canonical(fs::absolute(path, unknown), unknown).string();
  return target.empty() ? path : target;
}

constexpr std::size_t kBufferBytes = 1U << 18;
constexpr const char* kFastGzip = "wb4";

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  buffer_.reserve(kBufferBytes);
  if (path_ == kStandardOutput) {
    path_ = "standard output";
    direct_ = true;
    file_ = ::fdopen(::dup(STDOUT_FILENO), "wb");
    if (file_ == nullptr) fail("open");
    return;
  }
  refuse_input_as_output(path_);
  std::error_code ignored;
  const fs::path target(path_);
  if (fs::is_directory(target, ignored)) {
    errno = EISDIR;
    fail("open");
  }
  direct_ = fs::exists(target, ignored) && !fs::is_regular_file(target, ignored);
  if (!direct_) {
    identity_ = identity(path_);
    if (!open_targets().insert(identity_).second) {
      identity_.clear();
      throw InputError(path_, "one file for two results", "a file for each", "Choose another name for one of them");
    }
  }
  written_path_ = direct_ ? path_ : fmt::format("{}.part-{}", path_, ::getpid());
  errno = 0;
  if (path_.ends_with(".gz")) {
    gzip_ = gzopen(written_path_.c_str(), kFastGzip);
  } else {
    file_ = std::fopen(written_path_.c_str(), "wb");
  }
  if (gzip_ == nullptr && file_ == nullptr) fail("open");
}

AtomicFile::~AtomicFile() {
  close();
  forget();
}

void AtomicFile::forget() {
  if (!identity_.empty()) open_targets().erase(identity_);
  identity_.clear();
}

void AtomicFile::close() {
  if (gzip_ != nullptr) gzclose(std::exchange(gzip_, nullptr));
  if (file_ != nullptr) std::fclose(std::exchange(file_, nullptr));
  if (!direct_ && !written_path_.empty()) ::unlink(written_path_.c_str());
  written_path_.clear();
}

void AtomicFile::fail(const std::string& action) {
  const std::string cause = errno != 0 ? std::strerror(errno) : "the compression failed";
  close();
  forget();
  throw OutputError(
      fmt::format("{}: cannot {} this file for the result, found \"{}\"; expected a path in an existing folder that "
                  "you may write to, on a disk with room. Choose another path or make room; nothing was "
                  "left half-written.",
                  path_, action, cause));
}

void AtomicFile::write(std::string_view text) {
  VOLTLAP_DEMAND(gzip_ != nullptr || file_ != nullptr);  // nothing is added to a file that is complete
  buffer_.append(text);
  if (buffer_.size() >= kBufferBytes) flush();
}

void AtomicFile::flush() {
  if (buffer_.empty()) return;
  errno = 0;
  const bool whole = gzip_ != nullptr
                         ? gzwrite(gzip_, buffer_.data(), static_cast<unsigned>(buffer_.size())) > 0
                         : std::fwrite(buffer_.data(), 1, buffer_.size(), file_) == buffer_.size();
  if (!whole) fail("write to");
  buffer_.clear();
}

void AtomicFile::complete() {
  if (gzip_ == nullptr && file_ == nullptr) return;
  flush();
  errno = 0;
  const bool closed = gzip_ != nullptr ? gzclose(std::exchange(gzip_, nullptr)) == Z_OK
                                       : std::fclose(std::exchange(file_, nullptr)) == 0;
  if (!closed) fail("finish");
}

void AtomicFile::commit() {
  complete();
  if (!direct_) refuse_input_as_output(path_);
  errno = 0;
  if (!direct_ && std::rename(written_path_.c_str(), path_.c_str()) != 0) fail("put in place");
  written_path_.clear();
  forget();
}

}  // namespace voltlap::plant
