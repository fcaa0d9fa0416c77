// SPDX-License-Identifier: Apache-2.0
// The bytes of a file one after the other: plain, gzip or zstd, told by their first bytes, not by the name.
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <string>

namespace voltlap::plant {

class ByteSource {
 public:
  /// `expected` says in the message what the file should have been. Throws InputError when it cannot be opened.
  ByteSource(const std::string& path, const char* expected);
  ~ByteSource();
  ByteSource(ByteSource&&) noexcept;
  ByteSource& operator=(ByteSource&&) noexcept;

  /// Fills `into` from its beginning; the number of bytes, 0 at the end of the stream or where it breaks off.
  std::size_t read(std::span<char> into);
  /// Why the stream ended before its end, in words; empty when it did not.
  [[nodiscard]] const std::string& broken() const;

 private:
  struct Stream;
  std::unique_ptr<Stream> stream_;
};

}  // namespace voltlap::plant
