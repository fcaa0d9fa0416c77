// SPDX-License-Identifier: Apache-2.0
#include "codec/rx_monitor.hpp"

#include "base/require.hpp"
#include "codec/seal.hpp"

namespace voltlap::codec {
namespace {

bool is_next(const can::MessageRow& row, const RxRow& state, std::uint8_t counter) {
  if (row.protection == can::Protection::kOrionSum) return true;
  const unsigned step = (static_cast<unsigned>(counter) - state.counter) & kCounterMask;
  return step >= 1 && step <= kCounterStepMax;
}

}  // namespace

bool in_time(const can::MessageRow& row, const RxRow& state, Instant now) {
  const std::int32_t age_ms = (now - state.time).ms();
  return age_ms >= 0 && age_ms < row.timeout_ms;
}

// BMS-001: a frame that is late, repeated or damaged refreshes nothing.
RxVerdict judge(const can::MessageRow& row, RxRow& state, const Frame& frame, Instant now) {
  VOLTLAP_REQUIRE(frame.id == row.id);
  if (frame.dlc != row.dlc) return RxVerdict::kWrongLength;
  if (!sealed_ok(row, frame)) return RxVerdict::kCorrupt;
  const std::uint8_t counter = counter_of(row, frame);
  const bool known = state.sync != RxRow::Sync::kNever && in_time(row, state, now);
  if (!known || (state.sync == RxRow::Sync::kFirst && !is_next(row, state, counter))) {
    state = RxRow{now, counter, RxRow::Sync::kFirst};
    return RxVerdict::kResynchronising;
  }
  if (!is_next(row, state, counter)) return RxVerdict::kNotNew;
  state = RxRow{now, counter, RxRow::Sync::kSynchronised};
  return RxVerdict::kAccepted;
}

bool fresh(const can::MessageRow& row, const RxRow& state, Instant now) {
  return state.sync == RxRow::Sync::kSynchronised && in_time(row, state, now);
}

}  // namespace voltlap::codec
