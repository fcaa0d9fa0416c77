// SPDX-License-Identifier: Apache-2.0
#include "replay/replay_result.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace voltlap::plant {
namespace {

template <class Rows, class Field>
double first_known(const Rows& rows, Field field) {
  const auto at = std::find_if(rows.begin(), rows.end(), [&](const ReplayRow& r) { return std::isfinite(r.*field); });
  return at == rows.end() ? kUnknown : (*at).*field;
}

template <class Field>
double last_known(const std::vector<ReplayRow>& rows, Field field) {
  const auto at = std::find_if(rows.rbegin(), rows.rend(), [&](const ReplayRow& r) { return std::isfinite(r.*field); });
  return at == rows.rend() ? kUnknown : (*at).*field;
}

}  // namespace

double ReplayResult::soc_start() const { return first_known(rows, &ReplayRow::soc); }
double ReplayResult::soc_end() const { return last_known(rows, &ReplayRow::soc); }
double ReplayResult::logged_soc_start() const { return first_known(rows, &ReplayRow::logged_soc); }
double ReplayResult::logged_soc_end() const { return last_known(rows, &ReplayRow::logged_soc); }

std::string bms_fault_names(std::uint32_t bits) {
  std::string out;
  for (std::size_t bit = 0; bit < std::size(can::kBmsFaultNames); ++bit) {
    if ((bits >> bit & 1U) == 0) continue;
    out += (out.empty() ? "" : ", ") + std::string(can::kBmsFaultNames[bit]);
  }
  return out;
}

}  // namespace voltlap::plant
