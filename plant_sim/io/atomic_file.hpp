// SPDX-License-Identifier: Apache-2.0
// A result file that is there whole or not at all.
#pragma once
#include <cstdio>
#include <string>
#include <string_view>

#include "core/errors.hpp"

struct gzFile_s;

namespace voltlap::plant {

/// Writes beside the target and renames on `commit`; without `commit` nothing stays behind. A name that ends in .gz is
/// compressed. A target that exists and is no regular file (a pipe, /dev/stdout) is written directly; `-` is standard
/// output.
/// A file that this process has read is refused, and so is one that another result of it is being written to, by
/// whatever spelling (InputError). Every other failure throws OutputError, which names the file, the cause and a way
/// out.
class AtomicFile {
 public:
  static constexpr const char* kStandardOutput = "-";

  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view text);
  /// Everything is on the disk, though not yet under its name: of several files none is put in place before all are
  /// complete.
  void complete();
  void commit();

 private:
  [[noreturn]] void fail(const std::string& action);
  void flush();
  void close();
  void forget();

  std::string path_, written_path_, identity_, buffer_;
  std::FILE* file_ = nullptr;
  gzFile_s* gzip_ = nullptr;
  bool direct_ = false;
};

}  // namespace voltlap::plant
