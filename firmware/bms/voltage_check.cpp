// SPDX-License-Identifier: Apache-2.0
#include "bms/voltage_check.hpp"

#include "base/require.hpp"
#include "bms/slow_mean.hpp"
#include "bms/state.hpp"

namespace voltlap::bms {
namespace {

constexpr std::int64_t kOne = 1'000'000;
constexpr std::int64_t kCountPpm = 750'000;  // of one cell's share: 3.1 % with 24 cells, a missing one is 4.2 %
constexpr std::int64_t kGainPpm = 10'000;    // 1 %, a sound channel; beyond 75 cells a wrong count hides in it
constexpr Duration kSteady = Duration::from_ms(400);   // longer than the age of the oldest cell, 300 ms
constexpr std::int64_t kSteadyShare = 4;               // of a cell: what the current may have moved the pack
constexpr std::int64_t kContactPercent = 15;           // of the pack's resistance: contacts and fuse, chosen
constexpr Duration kLasting = Duration::from_ms(200);  // what a lag between the channels shows at a step is over
constexpr Duration kLate = Duration::from_ms(250);     // about what the cells' channels may lag the pack's
constexpr Duration kGainMemory = Duration::from_ms(1'000);
constexpr std::int64_t kStillPerCell = 50;   // [0.1 mV] 5 mV: a channel of 24 cells in steps of 0.1 V still moves
constexpr std::int64_t kMovesPerCell = 200;  // 20 mV, as for a current that is frozen
constexpr Duration kLagsOver = Duration::from_ms(1'000);  // three times what channels lag each other

std::int64_t size(std::int64_t x) { return x < 0 ? -x : x; }

void learn_gain(const Config& config, State& s) {
  VoltageCheck& c = s.voltage_check;
  const std::int64_t sum = s.pack.cell_sum.raw();
  if (sum <= 0) return;
  const std::int64_t ratio = std::int64_t{s.pack.sum_by_pack.raw()} * kOne / sum;
  const std::int64_t known = c.gain_known ? c.gain.raw() : ratio;
  c.gain = Ratio::saturated(follow(known, ratio, share_of(Duration::from_ms(10), kGainMemory)));
  c.gain_known = true;
  const std::int64_t most = kCountPpm / config.cells_in_series;
  c.count_wrong = size(std::int64_t{c.gain.raw()} - kOne) > (most > kGainPpm ? most : kGainPpm);
}

void follow_steadiness(const Config& config, Instant now, State& s) {
  VoltageCheck& c = s.voltage_check;
  const Current moved = s.measured.current.value - c.steady_at;
  // In 0.1 mV: mA uOhm are nV.
  const std::int64_t by_current = size(moved.raw()) * s.cell_resistance.raw() / 100'000 * config.cells_in_series;
  if (by_current * kSteadyShare > s.pack.cell_sum.raw() / config.cells_in_series) {
    c.steady_at = s.measured.current.value;
    c.steady_since = now;
  }
  c.steady = now - c.steady_since >= kSteady;
}

struct Range {
  std::int64_t low, high;
};

Range between(std::int64_t a, std::int64_t b) { return a < b ? Range{a, b} : Range{b, a}; }

// Between what both say now and what they said a while ago; 0 where these ranges overlap.
std::int64_t gap(Range a, Range b) {
  if (a.low > b.high) return a.low - b.high;
  return b.low > a.high ? b.low - a.high : 0;
}

// BMS-022: the channels of cells and pack may lag each other, so that every step of the current shows. What they show
// of fast ones goes both ways and has no mean; of slow ones, each lies between what the other says and has said.
void follow_difference(const Config& config, Duration elapsed, State& s) {
  VoltageCheck& c = s.voltage_check;
  const std::int64_t by_pack = s.pack.sum_by_pack.raw(), sum = s.pack.cell_sum.raw();
  const std::int64_t late = share_of(elapsed, kLate, c.late_share);
  c.pack_late = c.watched ? follow(c.pack_late, by_pack, late) : by_pack;
  c.sum_late = c.watched ? follow(c.sum_late, sum, late) : sum;
  c.apart = follow(c.apart, by_pack - sum, share_of(elapsed, kLasting, c.share));
  const std::int64_t without_lag = gap(between(by_pack, c.pack_late), between(sum, c.sum_late));
  const std::int64_t least = size(c.apart) < without_lag ? size(c.apart) : without_lag;
  c.lasting = least * 2'000'000 >= by_pack * config.voltage_mismatch.raw();
}

// BMS-069: as both were read in the same steps.
void follow_stillness(const Config& config, Instant now, State& s) {
  VoltageCheck& c = s.voltage_check;
  const std::int64_t cells = config.cells_in_series;
  const PackVoltage by_pack = s.pack.sum_by_pack, sum = s.pack.cell_sum;
  if (!c.watched || size(std::int64_t{by_pack.raw()} - c.still_at.raw()) > kStillPerCell * cells) {
    c.watched = true;
    c.still_at = by_pack;
    c.still_since = now;
  }
  if (now - c.still_since < kLagsOver) c.still_sum = sum;
  c.frozen = size(std::int64_t{sum.raw()} - c.still_sum.raw()) > kMovesPerCell * cells;
}

}  // namespace

// BMS-062, BMS-063
void check_pack_voltage(const Config& config, Instant now, Duration elapsed, State& s) {
  VOLTLAP_REQUIRE(config.cells_in_series > 0);
  VoltageCheck& c = s.voltage_check;
  c.steady = false;
  if (!s.pack.cells_good || !s.measured.pack_voltage.good() || !s.measured.current.good()) return;
  if (s.measured.some_bled) return;  // BMS-055: the sum is too low
  follow_difference(config, elapsed, s);
  follow_stillness(config, now, s);
  follow_steadiness(config, now, s);
  if (!s.contactors.closed_once) learn_gain(config, s);
  if (!c.steady || !c.gain_known || c.count_wrong) return;
  const std::int64_t sum = s.pack.cell_sum.raw();
  const std::int64_t apart = std::int64_t{s.pack.sum_by_pack.raw()} * kOne / c.gain.raw() - sum;
  const std::int64_t drop = size(s.measured.current.value.raw()) * s.cell_resistance.raw() / 100'000;
  const std::int64_t contacts = drop * config.cells_in_series * kContactPercent / 100;
  c.cell_missing = size(apart) > sum / config.cells_in_series + contacts;
}

}  // namespace voltlap::bms
