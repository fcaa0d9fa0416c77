// SPDX-License-Identifier: Apache-2.0
// One input given to one reader, and whether it ended as it may: read or refused with an InputError, within 2 s of
// processor time for each megabyte and with less than 50 times its size of memory (64 MB for small ones).
#pragma once
#include <string>
#include <string_view>

#include "fuzz/target.hpp"
#include "io/temporary_folder.hpp"

namespace voltlap::plant {

class Trial {
 public:
  /// What is wrong with how the reader ended; empty when nothing is.
  [[nodiscard]] std::string run(const FuzzTarget& target, std::string_view input);

 private:
  TemporaryFolder folder_;
};

}  // namespace voltlap::plant
