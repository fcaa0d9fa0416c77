// SPDX-License-Identifier: Apache-2.0
// The DBC files that a recording is decoded with, one or several, as one.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "io/logs/dbc_decoder.hpp"

namespace voltlap::plant {

class DbcSet {
 public:
  /// Throws InputError for a file that is no DBC, and for one identifier that two files define in different ways.
  explicit DbcSet(const std::vector<std::string>& paths);

  [[nodiscard]] bool empty() const { return decoders_.empty(); }
  /// nullptr: in none of the files.
  [[nodiscard]] const CompiledMessage* find(std::uint32_t id) const;
  /// A frame of one of the files that cannot be used, and why; nullptr for none.
  [[nodiscard]] const DbcRefusal* refusal(std::uint32_t id) const;
  [[nodiscard]] const std::vector<std::unique_ptr<DbcFile>>& files() const { return files_; }
  [[nodiscard]] std::size_t most_signals() const;

 private:
  std::vector<std::unique_ptr<DbcFile>> files_;
  std::vector<std::unique_ptr<DbcDecoder>> decoders_;
};

}  // namespace voltlap::plant
