// SPDX-License-Identifier: Apache-2.0
// A log in parts: which blocks are fitted, and the same system from every fourth block and from each half of them.
#pragma once
#include <string>
#include <vector>

#include "discrepancy/candidates.hpp"

namespace voltlap::plant {

/// Blocks to fit: `which` is all, even or odd. Empty: all.
[[nodiscard]] std::vector<bool> blocks_used(const std::string& which, std::size_t blocks);

/// Rows of these blocks. Empty: all.
[[nodiscard]] std::vector<bool> rows_of_blocks(const Design& design, const std::vector<bool>& use);

struct Parts {
  std::vector<System> quarters;  ///< every fourth block that is used
  std::vector<System> halves;    ///< first and second
};
[[nodiscard]] Parts parts_of(const Design& design, const std::vector<Candidate>& locals, const Score& score,
                             const Usual& usual, const std::vector<Cause>& causes, const std::vector<bool>& use);

/// All quarters together but one.
[[nodiscard]] System all_but(const std::vector<System>& quarters, std::size_t left_out);

}  // namespace voltlap::plant
