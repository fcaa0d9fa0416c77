// SPDX-License-Identifier: Apache-2.0
#include "io/growing_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/errors.hpp"
#include "core/input_files.hpp"

namespace voltlap::plant {
namespace {

void refuse_unreadable(const std::string& path) {
  std::error_code ignored;
  const bool other = path == "-" || (std::filesystem::exists(path, ignored) &&
                                     !std::filesystem::is_regular_file(path, ignored) &&
                                     !std::filesystem::is_directory(path, ignored));
  if (other || path.ends_with(".gz") || path.ends_with(".zst")) {
    throw InputError(path, other ? "no regular file" : "the name of a compressed file",
                     "a plain file: it is read while it grows", "Give a name such as drive.log, and compress it later");
  }
}

}  // namespace

GrowingFile::GrowingFile(std::string path) : path_(std::move(path)) {
  refuse_unreadable(path_);
  refuse_input_as_output(path_);
  file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ >= 0) return;
  throw OutputError(fmt::format("{}: cannot open this file for the recording, found \"{}\"; expected a path in an "
                                "existing folder that you may write to. Choose another path.",
                                path_, std::strerror(errno)));
}

GrowingFile::~GrowingFile() { ::close(file_); }

void GrowingFile::write(std::string_view lines) {
  for (std::string_view rest = lines; !rest.empty();) {
    const ssize_t written = ::write(file_, rest.data(), rest.size());
    if (written >= 0) {
      rest.remove_prefix(static_cast<std::size_t>(written));
      continue;
    }
    if (errno == EINTR) continue;
    const std::string cause = std::strerror(errno);
    const bool cut = ::ftruncate(file_, size_) == 0;
    throw OutputError(fmt::format("{}: cannot write to this recording any more, found \"{}\"; expected a disk with "
                                  "room. What stands in it is kept{}. Make room, or record elsewhere.",
                                  path_, cause, cut ? "" : ", and its last line may be cut"));
  }
  size_ += static_cast<std::int64_t>(lines.size());
}

}  // namespace voltlap::plant
