// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/parts.hpp"

#include <algorithm>

namespace voltlap::plant {
namespace {

std::vector<bool> part_of_blocks(const std::vector<bool>& use, std::size_t blocks, std::size_t parts, std::size_t part,
                                 bool interleaved) {
  std::vector<bool> out(blocks, false);
  std::size_t used = 0, total = 0;
  for (std::size_t b = 0; b < blocks; ++b) total += use.empty() || use[b] ? 1 : 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    if (!use.empty() && !use[b]) continue;
    const std::size_t mine = interleaved ? used % parts : used * parts / std::max<std::size_t>(1, total);
    out[b] = mine == part;
    ++used;
  }
  return out;
}

}  // namespace

std::vector<bool> blocks_used(const std::string& which, std::size_t blocks) {
  std::vector<bool> use;
  if (which == "all") return use;
  for (std::size_t b = 0; b < blocks; ++b) use.push_back((b % 2 == 0) == (which == "even"));
  return use;
}

std::vector<bool> rows_of_blocks(const Design& design, const std::vector<bool>& use) {
  std::vector<bool> rows;
  if (use.empty()) return rows;
  for (const std::size_t b : block_of_rows(design.comparison.log.time_s)) rows.push_back(use[b]);
  return rows;
}

Parts parts_of(const Design& design, const std::vector<Candidate>& locals, const Score& score, const Usual& usual,
               const std::vector<Cause>& causes, const std::vector<bool>& use) {
  Parts out;
  const auto system = [&](std::size_t parts, std::size_t part, bool interleaved) {
    return system_of(design, locals, score, usual, causes, part_of_blocks(use, score.blocks(), parts, part, interleaved));
  };
  for (std::size_t part = 0; part < 4; ++part) out.quarters.push_back(system(4, part, true));
  for (std::size_t part = 0; part < 2; ++part) out.halves.push_back(system(2, part, false));
  return out;
}

System all_but(const std::vector<System>& quarters, std::size_t left_out) {
  System out = quarters[left_out == 0 ? 1 : 0];
  for (std::size_t k = left_out == 0 ? 2 : 1; k < quarters.size(); ++k) {
    if (k == left_out) continue;
    out.information += quarters[k].information;
    out.score += quarters[k].score;
  }
  return out;
}

}  // namespace voltlap::plant
