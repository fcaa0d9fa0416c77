// SPDX-License-Identifier: Apache-2.0
#include "codec/rx_monitor.hpp"

#include "base/require.hpp"
#include "base/units.hpp"
#include "codec/seal.hpp"

namespace voltlap::codec {
namespace {

// The first frame that is known may have been late by so much; after so many frames the earliest is known.
constexpr std::int32_t kSettlingSlackCycles = 4;
constexpr std::uint8_t kSettlingFrames = 16;
constexpr std::int32_t kLateMaxCycles = 8;
constexpr std::int32_t kForgetUsPerMs = 4;  // of lateness: 0.4 %, more than two clocks differ by
constexpr std::int32_t kWindowCycles = 8;   // bits of RxRow::foreign_cycles

void count(std::uint16_t& counted) {
  if (counted < 0xFFFF) ++counted;
}

bool same_payload(const RxRow& state, const Frame& frame) {
  for (std::size_t i = 0; i < frame.dlc; ++i) {
    if (state.payload[i] != frame.data[i]) return false;
  }
  return true;
}

std::int32_t step_of(const RxRow& state, std::uint8_t counter) {
  return static_cast<std::uint8_t>(counter - state.counter);
}

bool gap_tells(std::int32_t cycle_ms, const RxRow& state, Instant now) {
  const std::int32_t gap_ms = (now - state.time).ms();
  return state.sync != RxRow::Sync::kNever && gap_ms >= 0 && gap_ms < kGapMaxCycles * cycle_ms;
}

/// The counter has moved on, and no further than the time that has passed allows.
bool continues(std::int32_t cycle_ms, const RxRow& state, std::uint8_t counter, Instant now) {
  if (!gap_tells(cycle_ms, state, now)) return false;
  const std::int32_t step = step_of(state, counter);
  const std::int32_t late_us = ((now - state.time).ms() - step * cycle_ms) * 1000;
  if (step == 0 || (state.contradicted && late_us > cycle_ms * 500)) return false;
  if (step == 1) return true;
  const std::int32_t unsure_us = state.settling > 0 ? kSettlingSlackCycles * cycle_ms * 1000 : cycle_ms * 500;
  return late_us + state.late_us + unsure_us >= 0;
}

void remember(RxRow& state, const Frame& frame, std::uint8_t counter, Instant now) {
  state.time = now;
  state.counter = counter;
  for (std::size_t i = 0; i < Frame::kMaxBytes; ++i) state.payload[i] = frame.data[i];
}

void begin(RxRow& state, const Frame& frame, std::uint8_t counter, Instant now) {
  remember(state, frame, counter, now);
  state.sync = RxRow::Sync::kFirst;
  state.late_us = 0;
  state.settling = kSettlingFrames;
}

void follow(std::int32_t cycle_ms, RxRow& state, const Frame& frame, std::uint8_t counter, Instant now) {
  const std::int32_t gap_ms = (now - state.time).ms();
  const std::int32_t later_us = (gap_ms - step_of(state, counter) * cycle_ms) * 1000;
  const std::int32_t late_us = state.late_us - gap_ms * kForgetUsPerMs + later_us;
  const std::int32_t most_us = kLateMaxCycles * cycle_ms * 1000;
  state.late_us = max(min(late_us, most_us), std::int32_t{});
  if (state.settling > 0) --state.settling;
  remember(state, frame, counter, now);
}

/// Again and again within eight cycles: contested.
void note_foreign(std::int32_t cycle_ms, RxRow& state, std::uint8_t counter, Instant now) {
  count(state.counts.foreign);
  const std::int32_t cycles = (now - state.foreign_cycle).ms() / cycle_ms;
  const bool recent = cycles >= 0 && cycles < kWindowCycles;
  state.foreign_cycle = recent ? state.foreign_cycle + Duration::from_ms(cycles * cycle_ms) : now;
  const unsigned before = recent ? static_cast<unsigned>(state.foreign_cycles) << static_cast<unsigned>(cycles) : 0U;
  state.foreign_cycles = static_cast<std::uint8_t>(before | 1U);
  state.contradicted = (recent && state.contradicted) || step_of(state, counter) == 0;
  int found = 0;
  for (unsigned bits = state.foreign_cycles; bits != 0; bits >>= 1U) found += static_cast<int>(bits & 1U);
  if (found < foreign_cycles_max(cycle_ms)) return;
  state.contested = true;
  state.clean = 0;
}

// BMS-004, MST-061: until the counter has gone round once without a jump, none of its frames counts.
RxVerdict judge_contested(std::int32_t cycle_ms, RxRow& state, const Frame& frame, std::uint8_t counter, Instant now) {
  if (!continues(cycle_ms, state, counter, now)) {
    count(state.counts.foreign);  // or the first after a silence: nobody knows
    state.clean = 0;
    begin(state, frame, counter, now);
    return RxVerdict::kForeign;
  }
  state.clean = static_cast<std::uint16_t>(state.clean + step_of(state, counter));
  follow(cycle_ms, state, frame, counter, now);
  if (state.clean < kCleanSteps) return RxVerdict::kResynchronising;
  state.contested = false;
  state.sync = RxRow::Sync::kSynchronised;
  return RxVerdict::kAccepted;
}

RxVerdict judge_counted(const can::MessageRow& row, std::int32_t cycle_ms, RxRow& state, const Frame& frame,
                        Instant now) {
  const std::uint8_t counter = counter_of(row, frame);
  if (state.sync != RxRow::Sync::kNever && same_payload(state, frame)) {
    count(state.counts.copies);
    return RxVerdict::kCopy;
  }
  const bool quiet = (now - state.heard).ms() < 0 || (now - state.heard).ms() >= row.timeout_ms;
  state.heard = now;
  if (state.contested) return judge_contested(cycle_ms, state, frame, counter, now);
  if (continues(cycle_ms, state, counter, now)) {
    follow(cycle_ms, state, frame, counter, now);
    state.sync = RxRow::Sync::kSynchronised;
    return RxVerdict::kAccepted;
  }
  // A sender that starts anew has been silent before.
  if (quiet || !gap_tells(cycle_ms, state, now)) {
    begin(state, frame, counter, now);
    return RxVerdict::kResynchronising;
  }
  note_foreign(cycle_ms, state, counter, now);
  if (state.contested || state.sync == RxRow::Sync::kFirst) begin(state, frame, counter, now);
  return RxVerdict::kForeign;
}

bool in_time(const can::MessageRow& row, const RxRow& state, Instant now) {
  const std::int32_t age_ms = (now - state.time).ms();
  return age_ms >= 0 && age_ms < row.timeout_ms;
}

/// Without a counter only age tells: the second frame in time is believed.
RxVerdict judge_uncounted(const can::MessageRow& row, RxRow& state, const Frame& frame, Instant now) {
  const bool known = state.sync != RxRow::Sync::kNever && in_time(row, state, now);
  remember(state, frame, 0, now);
  state.sync = known ? RxRow::Sync::kSynchronised : RxRow::Sync::kFirst;
  return known ? RxVerdict::kAccepted : RxVerdict::kResynchronising;
}

}  // namespace

// BMS-001, MST-060: a frame that is late, repeated, damaged or foreign refreshes nothing; it is counted.
RxVerdict judge(const can::MessageRow& row, std::int32_t cycle_ms, RxRow& state, const Frame& frame, Instant now) {
  VOLTLAP_REQUIRE(frame.id == row.id && cycle_ms > 0);
  if (frame.dlc != row.dlc) {
    count(state.counts.wrong_length);
    return RxVerdict::kWrongLength;
  }
  if (!sealed_ok(row, frame)) {
    count(state.counts.corrupt);
    return RxVerdict::kCorrupt;
  }
  if (row.protection != can::Protection::kCounterCrc) return judge_uncounted(row, state, frame, now);
  return judge_counted(row, cycle_ms, state, frame, now);
}

void forget_old(std::int32_t cycle_ms, RxRow& state, Instant now) {
  if (!gap_tells(cycle_ms, state, now)) state.sync = RxRow::Sync::kNever;
  if ((now - state.foreign_cycle).ms() < kWindowCycles * cycle_ms) return;
  state.foreign_cycles = 0;
  state.contradicted = false;
}

bool fresh(const can::MessageRow& row, const RxRow& state, Instant now) {
  return state.sync == RxRow::Sync::kSynchronised && in_time(row, state, now);
}

}  // namespace voltlap::codec
