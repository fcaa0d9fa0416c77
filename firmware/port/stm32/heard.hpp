// SPDX-License-Identifier: Apache-2.0
// What the filters of a board's bus let in: the messages of its nodes, sorted by identifier, and behind them a tester's
// questions to each.
#pragma once
#include <cstddef>

#include "base/diagnostic_address.hpp"
#include "can_dbc/tables.hpp"

namespace voltlap::port::stm32 {

struct HeardRows {
  const can::MessageRow* rows = nullptr;
  std::size_t count = 0;
};

namespace heard {

template <std::size_t N>
struct Rows {
  can::MessageRow row[N];
};
template <std::size_t N, class... Address>
constexpr Rows<N + sizeof...(Address)> with_tester(const can::MessageRow (&rows)[N], Address... asked) {
  Rows<N + sizeof...(Address)> out{};
  for (std::size_t i = 0; i < N; ++i) out.row[i] = rows[i];
  std::size_t at = N;
  ((out.row[at++].id = diagnostic_id(asked, kTesterAddress)), ...);
  return out;
}
inline constexpr auto kByBms = with_tester(can::kBmsRx, kBmsAddress);
inline constexpr auto kByMaster = with_tester(can::kMasterRx, kMasterAddress);
inline constexpr auto kByBoth = with_tester(can::kMessages, kBmsAddress, kMasterAddress);

template <std::size_t N>
constexpr HeardRows all(const Rows<N>& rows) {
  return {rows.row, N};
}

}  // namespace heard

[[nodiscard]] inline HeardRows heard_by(bool has_bms, bool has_master) {
  if (!has_bms) return heard::all(heard::kByMaster);
  return has_master ? heard::all(heard::kByBoth) : heard::all(heard::kByBms);
}

}  // namespace voltlap::port::stm32
